"""Accounts that the warehouse keeps for rules, so that none has to read again what did not change."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_core.warehouse.column_keeping import LineColumns, StockColumns
from rmfs_core.warehouse.parts import Order, OrderLine, Pod
from rmfs_core.warehouse.stock import by_age


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

    order: NDArray[np.int64]
    order_id: NDArray[np.int64]
    sku: NDArray[np.int64]
    quantity: NDArray[np.int64]

    def __attrs_post_init__(self) -> None:
        for array in (self.order, self.order_id, self.sku, self.quantity):
            array.setflags(write=False)


def lines_of(orders: Sequence[Order]) -> BacklogLines:
    """Return the open lines of orders as arrays, in which ``order`` is the position in ``orders``.

    For orders that are not the whole backlog; ``WarehouseView.backlog_lines`` is quicker.
    """
    rows = [(i, order.id, line.sku, line.quantity) for i, order in enumerate(orders) for line in order.open_lines]
    return BacklogLines(*np.array(rows, dtype=np.int64).reshape(-1, 4).T.copy())


class BacklogLog:
    """Lines that joined the backlog and that left it so far, for rules that keep an account of it from call to call.

    A rule remembers how many of each it has seen, and asks for what came since. Orders join by age: when one joins
    late, because it had to wait for stock, a new log begins, in which all orders of the backlog join anew. So another
    log means another run, or such an order: whatever a rule has derived from the last one is void.
    """

    def __init__(self) -> None:
        self._rows = np.empty((3, 1024), dtype=np.int64)
        self._open = np.empty(1024, dtype=bool)
        self._joined = 0
        self._left: list[int] = []
        self._first: dict[int, int] = {}
        self._current = np.zeros(0, dtype=np.int64)
        self._taken_in = 0

    def joined(self, since: int = 0) -> NDArray[np.int64]:
        """Order ids, SKU ids and numbers of items of lines from number ``since`` on, oldest first. Shape (3, n)."""
        return self._rows[:, since : self._joined].copy()

    def left(self, since: int = 0) -> list[int]:
        """Numbers, among those that joined, of the lines that left; the first ``since`` left out."""
        return self._left[since:]

    def _add(self, orders: Collection[Order]) -> None:
        """Take in the lines of orders; those that are assigned already join and leave at once."""
        lines = [(order.id, *line) for order in orders for line in order.lines]
        rows = np.array(lines, dtype=np.int64).reshape(-1, 3)
        begin, end = self._joined, self._joined + len(rows)
        while end > len(self._open):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)], axis=1)
            self._open = np.concatenate([self._open, np.empty_like(self._open)])
        self._rows.T[begin:end] = rows
        self._open[begin:end] = True
        self._joined = end
        for order in orders:
            self._first[order.id] = begin
            begin += len(order.lines)
            if len(order._open) < len(order.lines):
                for line in order.lines:
                    if line.sku not in order._open:
                        self._close(order, line)

    def _close(self, order: Order, line: OrderLine) -> None:
        """Mark a line as assigned."""
        row = self._first[order.id] + order.lines.index(line)
        self._open[row] = False
        self._left.append(row)

    def _lines(self) -> BacklogLines:
        """Return the open lines, oldest order first."""
        current = np.concatenate([self._current, np.arange(self._taken_in, self._joined)])
        self._current, self._taken_in = current[self._open[current]], self._joined
        order, sku, quantity = self._rows[:, self._current]
        position = np.zeros(len(order), dtype=np.int64)
        np.cumsum(order[1:] != order[:-1], out=position[1:])
        return BacklogLines(position, order, sku, quantity)


class Backlog(Sequence[Order]):
    """Orders with open lines, oldest first: themselves, as arrays, and their sizes."""

    def __init__(self, n_skus: int) -> None:
        self.log = BacklogLog()
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
            self._lines = self.log._lines()
        return self._lines

    def add(self, *orders: Order) -> None:
        """Take in orders that arrived, the oldest first."""
        self._count(orders)
        self.log._add(orders)

    def add_late(self, orders: Sequence[Order]) -> None:
        """Take in orders that had to wait, the oldest first; a new log begins if one is older than others there."""
        youngest = next(reversed(self._orders.values()), None)
        if youngest is None or by_age(youngest) < by_age(orders[0]):
            self.add(*orders)
            return
        self._count(orders)
        self._orders = {order.id: order for order in sorted(self._orders.values(), key=by_age)}
        self.log = BacklogLog()
        self.log._add(self._orders.values())

    def _count(self, orders: Sequence[Order]) -> None:
        for order in orders:
            self._orders[order.id] = order
            self.columns.note(order)
            self.sizes[order.open_items] += 1
            for line in order._open.values():
                self.line_sizes[line.quantity] += 1
        self._tuple = self._lines = None

    def close(self, order: Order, skus: Sequence[int]) -> list[OrderLine]:
        """Assign open lines of an order, which leaves with the last one; return them."""
        _drop(self.sizes, order.open_items)
        lines = [order._open.pop(sku) for sku in skus]
        self.columns.note(order)
        for line in lines:
            _drop(self.line_sizes, line.quantity)
            self.log._close(order, line)
        if order._open:
            self.sizes[order.open_items] += 1
        else:
            del self._orders[order.id]
        self._tuple = self._lines = None
        return lines


@frozen(eq=False)
class FreeItems:
    """What the pods hold and no request was promised, as arrays of equal length n.

    `WarehouseView.free_items` has them sorted by pod and SKU, a log's are so up to `FreeItemsLog.ordered`.

    Parameters
    ----------
    pod, sku
        Pod id and SKU id, int64, shape (n,): every SKU that the pod ever held.
    number
        Free items, also none; `UNLIMITED` (2**40) where the stock is unlimited. int64, shape (n,).
    """

    pod: NDArray[np.int64]
    sku: NDArray[np.int64]
    number: NDArray[np.int64]

    def __attrs_post_init__(self) -> None:
        for array in (self.pod, self.sku, self.number):
            array.setflags(write=False)


class FreeItemsLog:
    """Free items of the pods now, and which changed so far, for rules that keep an account of them from call to call.

    A rule remembers how many changes it has seen, and asks for what came since; another run has another log.
    """

    def __init__(self, pods: Sequence[Pod], columns: StockColumns) -> None:
        self._pods, self._columns = pods, columns
        self._touched = columns._logged
        self._places: dict[Pod, dict[int, int]] = {}
        self._changed: list[int] = []
        self._items: FreeItems | None = None
        self._shown: FreeItems | None = None  # a copy of what they are

    @property
    def items(self) -> FreeItems:
        """Free items as they are; whenever the log is asked, ``number`` changes in place.

        Only those of the start are sorted by pod and SKU. When a pod is given a SKU that it never held, these are other
        arrays, with one entry more at the end.
        """
        if self._items is None:
            rows = [n for pod in self._pods for i in sorted(pod._contents) for n in (pod.id, i, pod.free_items(i))]
            self._rows = np.array(rows, dtype=np.int64).reshape(-1, 3).T.copy()  # flat: tuples wake gc
            self._ordered = self._entries = self._rows.shape[1]
            self._items, self._changed = self._first_entries(), list(range(self._entries))
        changed, new = [], []
        self._columns._look()
        for pod, sku in self._touched:
            place, free = self._places_of(pod, self._items).get(sku, -1), pod.free_items(sku)
            if place < 0:
                new.append((pod.id, sku, free))
            elif self._rows[2, place] != free:
                self._rows[2, place] = free
                changed.append(place)
        self._touched.clear()
        if new:
            changed += [self._append(row) for row in sorted(new)]
            self._items = self._first_entries()
        if changed:
            self._changed += sorted(changed)
            self._shown = None
        return self._items

    @property
    def ordered(self) -> int:
        """How many entries there were at first; these are sorted by pod and SKU."""
        _ = self.items
        return self._ordered

    def changed(self, since: int = 0) -> NDArray[np.int64]:
        """Places in the arrays of those that changed, the first ``since`` left out: at first all, then one by one."""
        _ = self.items
        return np.array(self._changed[since:], dtype=np.int64)

    def _places_of(self, pod: Pod, items: FreeItems) -> dict[int, int]:
        """Return where the SKUs of a pod are."""
        if pod not in self._places:
            first, end = items.pod[: self._ordered].searchsorted([pod.id, pod.id + 1]).tolist()
            self._places[pod] = {sku: place for place, sku in enumerate(items.sku[first:end].tolist(), first)}
        return self._places[pod]

    def _append(self, row: tuple[int, int, int]) -> int:
        """Take in an entry; return its place."""
        place = self._entries
        if place == self._rows.shape[1]:
            self._rows = np.concatenate([self._rows, np.zeros((3, place + 16), np.int64)], axis=1)
        self._rows[:, place] = row
        self._places[self._pods[row[0]]][row[1]] = place
        self._entries += 1
        return place

    def _first_entries(self) -> FreeItems:
        """Return what is in the arrays so far."""
        return FreeItems(*self._rows[:, : self._entries])

    def _copy(self) -> FreeItems:
        """Return what does not change any more, sorted, the same object until some of them do."""
        items = self.items
        if self._shown is None:
            order = np.lexsort((items.sku, items.pod)) if self._entries > self._ordered else slice(None)
            self._shown = FreeItems(items.pod[order], items.sku[order], items.number[order].copy())
        return self._shown


def _drop(counter: Counter[int], size: int) -> None:
    counter[size] -= 1
    if not counter[size]:
        del counter[size]
