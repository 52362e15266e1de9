"""The grid: storage locations, aisles, stations with their queues."""

from rmfs_core.layout.grid import EAST, NORTH, SOUTH, WEST, CellKind, Layout, StationCells

__all__ = ["EAST", "NORTH", "SOUTH", "WEST", "CellKind", "Layout", "StationCells"]
