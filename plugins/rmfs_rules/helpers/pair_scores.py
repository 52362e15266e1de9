"""Open lines of the backlog that are kept from call to call: what did not change is not read again."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rmfs_rules.helpers.pairs import largest_capacity

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView

Ints = NDArray[np.int64]


def _doubled(array: NDArray[Any], value: int) -> NDArray[Any]:
    """Return an array with twice the room along its last axis, filled with a value."""
    return np.concatenate([array, np.full_like(array, value)], axis=-1)


class PairScores:
    """The open lines of the backlog, kept for `pod_completing.KeptCompleted` until that reads the columns.

    ``update`` takes in what a warehouse has become since the last call, in time that depends on what changed and not on
    the size of the backlog.
    """

    def __init__(self) -> None:
        self._log: object = None
        self._now: Ints = np.zeros((1, 0, 0), np.int64)

    def load(self) -> None:
        """Load what is compiled, or compile it."""
        self._begin(1, 1, math.inf)
        self._take_in(np.array([[0], [0], [1]]), [])
        self.completed(np.ones(1, np.int64))
        self._log = None

    def update(self, warehouse: WarehouseView) -> None:
        """Take in what joined and left the backlog."""
        log = warehouse.backlog_log()
        if log is not self._log:
            self._begin(len(warehouse.stations), warehouse.n_skus, largest_capacity(warehouse))
            self._log = log
        joined, left = log.joined(self._joined), log.left(self._left)
        if joined.size or left:
            self._take_in(joined, left)

    def order_at(self, place: int) -> int:
        """Return the id of the order at a place."""
        return int(self._ids[place])

    def completed(self, items: Ints) -> Ints:
        """Return the places of the orders of which a pod has all that is open, if it has so many free items by SKU."""
        held = np.flatnonzero(items)
        places: Ints = self.completed_by(np.zeros_like(held), held, items[held])[1]
        return places

    def completed_by(self, pod: Ints, sku: Ints, items: Ints) -> Ints:
        """Return pairs of pod and place, shape (2, n), of the orders of which pods have all that is open.

        Entries say how many items of a SKU a pod has, sorted by pod, each SKU of a pod once.
        """
        from rmfs_rules.helpers import completing  # compiled, as above

        pairs: Ints = completing.completed_by(pod, sku, items, self._shelves, self._pool, self._orders, self._enough)
        return pairs

    # What is kept

    def _begin(self, stations: int, skus: int, largest: float) -> None:
        """Start anew with an empty backlog and nothing available."""
        from rmfs_rules.helpers import pair_search  # compiled: imported when needed, for it takes its time

        self._work: Any = pair_search
        self._joined = self._left = self._parts = self._first = self._number = self._used = 0
        self._largest = largest
        sizes = pair_search.SIZES
        self._now = np.zeros((1, stations, skus), np.int64)
        self._changes = np.zeros(stations, np.int64)  # how often what is available has changed
        self._recent = np.zeros((stations, pair_search.RECENT), np.int64)  # the last of these: what it was
        self._seen = np.zeros((stations, sizes), np.int64)  # the same, when the scores of a size were last made
        self._known = np.zeros((1, stations, skus, sizes), np.int64)
        self._shelves = np.zeros((skus, sizes, 3), np.int32)
        self._most = np.zeros(skus, np.int64)  # items that a line of a SKU ever had
        self._lines = np.zeros((4, 256), np.int64)
        self._pool = np.zeros((256, 4), np.int32)
        self._orders = np.zeros((4, 256), np.int32)
        self._ids = np.zeros(256, np.int64)
        self._starts = np.zeros(257, np.int64)  # of each order's lines, and the end of all
        self._taken = np.zeros(256, np.bool_)
        self._enough = np.zeros(256, np.int32)
        self._ranks = np.zeros(256)
        blocks = sizes + 256 // pair_search.BLOCK  # of each size one may be begun
        self._scores = np.full((1, stations + 1, blocks * pair_search.BLOCK), -1, np.int32)
        self._best_values = np.full((2, stations, blocks), -1.0)
        self._blocks: Any = pair_search.Blocks(
            np.full(blocks * pair_search.BLOCK, -1, np.int32),
            np.zeros(blocks, np.int64),
            np.zeros(blocks),
            np.zeros((sizes, blocks), np.int64),
            np.zeros((2, sizes), np.int64),
        )

    def _arrays(self) -> tuple[Any, ...]:
        lines = self._shelves, self._most, self._pool
        return *lines, self._orders, self._scores, self._ranks, self._best_values, self._known

    def _take_in(self, rows: Ints, left: list[int]) -> None:
        """Take in lines that joined and left."""
        joined, before = rows.shape[1], self._number
        self._make_room(joined)
        self._number, self._first, _, _, _, self._pool, self._used = self._work.update(
            rows, np.array(left, np.int64), self._joined, before, self._first, self._used,
            self._ids, self._starts, self._lines, self._blocks, *self._arrays(),
        )  # fmt: skip
        self._joined += joined
        self._left += len(left)

    def _make_room(self, joined: int) -> None:
        """Let the arrays have room for so many more lines, each of an order of its own."""
        while self._joined + joined > self._lines.shape[1]:
            self._lines = _doubled(self._lines, 0)
        while self._number + joined > len(self._taken):
            for name in ("_orders", "_taken", "_enough", "_ranks", "_ids"):
                setattr(self, name, _doubled(getattr(self, name), 0))
            self._starts = np.concatenate([self._starts, np.zeros_like(self._starts[1:])])
            self._scores, self._best_values = _doubled(self._scores, -1), _doubled(self._best_values, -1)
            *by_block, counts = self._blocks
            self._blocks = self._work.Blocks(*[_doubled(array, -1) for array in by_block], counts)
