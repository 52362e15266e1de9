"""What is there when a run begins: the grid, its travel times, and the instance of orders, pods and SKUs."""

from rmfs_core.world.block import block_map
from rmfs_core.world.csv_files import Calendar, read_instance
from rmfs_core.world.grid import EAST, NORTH, SOUTH, STEPS, WEST, CellKind, Layout, StationCells
from rmfs_core.world.instance import BundleData, Instance, OrderData, PodData
from rmfs_core.world.instance_making import make_instance
from rmfs_core.world.layout_making import check_layout, make_layout, reached
from rmfs_core.world.textmap import check_size, parse_map

__all__ = [
    "EAST",
    "NORTH",
    "SOUTH",
    "STEPS",
    "WEST",
    "BundleData",
    "Calendar",
    "CellKind",
    "Instance",
    "Layout",
    "OrderData",
    "PodData",
    "StationCells",
    "block_map",
    "check_layout",
    "check_size",
    "make_instance",
    "make_layout",
    "parse_map",
    "reached",
    "read_instance",
]
