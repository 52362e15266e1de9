"""Activation rule ``the-rule``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define, field, validators
from rmfs import hookimpl

if TYPE_CHECKING:
    from rmfs.warehouse import WarehouseView


@define
class TheRule:
    """Activate the largest stations, one for every so many orders in the backlog.

    With a backlog of n orders max(1, n / ``orders``, rounded up) stations are active, those with the highest capacity
    first (ties: lowest id), and stations that still have something to do. A station is open when it is active and its
    timetable has it open.

    Parameters
    ----------
    orders
        Orders of the backlog for one station.
    """

    orders: int = field(default=10, validator=validators.ge(1))

    @hookimpl
    def activate_stations(self, warehouse: WarehouseView) -> Sequence[int]:
        """Activate as many as the backlog is worth."""
        staffed = [station for station in warehouse.stations if station.staffed]
        staffed.sort(key=lambda station: (-station.capacity, station.id))
        number = max(1, -(-len(warehouse.backlog) // self.orders))
        return [station.id for place, station in enumerate(staffed) if place < number or station.load]
