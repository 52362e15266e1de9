"""What orders stations could take with given pods, as a rule for whole orders scores it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_rule_helpers import OVERSIZE_WAIT_S, items_per_order, largest_capacity, lines_at, sum_per_order

if TYPE_CHECKING:
    from rmfs_core import OrderAssignment
    from rmfs_core.warehouse import Station, WarehouseView

Integers = NDArray[np.int64]
Sent = Sequence[tuple[int, int]]
"""Pods (ids) and the stations that they are sent to."""
Chosen = Sequence[tuple[int, int]]
"""Orders, by position in the backlog, and their stations."""

NOT_NOW = -1
"""Score of an order that may not be chosen."""
SCALE = 1_000_000
"""Scores are whole numbers: what a line that is missing counts at a station that counts orders."""


class Left:
    """What pods have left while orders are chosen one after another.

    Parameters
    ----------
    warehouse
        The warehouse now.
    sent
        Pods that are sent besides those that are at or bound for stations.

    Attributes
    ----------
    at
        Items left on the pods of each station; below 0, what pods still have to bring. Shape (stations, SKUs).
    """

    def __init__(self, warehouse: WarehouseView, sent: Sent = ()) -> None:
        self.warehouse = warehouse
        self._lines, free = warehouse.backlog_lines, warehouse.free_items
        self.at = warehouse.available()
        for pod, station in sent:
            held = slice(*np.searchsorted(free.pod, (pod, pod + 1)).tolist())
            self.at[station, free.sku[held]] += free.number[held]
        self._supply: Integers | None = None
        if not warehouse.unlimited_stock:
            self._supply = np.zeros(warehouse.n_skus, np.int64)
            np.add.at(self._supply, free.sku, free.number)

    @cached_property
    def _items(self) -> Integers:
        return items_per_order(self.warehouse)

    @cached_property
    def most_lines(self) -> int:
        """Open lines of the order that has most."""
        return int(np.bincount(self._lines.order).max(initial=0))

    def missing(self, station: Station) -> Integers:
        """Lines of each order that a pod would have to be sent for, which none is sent for anyway."""
        left = self.at[station.id][self._lines.sku]
        return sum_per_order(self.warehouse, ((left >= 0) & (left < self._lines.quantity)).astype(np.int64))

    def score(self, station: Station) -> Integers:
        """Return how good each order is at a station: most where fewest lines are missing for each place it takes."""
        places = 1 if station.counts_orders else self._items
        scores: Integers = (self.most_lines + 1) * SCALE - self.missing(station) * SCALE // places
        return np.where(self.in_stock(), scores, NOT_NOW)

    def in_stock(self) -> NDArray[np.bool_]:
        """Whether all pods together have enough left for each order."""
        if self._supply is None:
            return np.ones(len(self.warehouse.backlog), np.bool_)
        lacking = self._supply[self._lines.sku] < self._lines.quantity
        enough: NDArray[np.bool_] = sum_per_order(self.warehouse, lacking.astype(np.int64)) == 0
        return enough

    def take(self, station: Station, position: int) -> Iterable[int]:
        """Take account of a chosen order; return the ids of the stations at which scores change."""
        where = lines_at(self.warehouse, position)
        sku, quantity = self._lines.sku[where], self._lines.quantity[where]
        self.at[station.id][sku] -= quantity
        if self._supply is None:
            return (station.id,)
        self._supply[sku] -= quantity
        return range(len(self.warehouse.stations))


def waiting_too_long(warehouse: WarehouseView, max_wait_s: float | None) -> set[int]:
    """Return the orders that have waited too long, by position in the backlog, as `assign_best_pairs` has it."""
    oversize = items_per_order(warehouse) > largest_capacity(warehouse)
    if max_wait_s is None and not oversize.any():
        return set()  # nobody's arrival matters
    limit_s = np.where(oversize, OVERSIZE_WAIT_S, np.inf) if max_wait_s is None else max_wait_s
    waited_s = warehouse.now_s - np.array([order.arrival_s for order in warehouse.backlog])
    return set(np.flatnonzero(waited_s >= limit_s).tolist())


def placed(warehouse: WarehouseView, pairs: Iterable[OrderAssignment]) -> list[tuple[int, int]]:
    """Return orders that were assigned, by position in the backlog, and their stations."""
    lines = warehouse.backlog_lines
    return [(int(lines.order[(lines.order_id == pair.order).argmax()]), pair.station) for pair in pairs]
