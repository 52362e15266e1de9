"""Pairs of order and station that are drawn one after another."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_core import OrderAssignment
from rmfs_rules.helpers.pairs import OVERSIZE_WAIT_S, SHUT, largest_capacity, places_taken, station_to_keep

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView

PLACED = 0
"""Instead of a number of items: the orders that have a place at a full station already."""


class Drawing:
    """One decision: whole orders, again and again one of the pairs of order and station that fit.

    Orders with as many items fit the same stations. So the number of pairs is known without a look at each, and one
    number says which of them is drawn.

    Parameters
    ----------
    warehouse
        The warehouse now.
    rng
        Draws lots.
    """

    def __init__(self, warehouse: WarehouseView, rng: np.random.Generator) -> None:
        self._warehouse, self._rng, self._lines = warehouse, rng, warehouse.lines
        self._largest = largest_capacity(warehouse)
        self._free = [station.free_capacity for station in warehouse.stations]
        self._placed = places_taken(warehouse)
        self._items = self._lines.items.copy()  # of each order, 0 once it is assigned
        self._number = np.bincount(self._items)  # of orders, by items
        self._chosen: list[OrderAssignment] = []

    def done(self, max_wait_s: float | None = None) -> list[OrderAssignment]:
        """Decide; orders that have waited too long go first, as `Pairs` has them."""
        self._assign_waiting(max_wait_s)
        while True:
            groups = [*self._groups()]
            up_to = [*accumulate(number for _, _, number in groups)]
            if not groups or not up_to[-1]:
                return self._chosen
            lot = int(self._rng.integers(up_to[-1]))
            at, size, number = groups[among := bisect_right(up_to, lot)]
            orders = np.sort(self._lines.order_id[self._alike(at, size)])
            self._assign(int(self._lines.place[orders[lot - (up_to[among] - number)]]), at)

    def _groups(self) -> Iterator[tuple[int, int, int]]:
        """Yield stations, sizes of orders that fit there, and how many orders have this size."""
        sizes = [(size, number) for size, number in enumerate(self._number.tolist()) if size and number]
        for at in self._with_room():
            yield from ((at, size, number) for size, number in sizes if self._fits(size, at))
        for at, free in enumerate(self._free):
            if free == 0 and self._placed.size:
                yield at, PLACED, int(np.count_nonzero(self._alike(at, PLACED)))

    def _alike(self, at: int, size: int) -> NDArray[np.bool_]:
        """Return which orders are of a group, by place."""
        alike: NDArray[np.bool_] = self._placed[at] & (self._items > 0) if size == PLACED else self._items == size
        return alike

    def _with_room(self) -> list[int]:
        """Return the ids of the stations that are not full."""
        return [at for at, free in enumerate(self._free) if free > 0]

    def _fits(self, size: int, at: int) -> bool:
        """Whether an order of so many items fits a station that is not full; one larger than any fits an empty one."""
        station = self._warehouse.stations[at]
        return station.counts_orders or self._free[at] >= (station.capacity if size > self._largest else size)

    def _assign(self, place: int, at: int) -> None:
        """Assign an order."""
        station, items = self._warehouse.stations[at], int(self._items[place])
        self._chosen.append(OrderAssignment(int(self._lines.order_id[place]), at))
        placed = self._placed.size and self._placed[at, place]
        self._free[at] -= int(not placed) if station.counts_orders else min(items, station.capacity)
        self._number[items] -= 1
        self._items[place] = 0

    def _assign_waiting(self, max_wait_s: float | None) -> None:
        """Assign the orders that have waited too long; for those that fit nowhere stations are kept."""
        kept: dict[int, bool] = {}  # stations kept for an order that waits, and whether that is larger than any station
        limit_s = OVERSIZE_WAIT_S if max_wait_s is None else max_wait_s
        waiting = self._items > (self._largest if max_wait_s is None else 0)
        waiting &= self._warehouse.now_s - self._lines.arrival_s >= limit_s
        for place in np.flatnonzero(waiting).tolist():
            size = int(self._items[place])
            if fitting := [at for at in self._with_room() if self._fits(size, at)]:
                self._assign(place, fitting[int(self._rng.integers(len(fitting)))])
            elif max_wait_s is not None or not any(kept.values()):
                order = self._warehouse.order(int(self._lines.order_id[place]))
                keep = station_to_keep(self._warehouse, order, dict(enumerate(self._free)), kept)
                if keep is not None:
                    kept[keep], self._free[keep] = size > self._largest, SHUT
            if len(kept) == len(self._free):
                break
