"""Orders that a joint rule cannot assign together with others: they need a station of their own."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_core import JointDecision

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
    def of(
        cls, warehouse: WarehouseView, max_wait_s: float, *, splits: bool = False, over_time: bool = False
    ) -> Oversize | None:
        """Return it, or None where every order can be assigned together with others once the stations have capacity.

        Parameters
        ----------
        warehouse
            The warehouse.
        max_wait_s
            How long an order may wait.
        splits
            Whether the lines of an order may go to several stations.
        over_time
            Whether some of them may stay in the backlog besides.
        """
        lines, largest = warehouse.lines, warehouse.largest_capacity
        large = lines.items > largest
        if splits and large.any():
            all_together = sum(station.capacity for station in warehouse.stations if station.open)
            large = lines.items > (math.inf if over_time else max(all_together, largest))
            large[lines.order[lines.quantity > largest]] = True
        return cls._oldest(warehouse, large, max_wait_s)

    @classmethod
    def left(cls, warehouse: WarehouseView) -> Oversize | None:
        """Return the oldest order of more items than any station takes, if all stations are empty; else None.

        Whoever finds nothing to assign then never will: its lines do not fit the stations together.
        """
        if any(station.load for station in warehouse.stations):
            return None
        return cls._oldest(warehouse, warehouse.lines.items > warehouse.largest_capacity, 0.0)

    @classmethod
    def _oldest(cls, warehouse: WarehouseView, large: NDArray[np.bool_], max_wait_s: float) -> Oversize | None:
        """Return the oldest of the orders that are large, by row."""
        stations = [station for station in warehouse.stations if station.open] if large.any() else []
        if not stations:
            return None
        order = warehouse.order(int(warehouse.lines.order_id[large.argmax()]))
        station = min(stations, key=lambda station: (station.load, station.id))
        return cls(order, station, warehouse.now_s - order.arrival_s >= max_wait_s)


def with_oversize(
    warehouse: WarehouseView,
    large: Oversize | None,
    decide: Callable[[Station | None], JointDecision],
    alone: Callable[[Oversize], JointDecision],
) -> JointDecision:
    """Decide a period in which an order may need a station of its own.

    Once it has waited too long, the station takes nothing else until it is empty, and then that order. Before that it
    takes it if it is empty and nothing else can be assigned anywhere.

    Parameters
    ----------
    warehouse
        The warehouse.
    large
        The order, as `Oversize.of` has it.
    decide
        Decides about all other orders, given a station that takes nothing now.
    alone
        Assigns all that is left of the order to its empty station, or nothing where free items are not enough.
    """
    if large is not None and large.waited and not large.station.load:
        decision = alone(large)
        if decision.assignments:
            return decision
        large = None
    decision = decide(large.station if large is not None and large.waited else None)
    if decision.assignments:
        return decision
    large = large or Oversize.left(warehouse)
    return decision if large is None or large.station.load else alone(large)
