"""The orders of the backlog as arrays that are kept from call to call."""

from __future__ import annotations

from itertools import groupby
from operator import itemgetter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView

Ints = NDArray[np.int64]
ID, ITEMS, WHICH = range(3)
"""Rows of the orders: id, open items, and which of all that joined it is."""


class OpenOrders:
    """Ids and open items of all orders of the backlog, in its order: by position in ``WarehouseView.backlog``.

    For rules that look at every order at each call, whatever filters leave of them.
    """

    def __init__(self) -> None:
        self._log: object = None
        self._begin()

    @property
    def ids(self) -> Ints:
        """Ids of the orders."""
        ids: Ints = self._rows[ID, : self._number]
        return ids

    @property
    def items(self) -> Ints:
        """Open items of the orders."""
        items: Ints = self._rows[ITEMS, : self._number]
        return items

    @property
    def whole(self) -> bool:
        """Whether no order of the backlog was assigned in part."""
        return not self._in_part

    def update(self, warehouse: WarehouseView) -> None:
        """Take in what joined and left the backlog."""
        log = warehouse.backlog_log()
        if log is not self._log:
            self._begin()
            self._log = log
        self._join(log.joined(len(self._lines)))
        left = log.left(self._left)
        self._left += len(left)
        for line in left:
            self._leave(*self._lines[line])

    def _begin(self) -> None:
        """Start anew with an empty backlog."""
        self._left = self._number = 0  # lines that left, orders that are there
        self._rows = np.zeros((3, 256), np.int64)
        self._lines: list[tuple[int, int]] = []  # of all that joined: which order, counted from 0, and items
        self._open: list[int] = []  # of all orders that joined: lines in the backlog
        self._in_part: set[int] = set()

    def _join(self, joined: Ints) -> None:
        """Take in lines that joined; those of an order join together."""
        for _, lines in groupby(joined.T.tolist(), itemgetter(0)):
            of_order = list(lines)
            if self._number == self._rows.shape[1]:
                self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)], axis=1)
            self._rows[:, self._number] = of_order[0][0], sum(line[2] for line in of_order), len(self._open)
            self._lines += [(len(self._open), line[2]) for line in of_order]
            self._open.append(len(of_order))
            self._number += 1

    def _leave(self, order: int, items: int) -> None:
        """Take out a line."""
        at = int(self._rows[WHICH, : self._number].searchsorted(order))
        self._rows[ITEMS, at] -= items
        self._open[order] -= 1
        if self._open[order]:
            self._in_part.add(order)
            return
        self._in_part.discard(order)
        self._number -= 1
        self._rows[:, at : self._number] = self._rows[:, at + 1 : self._number + 1]
