"""The start of a run: the grid, its travel times, and the instance of orders, pods and SKUs."""

from typing import Any

from rmfs_core.world.grid import EAST, NORTH, SOUTH, STEPS, WEST, CellKind, Layout, StationCells, check_size
from rmfs_core.world.instance import BundleData, Instance, OrderData, PodData
from rmfs_core.world.instance_making import make_instance, reader
from rmfs_core.world.layout_making import check_layout, make_layout

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
    "read_instance",
]


def __getattr__(name: str) -> Any:
    """Return `Calendar` or `read_instance`, of the format that is plugged in."""
    if name in ("Calendar", "read_instance"):
        return getattr(reader(), name)
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
