"""Orders that no period of a model can assign: they need a station of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_mip.period.solution import Model
from rmfs_rule_helpers import items_per_order, largest_capacity

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, Station, WarehouseView


@frozen
class Oversize:
    """The oldest such order, and the station that is to take it.

    Parameters
    ----------
    order, station
        Which they are; the station is the one with the lowest load.
    waited
        Whether the order has waited so long that the station takes nothing else.
    """

    order: Order
    station: Station
    waited: bool

    @classmethod
    def of(cls, warehouse: WarehouseView, model: Model, max_wait_s: float) -> Oversize | None:
        """Return it, or None where a model can assign every order once the stations are empty.

        Parameters
        ----------
        warehouse
            The warehouse.
        model
            Which of the three.
        max_wait_s
            How long an order may wait.
        """
        lines, largest = warehouse.backlog_lines, largest_capacity(warehouse)
        stations = [station for station in warehouse.stations if station.open]
        if lines.quantity.sum() <= largest or not stations:
            return None
        large: NDArray[np.bool_] = items_per_order(warehouse) > largest
        if model is not Model.INTEGRATED:
            all_together = sum(station.capacity for station in stations)
            more = items_per_order(warehouse) > all_together if model is Model.SPLIT_AMONG_STATIONS else False
            large &= (np.bincount(lines.order[lines.quantity > largest], minlength=len(large)) > 0) | more
        if not large.any():
            return None
        order = warehouse.backlog[int(large.argmax())]
        station = min(stations, key=lambda station: (station.load, station.id))
        return cls(order, station, warehouse.now_s - order.arrival_s >= max_wait_s)
