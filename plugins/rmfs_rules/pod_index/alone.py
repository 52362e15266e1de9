"""Whole orders: one to an empty station, which takes nothing else, and others where no box is free to split them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rmfs_core import JointDecision, OrderAssignment, PodTrip
from rmfs_rules.helpers import items_per_order, ticks_to_station

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, Pod, Station, WarehouseView


def assign_whole(warehouse: WarehouseView, most_pods: int, without: Station | None) -> JointDecision:
    """Assign one order whole: the one of which fewest lines lack a pod at or bound for a station where it fits.

    Of equals the oldest, at the station with the fewest pods. Where ``most_pods`` are, none is sent; ``without`` takes
    nothing now.
    """
    lines, sizes, there = warehouse.backlog_lines, items_per_order(warehouse), warehouse.available()
    able: list[tuple[float, int, int, int]] = []  # missing lines, order, pods, station
    for station in warehouse.stations:
        if station is without or not station.free_capacity:
            continue
        lacking = there[station.id][lines.sku] < lines.quantity
        missing = np.bincount(lines.order, weights=lacking, minlength=len(sizes))
        fits = np.ones(len(sizes), np.bool_) if station.counts_orders else sizes <= station.free_capacity
        pods = len(station.inbound_pods)
        fits &= (missing == 0) | (pods < most_pods)
        able += [(missing[at], at, pods, station.id) for at in np.flatnonzero(fits).tolist()]
    for _, at, _, station_id in sorted(able):
        decided = assign_alone(warehouse, warehouse.backlog[at], warehouse.stations[station_id])
        if decided.assignments:
            return decided
    return JointDecision()


def assign_alone(warehouse: WarehouseView, order: Order, station: Station) -> JointDecision:
    """Assign all open lines of an order, and send the pods for them; nothing where free items are not enough.

    Pods that are stored or leaving a station are sent: again and again the one with most of the items that are still
    missing; the nearest of equals, then that of the lowest id.
    """
    there = warehouse.available()[station.id]
    missing = {line.sku: max(line.quantity - int(there[line.sku]), 0) for line in order.open_lines}
    movable = {
        pod.id: pod for pod in (*warehouse.free_pods, *warehouse.leaving_pods) if station.id not in pod.bound_for
    }
    holding = {pod.id for sku, number in missing.items() if number for pod in warehouse.pods_with(sku)}
    able = [movable[pod] for pod in sorted(movable.keys() & holding)]
    trips = []

    def items(pod: Pod) -> int:
        """How many of the items that are missing a pod has."""
        return sum(min(pod.free_items(sku), number) for sku, number in missing.items() if sku in pod.contents)

    while any(missing.values()):
        best = min(able, key=lambda pod: (-items(pod), ticks_to_station(warehouse, pod, station), pod.id), default=None)
        if best is None or not items(best):
            return JointDecision()
        trips.append(PodTrip(best.id, station.id))
        able.remove(best)
        for sku, number in missing.items():
            if sku in best.contents:
                missing[sku] = max(number - best.free_items(sku), 0)
    return JointDecision([OrderAssignment(order.id, station.id)], trips)
