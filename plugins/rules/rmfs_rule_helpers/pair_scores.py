"""Scores of all pairs of order and station that are kept from call to call: what did not change is not read again."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import define, field
from numpy.typing import NDArray

from rmfs_core.decisions import OrderAssignment
from rmfs_rule_helpers import largest_capacity
from rmfs_rule_helpers.options import PairOptions

if TYPE_CHECKING:
    from rmfs_core.traffic import Roads
    from rmfs_core.warehouse import Station, WarehouseView

Ints = NDArray[np.int64]
Change = Callable[[int, int, int], None]


class PairScores:
    """How many items of each order of the backlog are available at each station, as on the pods inbound to it.

    ``update`` takes in what a warehouse has become since the last call, in time that depends on what changed and not on
    the size of the backlog; ``assign`` then assigns the best pairs, as `assign_best_pairs` with such scores does.

    Attributes
    ----------
    available
        Items by station and SKU that the scores are made of, shape (stations, SKUs).
    """

    def __init__(self) -> None:
        self._log: object = None
        self.available: Ints = np.zeros((0, 0), np.int64)

    def load(self) -> None:
        """Load what is compiled, or compile it."""
        self._begin(1, 1)
        self._take_in(np.array([[0], [0], [1]]), [], np.ones(1, np.bool_), np.ones_like(self.available))
        self._best(np.ones(1, np.int64), np.zeros(1, np.bool_), np.zeros(1, np.int64))
        self._log = None

    def decides(self, warehouse: WarehouseView, available: Ints | None = None) -> bool:
        """Update, and say whether `assign` may decide: all orders are shown, whole, and small enough for a station."""
        if warehouse.filtered:
            return False
        self.update(warehouse, available)
        return self.whole and self.largest <= largest_capacity(warehouse)

    def update(self, warehouse: WarehouseView, available: Ints | None = None) -> None:
        """Take in what joined and left the backlog, and what is available now; left out: what was, nothing at first."""
        log = warehouse.backlog_log()
        if log is not self._log:
            self._begin(len(warehouse.stations), warehouse.n_skus)
            self._log = log
        room = [available is not None and station.free_capacity > 0 for station in warehouse.stations]  # else it waits
        available = self.available if available is None else available
        self._take_in(log.joined(self._joined), log.left(self._left), np.array(room, np.bool_), available)

    def lines_of(self, place: int) -> Iterable[tuple[int, int]]:
        """Yield SKU and number of items of each line of the order at a place."""
        begin, end = self._starts[place : place + 2].tolist()
        yield from zip(*self._lines[1:3, begin:end].tolist(), strict=True)

    @property
    def whole(self) -> bool:
        """Whether no order of the backlog was assigned in part."""
        return not self._parts

    @property
    def largest(self) -> int:
        """Items of the largest order that was ever in the backlog."""
        return self._largest

    def change(self, station: int, sku: int, items: int) -> None:
        """Let a station have another number of items of a SKU available, until the next update."""
        self._work.change(station, sku, items, *self._arrays())

    def assign(
        self,
        stations: tuple[Station, ...],
        take: Callable[[Station, int], None] | None = None,
        prefer: Callable[[int, Station], int] | None = None,
    ) -> list[OrderAssignment]:
        """Assign whole orders, again and again the pair with the highest score that fits.

        Of the stations with an order's highest score the one takes it that ``prefer`` (order's id, station) is lowest
        for; left out, or with ties, as `assign_best_pairs` says. ``take`` is told of each pair, unless nothing more
        can fit.
        """
        free = np.array([station.free_capacity for station in stations], np.int64)
        load = np.array([station.load for station in stations], np.int64)
        counts = np.array([station.counts_orders for station in stations], np.bool_)
        chosen: list[OrderAssignment] = []
        places: list[int] = []
        while True:
            place, at = self._best(free, counts, load)
            if place < 0:
                break
            if prefer is not None:
                fitting = np.flatnonzero((free > 0) & (counts | (self._orders[1, place] <= free))).tolist()
                tied = [i for i in fitting if self._scores[i, place] == self._scores[at, place]]
                at = min(tied, key=lambda i: (prefer(self._ids[place].item(), stations[i]), load[i], i))
            chosen.append(OrderAssignment(self._ids[place].item(), at))
            size = 1 if counts[at] else self._orders[1, place]
            free[at] -= size
            load[at] += size
            self._taken[place] = True
            places.append(place)
            if max(free.tolist()) <= 0:
                break
            if take is not None:
                take(stations[at], place)
        self._taken[places] = False
        return chosen

    # What is kept

    def _begin(self, stations: int, skus: int) -> None:
        """Start anew with an empty backlog and nothing available."""
        from rmfs_rule_helpers import pair_search  # compiled: imported when needed, for it takes its time

        self._work: Any = pair_search
        self._joined = self._left = self._parts = self._largest = self._first = self._number = 0
        self._ids = np.zeros(256, np.int64)
        self._starts = np.zeros(257, np.int64)  # of each order's lines, and the end of all
        self.available = np.zeros((stations, skus), np.int64)
        self._heads = np.full(skus, -1, np.int64)
        self._lines = np.zeros((5, 256), np.int64)
        self._orders = np.zeros((2, 256), np.int64)
        self._taken = np.zeros(256, np.bool_)
        self._scores = np.zeros((stations, 256), np.int64)
        self._best_scores = np.full((stations, 256 // pair_search.BLOCK, pair_search.SIZES), -1, np.int64)

    def _arrays(self) -> tuple[Ints, ...]:
        return self._lines, self._heads, self._orders, self._scores, self._best_scores, self.available

    def _take_in(self, rows: Ints, left: list[int], room: NDArray[np.bool_], available: Ints) -> None:
        """Take in lines that joined and left, and what stations with room have available."""
        joined = rows.shape[1]
        while self._joined + joined > self._lines.shape[1]:
            self._lines = np.concatenate([self._lines, np.zeros_like(self._lines)], axis=1)
        while self._number + joined > len(self._taken):
            for name in ("_orders", "_scores", "_taken", "_ids"):
                array = getattr(self, name)
                setattr(self, name, np.concatenate([array, np.zeros_like(array)], axis=-1))
            self._starts = np.concatenate([self._starts, np.zeros_like(self._ids[: len(self._starts) - 1])])
            self._best_scores = np.concatenate([self._best_scores, np.full_like(self._best_scores, -1)], axis=1)
        self._number, self._first, largest, parts = self._work.update(
            rows, np.array(left, np.int64), self._joined, self._number, self._first, room, available,
            self._ids, self._starts, *self._arrays(),
        )  # fmt: skip
        self._largest = max(self._largest, largest)
        self._parts += parts
        self._joined += joined
        self._left += len(left)

    def _best(self, free: Ints, counts: NDArray[np.bool_], load: Ints) -> tuple[int, int]:
        bounds = self._first, self._number
        found: tuple[int, int] = self._work.best_pair(
            free, counts, load, *bounds, self._orders, self._taken, self._scores, self._best_scores
        )
        return found


@define
class KeptPairs(PairOptions):
    """Parameters of a rule that keeps the scores of pairs of order and station."""

    _scores: PairScores = field(init=False, factory=PairScores, repr=False, eq=False)

    def prepare(self, roads: Roads) -> None:  # noqa: ARG002
        """Load what is compiled, or compile it."""
        self._scores.load()
