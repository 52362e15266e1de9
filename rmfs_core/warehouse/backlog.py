"""The backlog: orders with open lines, as objects and as columns; and lines and free items as copies that stay."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_core.warehouse.claims import by_age
from rmfs_core.warehouse.column_keeping import LineColumns
from rmfs_core.warehouse.columns import Lines, Stock
from rmfs_core.warehouse.parts import Order, OrderLine

Ints = NDArray[np.int64]


@frozen(eq=False)
class BacklogLines:
    """Open lines of the backlog as arrays of equal length n, sorted by position.

    Parameters
    ----------
    order
        Position of the line's order in ``WarehouseView.backlog``, int64, shape (n,).
    order_id, sku, quantity
        Ids of order and SKU, and number of items, int64, shape (n,).
    """

    order: Ints
    order_id: Ints
    sku: Ints
    quantity: Ints

    def __attrs_post_init__(self) -> None:
        for array in (self.order, self.order_id, self.sku, self.quantity):
            array.setflags(write=False)


def lines_in(columns: Lines) -> BacklogLines:
    """Return the open lines of columns, as they are now."""
    (there,) = np.nonzero(columns.quantity)
    row = columns.order[there]
    position = np.cumsum(columns.open_lines > 0) - 1
    return BacklogLines(position[row], columns.order_id[row], columns.sku[there], columns.quantity[there])


@frozen(eq=False)
class FreeItems:
    """Free items on the pods, promised to no request, as arrays of equal length n, sorted by pod and SKU.

    Parameters
    ----------
    pod, sku
        Pod id and SKU id, int64, shape (n,): every SKU that the pod ever held.
    number
        Free items, also none; `UNLIMITED` (2**40) where the stock is unlimited. int64, shape (n,).
    """

    pod: Ints
    sku: Ints
    number: Ints

    def __attrs_post_init__(self) -> None:
        for array in (self.pod, self.sku, self.number):
            array.setflags(write=False)


def items_in(columns: Stock) -> FreeItems:
    """Return the free items of columns, as they are now."""
    return FreeItems(columns.pod, columns.sku, columns.items.copy())


class Backlog(Sequence[Order]):
    """Orders with open lines, oldest first: themselves, as columns, and their sizes."""

    def __init__(self, n_skus: int) -> None:
        self.columns = LineColumns(n_skus)
        self.sizes: Counter[int] = Counter()
        """How many orders have so many open items."""
        self.line_sizes: Counter[int] = Counter()
        """How many open lines have so many items."""
        self._orders: dict[int, Order] = {}
        self._tuple: tuple[Order, ...] | None = ()
        self._lines: BacklogLines | None = None

    def __len__(self) -> int:
        return len(self._orders)

    def __getitem__(self, index: Any) -> Any:
        return self.orders[index]

    def __contains__(self, order: object) -> bool:
        return isinstance(order, Order) and order.id in self._orders

    @property
    def orders(self) -> tuple[Order, ...]:
        """The orders, oldest first."""
        if self._tuple is None:
            self._tuple = tuple(self._orders.values())
        return self._tuple

    @property
    def lines(self) -> BacklogLines:
        """Their open lines as arrays."""
        if self._lines is None:
            self._lines = lines_in(self.columns.lines())
        return self._lines

    def add(self, *orders: Order) -> None:
        """Take in orders, the oldest first; where some had to wait, others that are there may be younger."""
        if not orders:
            return
        youngest = next(reversed(self._orders.values()), None)
        for order in orders:
            self._orders[order.id] = order
            self.columns.note(order)
            self.sizes[order.open_items] += 1
            for line in order._open.values():
                self.line_sizes[line.quantity] += 1
        if youngest is not None and by_age(youngest) > by_age(orders[0]):
            self._orders = {order.id: order for order in sorted(self._orders.values(), key=by_age)}
        self._tuple = self._lines = None

    def close(self, order: Order, skus: Sequence[int]) -> list[OrderLine]:
        """Assign open lines of an order, which leaves with the last one; return them."""
        _drop(self.sizes, order.open_items)
        lines = [order._open.pop(sku) for sku in skus]
        self.columns.note(order)
        for line in lines:
            _drop(self.line_sizes, line.quantity)
        if order._open:
            self.sizes[order.open_items] += 1
        else:
            del self._orders[order.id]
        self._tuple = self._lines = None
        return lines


def _drop(counter: Counter[int], size: int) -> None:
    counter[size] -= 1
    if not counter[size]:
        del counter[size]
