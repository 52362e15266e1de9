"""Loops and look-ups that several rules share, for authors of rules.

Nothing here changes the warehouse: the functions work on what the view shows and keep their own account of what the
decision under construction takes up.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_core.decisions import OrderAssignment, PodTrip

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, Station, WarehouseView

__all__ = [
    "assign_best_pairs",
    "lines_at",
    "nearest_free_location",
    "send_pods",
    "sum_per_order",
    "ticks_to_station",
]

DOES_NOT_FIT = -1


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
) -> list[OrderAssignment]:
    """Assign whole orders greedily: again and again the pair of order and station with the highest score.

    Only pairs that fit are considered; ties go to the oldest order, then to the lowest station load, then to the lowest
    station id. It ends when nothing fits any more.

    :param warehouse: the warehouse now.
    :param score: scores (>= 0) of all orders of the backlog at a station, by position in the backlog.
    :param assigned: told of each assignment (station, position of the order in the backlog) before the next one is
        chosen; returns the ids of the stations whose scores it changes. Left out: scores stay.
    :return: the assignments in the order in which they were chosen.
    """
    stations = [station for station in warehouse.stations if station.free_capacity > 0]
    if not stations or not warehouse.backlog:
        return []
    items = sum_per_order(warehouse, warehouse.backlog_lines.quantity)
    sizes = np.column_stack([np.ones_like(items) if station.counts_orders else items for station in stations])
    free = np.array([station.free_capacity for station in stations])
    load = [station.load for station in stations]
    unassigned = np.ones(len(items), dtype=bool)
    scores = np.where(sizes <= free, np.column_stack([score(station) for station in stations]), DOES_NOT_FIT)
    chosen = []
    while (best := scores.flat[first := int(scores.argmax())]) > DOES_NOT_FIT:
        position = first // len(stations)
        tied = np.flatnonzero(scores[position] == best)
        column = min((int(column) for column in tied), key=lambda column: (load[column], stations[column].id))
        station = stations[column]
        chosen.append(OrderAssignment(warehouse.backlog[position].id, station.id))
        load[column] += int(sizes[position, column])
        free[column] -= sizes[position, column]
        unassigned[position] = False
        scores[position] = DOES_NOT_FIT
        scores[sizes[:, column] > free[column], column] = DOES_NOT_FIT
        changed = set(assigned(station, position)) if assigned is not None else ()
        for other, changed_station in enumerate(stations):
            if changed_station.id in changed:
                fits = unassigned & (sizes[:, other] <= free[other])
                scores[:, other] = np.where(fits, score(changed_station), DOES_NOT_FIT)
    return chosen


def send_pods(
    warehouse: WarehouseView, max_fetches: int, choose: Callable[[Station, Sequence[Pod]], Pod]
) -> list[PodTrip]:
    """Select pods one after another until every uncovered request is served or no candidate can help.

    The station with the fewest inbound pods is next, then the one with most uncovered requests, then the lowest id:
    robots are scarce, and a station without pods idles. Candidates are stored pods bound nowhere, at most
    ``max_fetches`` of them, and pods that are about to leave a station.

    :param warehouse: the warehouse now.
    :param max_fetches: how many stored pods may be sent.
    :param choose: picks one of the pods, given by id, each of which serves an uncovered request of the station.
    :return: the trips in the order in which they were chosen.
    """
    stored = {pod.id for pod in warehouse.free_pods} if max_fetches > 0 else set()
    leaving = {pod.id for pod in warehouse.leaving_pods}
    inbound = {station.id: len(station.inbound_pods) for station in warehouse.stations}
    uncovered = {
        station.id: Counter(request.sku for request in station.uncovered_requests) for station in warehouse.stations
    }
    needy = {station.id for station in warehouse.stations if uncovered[station.id]}
    trips: list[PodTrip] = []
    while needy:
        identifier = min(needy, key=lambda i: (inbound[i], -uncovered[i].total(), i))
        station = warehouse.stations[identifier]
        candidates = _servers(warehouse, station, uncovered[identifier], stored | leaving)
        if not candidates:
            needy.remove(identifier)
            continue
        pod = choose(station, candidates)
        trips.append(PodTrip(pod.id, identifier))
        inbound[identifier] += 1
        uncovered[identifier] -= Counter({sku: pod.free_items(sku) for sku in pod.contents})
        if not uncovered[identifier]:
            needy.remove(identifier)
        if pod.id in stored:
            max_fetches -= 1
        stored = stored - {pod.id} if max_fetches > 0 else set()
        leaving.discard(pod.id)
    return trips


def _servers(warehouse: WarehouseView, station: Station, skus: Iterable[int], usable: set[int]) -> list[Pod]:
    """Return the usable pods, by id, that hold a free item of one of the SKUs and are not bound for the station."""
    found = {
        pod.id: pod
        for sku in skus
        for pod in warehouse.pods_with(sku)
        if pod.id in usable and station.id not in pod.bound_for and pod.free_items(sku) > 0
    }
    return [found[identifier] for identifier in sorted(found)]


def ticks_to_station(warehouse: WarehouseView, pod: Pod, station: Station) -> int:
    """Return the shortest loaded driving time from where a pod is to a station, whatever way its robot will face."""
    return int(warehouse.travel.times_to(station.cell, True)[pod.cell].min())


def nearest_free_location(warehouse: WarehouseView, pod: Pod) -> int:
    """Return the free storage location with the shortest driving time for the robot that carries a pod.

    Ties go to the lowest cell index.
    """
    assert pod.robot is not None, "the pod is being carried"
    heading = warehouse.robots[pod.robot].heading
    free = np.asarray(warehouse.free_storage_locations)
    return int(free[warehouse.travel.times_from(pod.cell, heading, True)[free].argmin()])
