"""Whole orders: one to an empty station, which takes nothing else, and others where no box is free to split them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rmfs_core import JointDecision, OrderAssignment, PodTrip
from rmfs_core.warehouse import BUSY
from rmfs_rules.helpers import items_per_order
from rmfs_rules.helpers.sending import nearest, worth

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, Station, WarehouseView


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
    there, stock = warehouse.available()[station.id], warehouse.stock
    missing, trips = np.zeros(warehouse.n_skus, np.int64), list[PodTrip]()
    for line in order.open_lines:
        missing[line.sku] = max(line.quantity - int(there[line.sku]), 0)
    able = np.flatnonzero((stock.at != BUSY) & (stock.at != station.id))
    while missing.any():
        items = worth(stock, able, missing)
        if not items.any():
            return JointDecision()
        best = nearest(warehouse, stock, able[items == items.max()], station)
        trips.append(PodTrip(best, station.id))
        able = able[able != best]
        entries = slice(*stock.of_pod[best : best + 2].tolist())
        missing[stock.sku[entries]] -= np.minimum(stock.items[entries], missing[stock.sku[entries]])
    return JointDecision([OrderAssignment(order.id, station.id)], trips)
