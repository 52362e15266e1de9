"""Loops and look-ups that several rules share, for authors of rules.

Nothing here changes the warehouse: the functions work on what the view shows and keep their own account of what the
decision under construction takes up.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import field, validators
from numpy.typing import NDArray

from rmfs_core.decisions import OrderAssignment
from rmfs_rules.helpers.bundles import KeptSpace, StoragePods, cheapest, store_bundles
from rmfs_rules.helpers.pod_sending import send_pods

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, Pod, Station, WarehouseView

__all__ = [
    "OVERSIZE_WAIT_S",
    "KeptSpace",
    "StoragePods",
    "assign_best_pairs",
    "cheapest",
    "items_per_order",
    "largest_capacity",
    "lines_at",
    "nearest_free_location",
    "pod_at",
    "send_pods",
    "store_bundles",
    "sum_per_order",
    "ticks_to_station",
    "waiting_limit",
]

DOES_NOT_FIT = -1

OVERSIZE_WAIT_S = 600.0
"""How long an order that is larger than any station waits for an empty one before one is emptied for it, by default."""


def waiting_limit() -> Any:
    """Return the parameter ``max_wait_s`` of a rule that assigns orders with `assign_best_pairs`."""
    return field(
        default=None,
        validator=validators.optional(validators.ge(0)),
        metadata={
            "doc": "Seconds in the backlog after which an order goes first; while it fits nowhere, the station with "
            "most room of those that could take it takes nothing else. Left out: never, but for orders larger than any "
            f"station, after {OVERSIZE_WAIT_S:g} s, one at a time"
        },
    )


def largest_capacity(warehouse: WarehouseView) -> float:
    """Return the items that the largest station can take; without limit where one counts orders."""
    return max(
        (math.inf if station.counts_orders else station.capacity for station in warehouse.stations), default=math.inf
    )


def items_per_order(warehouse: WarehouseView) -> NDArray[np.int64]:
    """Return how many items each order of the backlog has open, by position in the backlog."""
    return sum_per_order(warehouse, warehouse.backlog_lines.quantity)


def sum_per_order(warehouse: WarehouseView, line_values: NDArray[np.int64]) -> NDArray[np.int64]:
    """Add up one value per open line to one value per order of the backlog, by position in the backlog."""
    sums = np.bincount(warehouse.backlog_lines.order, weights=line_values, minlength=len(warehouse.backlog))
    return sums.astype(np.int64)


def lines_at(warehouse: WarehouseView, position: int) -> slice:
    """Return where the open lines of the order at a position of the backlog are in ``warehouse.backlog_lines``."""
    order = warehouse.backlog_lines.order
    return slice(int(order.searchsorted(position)), int(order.searchsorted(position + 1)))


def assign_best_pairs(
    warehouse: WarehouseView,
    score: Callable[[Station], NDArray[np.int64]],
    assigned: Callable[[Station, int], Iterable[int]] | None = None,
    *,
    max_wait_s: float | None = None,
    rank: NDArray[np.generic] | None = None,
    first: NDArray[np.bool_] | None = None,
    prefer: Callable[[int, Station], int] | None = None,
    fast_lane: int = 0,
) -> list[OrderAssignment]:
    """Assign whole orders greedily: again and again the pair of order and station with the highest score.

    Only pairs that fit are considered; ties go to the oldest order, then to the lowest station load, then to the lowest
    station id. It ends when nothing fits any more. An order that is larger than any station fits an empty one. Orders
    that have waited too long go first, oldest first; each that fits nowhere keeps one station, that with most room of
    those that could take it, from taking anything else.

    Parameters
    ----------
    warehouse
        The warehouse now.
    score
        Scores (>= 0) of all orders of the backlog at a station, by position in the backlog.
    assigned
        Told of each assignment (station, position of the order in the backlog) before the next one is chosen; returns
        the ids of the stations whose scores it changes. Left out: scores stay.
    max_wait_s
        How long an order may wait. Left out: as long as it takes, but for an order that is larger than any station,
        which waits `OVERSIZE_WAIT_S`; of these one at a time keeps a station.
    rank
        Which of two orders with the same score goes first, by position in the backlog: the lower one. Left out: the
        older one.
    first
        Orders that go before all others, whatever their scores, by position in the backlog.
    prefer
        Which of the stations with an order's highest score takes it (position of the order, station): the lowest, ties
        as told above.
    fast_lane
        Places that a station with something to do keeps for orders which the pod that is there can complete.

    Returns
    -------
    list[OrderAssignment]
        The assignments in the order in which they were chosen.
    """
    stations = [station for station in warehouse.stations if station.free_capacity > 0 or station.counts_orders]
    if not stations or not warehouse.backlog:
        return []
    items = items_per_order(warehouse)
    oversize = items > largest_capacity(warehouse)
    sizes = np.column_stack([_sizes_at(warehouse, station, items, oversize) for station in stations])
    free = np.array([station.free_capacity for station in stations])
    load = [station.load for station in stations]
    unassigned = np.ones(len(items), dtype=bool)
    lane = _FastLane(warehouse, fast_lane) if fast_lane else None
    columns = range(len(stations))

    def fits(column: int) -> NDArray[np.bool_]:
        """Whether each order fits a station now."""
        room = lane.room(stations[column], free[column]) if lane is not None and load[column] else free[column]
        fitting: NDArray[np.bool_] = sizes[:, column] <= room
        return fitting

    fitting = np.column_stack([fits(column) for column in columns])
    scores = np.where(fitting, np.column_stack([score(station) for station in stations]), DOES_NOT_FIT)
    chosen: list[OrderAssignment] = []

    def assign(position: int) -> None:
        """Assign an order to the station with the highest score of it."""
        tied = np.flatnonzero(scores[position] == scores[position].max())
        column = min(
            (int(column) for column in tied),
            key=lambda column: (prefer(position, stations[column]) if prefer else 0, load[column], stations[column].id),
        )
        station = stations[column]
        chosen.append(OrderAssignment(warehouse.backlog[position].id, station.id))
        load[column] += int(sizes[position, column])
        free[column] -= sizes[position, column]
        unassigned[position] = False
        scores[position] = DOES_NOT_FIT
        if lane is not None:
            lane.take(station, position)
        for other in columns if lane is not None else (column,):
            scores[~fits(other), other] = DOES_NOT_FIT
        changed = set(assigned(station, position)) if assigned is not None else ()
        for other, changed_station in enumerate(stations):
            if changed_station.id in changed:
                scores[:, other] = np.where(unassigned & fits(other), score(changed_station), DOES_NOT_FIT)

    kept: dict[int, bool] = {}  # stations kept for an order that waits, and whether that is larger than any station
    for position in _late(warehouse, oversize, max_wait_s):
        if scores[position].max() > DOES_NOT_FIT:
            assign(position)
        elif max_wait_s is not None or not any(kept.values()):
            room = dict(zip((station.id for station in stations), free.tolist(), strict=True))
            keep = station_to_keep(warehouse, warehouse.backlog[position], room, kept)
            if keep is not None:
                kept[keep] = bool(oversize[position])
                for column in (column for column, station in enumerate(stations) if station.id == keep):
                    free[column] = 0
                    scores[:, column] = DOES_NOT_FIT
        if len(kept) == len(warehouse.stations):
            break
    while (position := _next_order(scores, rank, first)) != DOES_NOT_FIT:
        assign(position)
    return chosen


def _next_order(scores: NDArray[np.int64], rank: NDArray[np.generic] | None, first: NDArray[np.bool_] | None) -> int:
    """Return the position of the order that goes next; `DOES_NOT_FIT` when none fits."""
    if rank is None and first is None:
        at = int(scores.argmax())
        return at // scores.shape[1] if scores.flat[at] > DOES_NOT_FIT else DOES_NOT_FIT
    best = scores.max(axis=1)
    if first is not None and (best[first] > DOES_NOT_FIT).any():
        best = np.where(first, best, DOES_NOT_FIT)
    if best.max() == DOES_NOT_FIT:
        return DOES_NOT_FIT
    tied = np.flatnonzero(best == best.max())
    return int(tied[0] if rank is None else tied[rank[tied].argmin()])


def station_to_keep(
    warehouse: WarehouseView, order: Order, free: Mapping[int, int], kept: Container[int]
) -> int | None:
    """Return the station with most room of those that could take an order if they took nothing else."""
    room = {station.id: free.get(station.id, 0) for station in warehouse.stations}
    lacking = {
        station.id: warehouse.size_at(order, station) - room[station.id]
        for station in warehouse.stations
        if station.open and station.id not in kept
    }
    able = [i for i in lacking if lacking[i] <= warehouse.stations[i].capacity - room[i]]
    return min(able, key=lambda identifier: (lacking[identifier], identifier), default=None)


class _FastLane:
    """Places that stations keep for what the pods that stand there can complete at once.

    Parameters
    ----------
    warehouse
        The warehouse now.
    places
        How many places each station keeps.
    """

    def __init__(self, warehouse: WarehouseView, places: int) -> None:
        self._warehouse, self._places = warehouse, places
        self._pods = {station.id: pod for station in warehouse.stations if (pod := pod_at(warehouse, station))}
        self._left: dict[int, NDArray[np.int64]] = {}  # pod -> free items by SKU
        for pod in self._pods.values():
            self._left[pod.id] = np.zeros(warehouse.n_skus, np.int64)
            for sku in pod.contents:
                self._left[pod.id][sku] = pod.free_items(sku)

    def room(self, station: Station, free: int) -> NDArray[np.int64]:
        """Places for each order of the backlog at a station with something to do."""
        lines = self._warehouse.backlog_lines
        ordinary = max(free - self._places, 0)
        if station.id not in self._pods:
            return np.full(len(self._warehouse.backlog), ordinary)
        missing = self._left[self._pods[station.id].id][lines.sku] < lines.quantity
        return np.where(sum_per_order(self._warehouse, missing.astype(np.int64)), ordinary, free)

    def take(self, station: Station, position: int) -> None:
        """Take account of an assigned order: pods at or bound for its station may have to serve it."""
        if self._warehouse.unlimited_stock:
            return
        lines = self._warehouse.backlog_lines
        where = lines_at(self._warehouse, position)
        for pod in self._pods.values():
            if station.id in pod.bound_for:
                self._left[pod.id][lines.sku[where]] -= lines.quantity[where]


def pod_at(warehouse: WarehouseView, station: Station) -> Pod | None:
    """Return the pod that stands at a station, not in its queue."""
    if not station.line or station.line[0].cell != station.cell or station.line[0].pod is None:
        return None
    return warehouse.pods[station.line[0].pod]


def _sizes_at(
    warehouse: WarehouseView, station: Station, items: NDArray[np.int64], oversize: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Return `WarehouseView.size_at` of all orders of the backlog."""
    if station.counts_orders:
        if not warehouse.split_orders_open:  # none has a place anywhere
            return np.ones(len(warehouse.backlog), np.int64)
        return np.array([not order.has_place_at(station.id) for order in warehouse.backlog], dtype=np.int64)
    return np.where(oversize, station.capacity, items)


