"""What is there when a run begins: the grid, its travel times, and the instance of orders, pods and SKUs."""

import importlib

from rmfs_core.world.csv_files import Calendar, read_instance
from rmfs_core.world.grid import EAST, NORTH, SOUTH, STEPS, WEST, CellKind, Layout, StationCells, check_size
from rmfs_core.world.instance import BundleData, Instance, OrderData, PodData
from rmfs_core.world.instance_making import make_instance
from rmfs_core.world.layout_making import check_layout, make_layout, reached

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
    "check_layout",
    "check_size",
    "make_instance",
    "make_layout",
    "reached",
    "read_instance",
]


def __getattr__(name: str) -> object:
    """Return what was here in rmfs 0.1.0, and is a layout's now."""
    if name in ("block_map", "parse_map"):
        return getattr(importlib.import_module("rmfs_commands.layouts"), name)
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
