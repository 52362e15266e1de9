"""POA rule ``the-rule``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define, field, validators
from rmfs import OrderAssignment, hookimpl

if TYPE_CHECKING:
    from rmfs.warehouse import Order, WarehouseView


@define
class TheRule:
    """Assign the smallest order first, to the station with the most free capacity.

    Small orders are done soon and free the station's capacity. So that large ones do not wait forever, orders
    that have waited longer than ``patience_s`` go first, the oldest of them before the others.

    Parameters
    ----------
    patience_s
        How long an order may wait before it goes first (s).
    """

    patience_s: float = field(default=600.0, validator=validators.ge(0))

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView) -> Sequence[OrderAssignment]:
        """Assign orders until none fits."""
        free = {station.id: station.free_capacity for station in warehouse.stations}
        chosen = []
        for order in sorted(warehouse.backlog, key=lambda order: self._rank(order, warehouse.now_s)):
            station = max(warehouse.stations, key=lambda station: (free[station.id], -station.id))
            size = warehouse.size_at(order, station)
            if size <= free[station.id]:
                free[station.id] -= size
                chosen.append(OrderAssignment(order.id, station.id))
        return chosen

    def _rank(self, order: Order, now_s: float) -> tuple[bool, float, int]:
        patient = now_s - order.arrival_s <= self.patience_s
        return patient, order.open_items if patient else order.arrival_s, order.id
