"""Boxes at packing stations: how many orders may be split, and which station an order is bound for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, PackingStation, WarehouseView

MOST_WORK = "Seconds of work for each packer, with all orders bound for packing stations, above which no order is split"
"""Meaning of the parameter ``packing_work_s`` of rules."""


def room_to_split(warehouse: WarehouseView, capacity: int | None, most_work_s: float = 0.0) -> int | None:
    """Return how many more orders may be split now; None for any number.

    Parameters
    ----------
    warehouse
        The warehouse: each split order takes a free box, where there are packing stations.
    capacity
        A rule's own limit of split orders that are open, those already open included; None: it has none.
    most_work_s
        How much work packers may have for an order to be split, as `packing_work_s` counts it; 0: any.
    """
    rooms = [] if capacity is None else [max(capacity - warehouse.split_orders_open, 0)]
    if most_work_s and packing_work_s(warehouse) > most_work_s:
        rooms.append(0)
    free = warehouse.free_boxes
    # Each order takes a slot of a station: where there are no more of these than boxes, boxes limit nothing
    if free is not None and free < sum(station.free_capacity for station in warehouse.stations):
        rooms.append(free)
    return min(rooms, default=None)


def packing_work_s(warehouse: WarehouseView) -> float:
    """Return the seconds of work for each packer and sorter with the orders that are bound for packing stations.

    An order that is not packed counts as a whole: its items are packed and, if it is split, put into a box from one
    tote. Parts of it that are on their way or not even assigned count too, so that the figure rises with the decision.
    """
    work_s, crew = 0.0, 0
    for station in warehouse.packing_stations:
        one, orders = station.section, station.orders
        whole, split = [order.items for order in orders], [order.items for order in orders if order.split]
        work_s += one.pack_s * len(whole) + one.pack_item_s * sum(whole)
        work_s += one.tote_s * len(split) + one.put_s * sum(split)
        crew += one.packers + one.sorters
    return work_s / crew if crew else 0.0


def bound_for(
    warehouse: WarehouseView, orders: Sequence[Order], cost: Callable[[Order, PackingStation], float]
) -> list[int]:
    """Return the packing station of each order: the one with the lowest cost, of equals the one with the least load.

    The load is boxes reserved for a split order, which goes where one is free, and orders bound for it for any other;
    of equals, the other of these, then the id. Each order counts for the next.
    """
    stations = warehouse.packing_stations
    free = [station.free_boxes for station in stations]
    bound = [len(station.orders) for station in stations]
    chosen = []
    for order in orders:
        able = []
        for at, station in enumerate(stations):
            if free[at] > 0 or not order.split:
                load = station.section.boxes - free[at], bound[at]
                able.append((cost(order, station), *(load if order.split else load[::-1]), at))
        best = min(able)[-1]
        free[best] -= order.split
        bound[best] += 1
        chosen.append(best)
    return chosen
