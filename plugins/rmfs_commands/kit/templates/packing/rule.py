"""Packing rule ``the-rule``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define, field, validators
from rmfs import hookimpl

if TYPE_CHECKING:
    from rmfs.warehouse import Order, WarehouseView


@define
class TheRule:
    """Send an order to the packing station with the least work ahead of it.

    The work is the items of the orders that are bound for it and not packed, and ``order_items`` for each of these
    orders. A split order goes where a box is free. Ties go to the lowest id.

    Parameters
    ----------
    order_items
        Items that an order counts for in addition to its own.
    """

    order_items: float = field(default=6.0, validator=validators.ge(0))

    @hookimpl
    def assign_packing(self, warehouse: WarehouseView, orders: Sequence[Order]) -> Sequence[int]:
        """Choose for one order after another; each counts for the next."""
        stations = warehouse.packing_stations
        free = [station.free_boxes for station in stations]
        work = [sum(order.items + self.order_items for order in station.orders) for station in stations]
        chosen = []
        for order in orders:
            able = [at for at in range(len(stations)) if free[at] > 0 or not order.split]
            best = min(able, key=lambda at: (work[at], at))
            free[best] -= order.split
            work[best] += order.items + self.order_items
            chosen.append(best)
        return chosen
