"""How many lines each order of the backlog lacks at each station, kept from call to call."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rmfs_core.warehouse import WarehouseView

Ints = NDArray[np.int64]


class Lacking:
    """Lines that pods would have to be sent for, by station and order; and which orders stock is lacking for.

    Orders have places: numbers that grow with their age, the oldest first. ``update`` takes in what joined and left the
    backlog, ``let`` what stations and all pods have, in time that depends on what changed and not on the size of the
    backlog.

    Attributes
    ----------
    kept
        The account, as compiled code has it: `rmfs_rules.joint.lacking_search.Arrays`.
    taken
        Places of the orders that were chosen since the last ``let``: they are out of the question.
    """

    def __init__(self) -> None:
        self._log: object = None
        self.taken: list[int] = []

    def load(self) -> None:
        """Load what is compiled, or compile it."""
        self.begin(np.zeros(1, np.bool_), 1, 1)
        self.join(np.array([[0], [0], [1]]))
        self.let(np.zeros((2, 1), np.int64))
        self.leave([])
        self._work.close_up(self.kept)
        self._log = None

    def update(self, warehouse: WarehouseView) -> None:
        """Take in what joined and left the backlog."""
        log = warehouse.backlog_log()
        if log is not self._log:
            self.begin(counted(warehouse), warehouse.n_skus, 256)
            self._log = log
        joined, left = log.joined(self._joined), log.left(self._left)
        if joined.size:
            self.join(joined)
        if left:
            self.leave(left)

    def begin(self, counting: NDArray[np.bool_], skus: int, lines: int) -> None:
        """Start anew with an empty backlog and nothing at any station, and room for so many lines."""
        from rmfs_rules.joint import lacking_search  # compiled: imported when needed, for it takes its time

        self._work: Any = lacking_search
        self._joined = self._left = 0
        self.taken = []
        stations, blocks = len(counting), 4
        by_block = np.full((3, stations, blocks), -1)
        by_block[0], by_block[1] = lacking_search.NEVER, lacking_search.GONE
        self._arrays: dict[str, NDArray[Any]] = {
            "counts": np.zeros(6, np.int64),
            "ids": np.zeros(lines + 1, np.int64),
            "starts": np.zeros(lines + 1, np.int64),
            "orders": np.zeros((3, lines + 1), np.int64),
            "lines": np.zeros((4, lines + 1), np.int64),
            "shelves": np.zeros((skus, 4), np.int64),
            "pool": np.zeros((lines * POOL, 3), np.int32),
            "wanted": np.zeros(skus, np.int64),
            "filling": np.full(16, -1),
            "of_size": np.zeros(16, np.int64),
            "at": np.zeros((stations + 1, skus), np.int64),
            "lacks": np.zeros((stations + 1, blocks * lacking_search.BLOCK), np.int32),
            "places": np.full(blocks * lacking_search.BLOCK, -1),
            "sizes": np.zeros(blocks, np.int64),
            "value": by_block[0].copy(),
            "least": by_block[1].copy(),
            "who": by_block[2].copy(),
            "counted": counting,
        }
        self.kept: Any = lacking_search.Arrays(**self._arrays)

    def join(self, rows: Ints) -> None:
        """Take in lines: order ids, SKUs and items, shape (3, n). Those of an order stand together."""
        first = np.flatnonzero(np.concatenate([[True], rows[0, 1:] != rows[0, :-1]]))
        self._make_room(np.add.reduceat(rows[2], first), rows.shape[1])
        self._work.join(rows, self.kept)
        self._joined += rows.shape[1]

    def let(self, at: Ints) -> None:
        """Let stations, and in the last row all pods together, have so many items, and no order be chosen."""
        self._work.let(at, np.array(self.taken, np.int64), self.kept)
        self.taken = []

    @property
    def whole(self) -> bool:
        """Whether no order of the backlog was assigned in part."""
        return not self.kept.counts[self._work.PARTS]

    @property
    def places(self) -> Ints:
        """Places of the orders of the backlog, oldest first; they are looked for."""
        return np.fromiter(self.larger_than(0), np.int64)

    @property
    def missing_line(self) -> int:
        """What a line that an order lacks counts, at a station that counts orders."""
        return int(self._work.SCALE)

    @property
    def number(self) -> int:
        """How many orders the backlog has."""
        return int(self.kept.of_size.sum())

    @property
    def most_items(self) -> int:
        """Open items of the largest order of the backlog; 1 if it is empty."""
        return int(self.kept.of_size.nonzero()[0].max(initial=1))

    def larger_than(self, items: float) -> Iterator[int]:
        """Yield the places of the orders of the backlog with more open items, oldest first."""
        first, number = self.kept.counts[[self._work.FIRST, self._work.NUMBER]].tolist()
        for begin in range(first, number, LOOK):
            open_, size, _ = self.kept.orders[:, begin : min(begin + LOOK, number)]
            yield from (begin + np.flatnonzero((open_ > 0) & (size > items))).tolist()

    def id_of(self, place: int) -> int:
        """Return the id of the order at a place."""
        return int(self.kept.ids[place])

    def lines_of(self, places: Sequence[int]) -> list[tuple[int, int, int]]:
        """Return which of some orders has each of their lines, SKU and number of items."""
        starts, lines = self.kept.starts, self.kept.lines
        return [
            (which, sku, quantity)
            for which, place in enumerate(places)
            for sku, quantity in lines[1:3, starts[place] : starts[place + 1]].T.tolist()
        ]

    def leave(self, left: list[int]) -> None:
        """Take out lines that left."""
        self.let(self.kept.at)  # no order that leaves is chosen
        self._work.leave(np.array(left, np.int64), self.kept)
        self._left += len(left)
        sizes = self.kept.of_size[self.kept.of_size > 0]
        needed = int((sizes // self._work.BLOCK + 1).sum())
        if self.kept.counts[self._work.BLOCKS] > 2 * needed + EMPTY_BLOCKS:
            self._work.close_up(self.kept)

    def _make_room(self, items: Ints, lines: int) -> None:
        """Let the arrays have room for orders with so many items each, and so many lines altogether."""
        work, kept = self._work, self.kept
        if (most := int(items.max())) >= len(kept.filling):
            self._grow(most + 1, filling=-1, of_size=0)
        if (needed := self._joined + lines + 1) > kept.lines.shape[1]:  # where the last lines end counts, too
            self._grow(needed, ids=0, starts=0, orders=0, lines=0)
            self._arrays["pool"] = _grown(kept.pool.T, needed * POOL, 0).T.copy()
        blocks = int(kept.counts[work.BLOCKS]) + len(set(items.tolist())) + len(items) // work.BLOCK
        if blocks > len(kept.sizes):
            self._grow(blocks, sizes=0, value=work.NEVER, least=work.GONE, who=-1)
            self._grow(blocks * work.BLOCK, lacks=0, places=-1)
        self.kept = work.Arrays(**self._arrays)

    def _grow(self, size: int, **values: int) -> None:
        """Let arrays have room for so many, filled with a value."""
        for name, value in values.items():
            self._arrays[name] = _grown(self._arrays[name], size, value)


POOL = 8
"""Lines that there is room for in the pool, for each that joins: shelves double, and what they had before stays."""


EMPTY_BLOCKS = 16
"""Blocks of orders that left which may be there besides as many as are needed, before the orders are moved together."""


LOOK = 1024
"""Orders that are looked at together."""


def counted(warehouse: WarehouseView) -> NDArray[np.bool_]:
    """Return which stations count orders."""
    return np.array([station.counts_orders for station in warehouse.stations], np.bool_)


def _grown(array: NDArray[Any], size: int, value: int) -> NDArray[Any]:
    """Return an array with room for ``size`` and half as much again along its last axis, filled with a value."""
    more = np.full((*array.shape[:-1], size + size // 2 - array.shape[-1]), value, array.dtype)
    return np.concatenate([array, more], axis=-1)
