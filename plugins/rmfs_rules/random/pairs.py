"""Pairs of order and station that are drawn one after another."""

from __future__ import annotations

from bisect import bisect_left, bisect_right, insort
from collections import defaultdict
from collections.abc import Iterable
from itertools import accumulate, chain, takewhile
from typing import TYPE_CHECKING

from rmfs_core import OrderAssignment
from rmfs_rules.helpers import OVERSIZE_WAIT_S, largest_capacity, station_to_keep

if TYPE_CHECKING:
    import numpy as np

    from rmfs_core.warehouse import WarehouseView
    from rmfs_rules.helpers.open_orders import OpenOrders


class Drawing:
    """One decision: whole orders, again and again one of the pairs of order and station that fit.

    Orders with as many items fit the same stations. So the number of pairs is known without a look at each, and one
    number says which of them is drawn.

    Parameters
    ----------
    warehouse
        The warehouse now; where stations count orders, none of the backlog has a place already.
    orders
        The orders of the backlog.
    rng
        Draws lots.
    """

    def __init__(self, warehouse: WarehouseView, orders: OpenOrders, rng: np.random.Generator) -> None:
        self._warehouse, self._orders, self._rng = warehouse, orders, rng
        self._largest = largest_capacity(warehouse)
        self._free = [station.free_capacity for station in warehouse.stations]
        self._taken: dict[int, list[int]] = defaultdict(list)  # by size: which of these orders are assigned, ascending
        self._chosen: list[OrderAssignment] = []

    def done(self, max_wait_s: float | None = None) -> list[OrderAssignment]:
        """Decide; orders that have waited too long go first, as `assign_best_pairs` has them."""
        self._assign_waiting(max_wait_s)
        sizes = sorted(self._orders.of_size)
        while True:
            left = [(size, len(self._orders.of_size[size]) - len(self._taken[size])) for size in sizes]
            pairs = [(at, size, number) for at in self._with_room() for size, number in left if self._fits(size, at)]
            up_to = list(accumulate(number for _, _, number in pairs))
            if not pairs or not up_to[-1]:
                return self._chosen
            lot = int(self._rng.integers(up_to[-1]))
            at, size, number = pairs[among := bisect_right(up_to, lot)]
            which = lot - (up_to[among] - number)
            for taken in self._taken[size]:
                which += taken <= which
            self._assign(size, which, at)

    def _with_room(self) -> list[int]:
        """Return the ids of the stations that are not full."""
        return [at for at, free in enumerate(self._free) if free > 0]

    def _fits(self, size: int, at: int) -> bool:
        """Whether an order of so many items fits a station that is not full; one larger than any fits an empty one."""
        station = self._warehouse.stations[at]
        return station.counts_orders or self._free[at] >= (station.capacity if size > self._largest else size)

    def _assign(self, size: int, which: int, at: int) -> None:
        """Assign one of the orders of a size."""
        station = self._warehouse.stations[at]
        self._chosen.append(OrderAssignment(self._orders.of_size[size][which], at))
        self._free[at] -= 1 if station.counts_orders else min(size, station.capacity)
        insort(self._taken[size], which)

    def _assign_waiting(self, max_wait_s: float | None) -> None:
        """Assign the orders that have waited too long; for those that fit nowhere stations are kept."""
        kept: dict[int, bool] = {}  # stations kept for an order that waits, and whether that is larger than any station
        for order in self._waiting(max_wait_s):
            size = self._orders.items[order]
            if fitting := [at for at in self._with_room() if self._fits(size, at)]:
                at = fitting[int(self._rng.integers(len(fitting)))]
                self._assign(size, bisect_left(self._orders.of_size[size], order), at)
            elif max_wait_s is not None or not any(kept.values()):
                free = dict(enumerate(self._free))
                keep = station_to_keep(self._warehouse, self._warehouse.order(order), free, kept)
                if keep is not None:
                    kept[keep], self._free[keep] = size > self._largest, 0
            if len(kept) == len(self._free):
                break

    def _waiting(self, max_wait_s: float | None) -> Iterable[int]:
        """Return the ids of the orders that have waited too long, oldest first."""
        warehouse, limit_s = self._warehouse, OVERSIZE_WAIT_S if max_wait_s is None else max_wait_s
        oldest: Iterable[int] = self._orders.items
        if max_wait_s is None:
            large = [self._orders.of_size[size] for size in self._orders.of_size if size > self._largest]
            oldest = sorted(chain(*large), key=lambda order: (warehouse.order(order).arrival_s, order))
        return takewhile(lambda order: warehouse.now_s - warehouse.order(order).arrival_s >= limit_s, oldest)
