"""The grid: storage locations, aisles, stations with their queues."""

from rmfs_core.layout.block import block_map
from rmfs_core.layout.check import check_layout
from rmfs_core.layout.grid import EAST, NORTH, SOUTH, STEPS, WEST, CellKind, Layout, StationCells
from rmfs_core.layout.making import make_layout
from rmfs_core.layout.textmap import draw_map, parse_map

__all__ = [
    "EAST",
    "NORTH",
    "SOUTH",
    "STEPS",
    "WEST",
    "CellKind",
    "Layout",
    "StationCells",
    "block_map",
    "check_layout",
    "draw_map",
    "make_layout",
    "parse_map",
]
