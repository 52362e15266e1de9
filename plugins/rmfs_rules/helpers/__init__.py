"""Loops and look-ups that several rules share, for authors of rules.

Nothing here changes the warehouse: the functions work on what the view shows and keep their own account of what the
decision under construction takes up.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_rules.helpers.bundles import StoragePods, cheapest, store_bundles
from rmfs_rules.helpers.late import OVERSIZE_WAIT_S, station_to_keep
from rmfs_rules.helpers.pairs import assign_best_pairs, pod_at, waiting_limit
from rmfs_rules.helpers.sending import send_pods

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, Station, WarehouseView

__all__ = [
    "OVERSIZE_WAIT_S",
    "StoragePods",
    "assign_best_pairs",
    "cheapest",
    "items_per_order",
    "nearest_free_location",
    "pod_at",
    "send_pods",
    "station_to_keep",
    "store_bundles",
    "sum_per_order",
    "ticks_to_station",
    "waiting_limit",
]


def items_per_order(warehouse: WarehouseView) -> NDArray[np.int64]:
    """Return how many items each order of the backlog has open, by position in the backlog."""
    return sum_per_order(warehouse, warehouse.backlog_lines.quantity)


def sum_per_order(warehouse: WarehouseView, line_values: NDArray[np.int64]) -> NDArray[np.int64]:
    """Add up one value per open line to one value per order of the backlog, by position in the backlog."""
    sums = np.bincount(warehouse.backlog_lines.order, weights=line_values, minlength=len(warehouse.backlog))
    return sums.astype(np.int64)


def ticks_to_station(warehouse: WarehouseView, pod: Pod, station: Station) -> int:
    """Return the shortest loaded driving time from where a pod is to a station, whatever way its robot will face."""
    return int(warehouse.travel.times_to(station.cell, True)[pod.cell].min())


def nearest_free_location(warehouse: WarehouseView, pod: Pod, among: NDArray[np.int64] | None = None) -> int:
    """Return the storage location with the shortest driving time for the robot that carries a pod.

    Of the free ones, or of those ``among`` them (cells, ascending). Ties go to the lowest cell index.
    """
    assert pod.robot is not None, "the pod is being carried"
    cells = np.array(warehouse.free_storage_locations) if among is None else among
    times = warehouse.travel.times_from(pod.cell, warehouse.robots[pod.robot].heading, True)
    return int(cells[times[cells].argmin()])