def _late(warehouse: WarehouseView, oversize: NDArray[np.bool_], max_wait_s: float | None) -> list[int]:
    """Return the positions in the backlog of the orders that have waited too long, oldest first."""
    if max_wait_s is None and not oversize.any():
        return []
    arrived_s = np.array([order.arrival_s for order in warehouse.backlog])
    limit_s = np.where(oversize, OVERSIZE_WAIT_S, np.inf) if max_wait_s is None else max_wait_s
    return [int(position) for position in np.flatnonzero(warehouse.now_s - arrived_s >= limit_s)]


def ticks_to_station(warehouse: WarehouseView, pod: Pod, station: Station) -> int:
    """Return the shortest loaded driving time from where a pod is to a station, whatever way its robot will face."""
    return int(warehouse.travel.times_to(station.cell, True)[pod.cell].min())


def nearest_free_location(warehouse: WarehouseView, pod: Pod) -> int:
    """Return the free storage location with the shortest driving time for the robot that carries a pod.

    Ties go to the lowest cell index.
    """
    assert pod.robot is not None, "the pod is being carried"
    heading = warehouse.robots[pod.robot].heading
    free = warehouse.free_storage_locations
    times = warehouse.travel.times_from(pod.cell, heading, True)
    return free[int(times[np.fromiter(free, np.int64, len(free))].argmin())]
