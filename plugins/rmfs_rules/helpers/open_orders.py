"""The orders of the backlog by how many items they have open, kept from call to call."""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, WarehouseView


class OpenOrders:
    """Ids of the orders that have so many items open, for rules to which orders of a size are alike.

    What is here does not depend on how it came about: ids are in ascending order.

    Parameters
    ----------
    orders
        Orders that are there at first.

    Attributes
    ----------
    of_size
        Ids by number of open items.
    items
        Open items by id, the order that joined first is first.
    """

    def __init__(self, orders: Iterable[Order] = ()) -> None:
        self._log: object = None
        self._begin()
        for order in orders:
            self._put(order)

    def update(self, warehouse: WarehouseView) -> None:
        """Take in what joined and left the backlog, whatever filters leave of it."""
        log = warehouse.backlog_log()
        if log is not self._log:
            self._begin()
            self._log = log
        joined, left = log.joined(len(self._lines))[0].tolist(), log.left(self._left)
        self._lines += joined
        self._left += len(left)
        for order in dict.fromkeys([*joined, *(self._lines[line] for line in left)]):
            self._put(warehouse.order(order))

    def _begin(self) -> None:
        """Start anew with an empty backlog."""
        self.of_size: dict[int, list[int]] = {}
        self.items: dict[int, int] = {}
        self._lines: list[int] = []  # of all lines that joined, their order's id
        self._left = 0  # how many of them have left

    def _put(self, order: Order) -> None:
        """Put an order where it belongs now."""
        before, items = self.items.get(order.id, 0), order.open_items
        if before:
            there = self.of_size[before]
            del there[bisect_left(there, order.id)]
            if not there:
                del self.of_size[before]
        if items:
            insort(self.of_size.setdefault(items, []), order.id)
            self.items[order.id] = items
        elif before:
            del self.items[order.id]
