"""Keeps the columns of the warehouse as the objects are: what changed is noted, and read when columns are asked for."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rmfs_core.warehouse.claims import by_age
from rmfs_core.warehouse.columns import BUSY, NEVER, STORED, Lines, Stock
from rmfs_core.warehouse.parts import Order, Pod

Ints = NDArray[np.int64]

SPARE = 64
"""Orders that have left may be so many more than present ones."""

_BY_ORDER = ("order_id", "arrival_s", "due_s", "priority", "items", "open_lines")
_BY_LINE = ("order", "sku", "quantity")
_LISTED = ("listed_order", "listed_items")


@cache
def _compiled() -> Any:
    from rmfs_core.warehouse import columns_search  # imported when needed, for it takes its time

    return columns_search


class LineColumns:
    """Keeps `Lines`: follows the orders that are noted.

    Parameters
    ----------
    n_skus
        Number of SKUs.
    orders
        Orders whose number and lines the columns are as long as at first.
    """

    def __init__(self, n_skus: int, orders: Sequence[Order] = ()) -> None:
        self._changed: dict[int, Order] = {}  # orders that joined, or whose lines were assigned, since
        self._orders = self._lines = self._used = self._gone = 0
        n, m = len(orders), sum(len(order.lines) for order in orders)
        long = {"begin": n + 1, "first": n_skus, "number": n_skus, "row": 0}
        long |= dict.fromkeys(_BY_LINE, m) | dict.fromkeys(_LISTED, 4 * m)
        kinds: dict[str, Any] = {"arrival_s": np.float64, "due_s": np.float64}
        self._all = Lines(*(np.zeros(long.get(name, n), kinds.get(name, np.int64)) for name in Lines._fields))
        self._room = np.zeros(n_skus, np.int64)  # of each SKU's list
        self._looked_at: Lines | None = None  # of which there are views for looking only
        if not orders:
            self._show()

    def note(self, order: Order) -> None:
        """Note that an order has joined the backlog, or that lines of it were assigned."""
        self._changed[order.id] = order

    def lines(self) -> Lines:
        """Return the columns as the orders are now."""
        if self._changed:
            self._follow()
        return self._shown

    def _follow(self) -> None:
        """Let lines leave that were assigned, and orders join."""
        there, last = self._all, self._orders - 1
        new: list[Order] = []
        left: list[int] = []
        for order in self._changed.values():
            row = int(there.row[order.id]) if order.id < len(there.row) else -1
            if row >= 0:
                lines = enumerate(order.lines, int(there.begin[row]))
                left += [number for number, (sku, _) in lines if sku not in order._open and there.quantity[number]]
            elif order._open:
                new.append(order)
        self._changed.clear()
        if len(new) > 1:
            new.sort(key=by_age)
        late = bool(new) and last >= 0 and (new[0].arrival_s, new[0].id) < (there.arrival_s[last], there.order_id[last])
        self._join(new, left)
        if late:  # they had to wait for stock
            self._keep(np.lexsort((self._shown.order_id, self._shown.arrival_s)))
        if self._gone > SPARE + (self._orders - self._gone):
            self._keep(np.arange(self._orders))

    def _join(self, orders: Sequence[Order], left: Sequence[int] = ()) -> None:
        """Let lines leave, and put orders behind all others."""
        told, begin, line, ids = [len(left), *left], self._orders, self._lines, 0
        for order in orders:
            is_open, due = order._open, NEVER if order.due_tick is None else order.due_tick
            told += order.id, order.arrival_tick, due, order.priority, len(order.lines)
            for sku, items in order.lines:
                told += sku, items if sku in is_open else 0
            self._lines += len(order.lines)
            ids = max(ids, order.id + 1)
        self._orders += len(orders)
        self._make_room(ids)
        gone, line, self._used = _compiled().follow(
            tuple(self._all), self._room, np.array(told, np.int64), begin, line, self._used
        )
        self._gone += gone
        while line < self._lines:  # the lists need more space
            self._all = _longer(self._all, _LISTED, 2 * len(self._all.listed_order) + 2 * (self._lines - line) + 16)
            line, self._used = _compiled().enlist(self._all, self._room, line, self._lines, self._used)
        if orders:
            self._show()

    def _make_room(self, ids: int) -> None:
        """Let the columns have rows for all orders, lines and ids."""
        there = self._all
        if self._orders > len(there.order_id):
            self._all = _longer(self._all, _BY_ORDER, 2 * self._orders)
            self._all = _longer(self._all, ("begin",), 2 * self._orders + 1)
        if self._lines > len(there.sku):
            self._all = _longer(self._all, _BY_LINE, 2 * self._lines)
        if ids > len(there.row):
            self._all = _longer(self._all, ("row",), 2 * ids, -1)

    def _keep(self, rows: Ints) -> None:
        """Move the orders at some rows together, in this order; orders that have left go."""
        there = self._shown
        rows = rows[there.open_lines[rows] > 0]
        number = there.begin[rows + 1] - there.begin[rows]
        begin = np.concatenate([[0], np.cumsum(number)])
        line = np.arange(begin[-1]) + np.repeat(there.begin[rows] - begin[:-1], number)
        self._orders, self._lines, self._gone = len(rows), len(line), 0
        row = np.full_like(there.row, -1)
        row[there.order_id[rows]] = np.arange(len(rows))
        self._room = np.bincount(there.sku[line][there.quantity[line] > 0], minlength=len(there.first))
        self._used = int(self._room.sum())
        self._all = Lines(
            **{name: getattr(there, name)[rows] for name in _BY_ORDER},
            begin=begin,
            order=np.repeat(np.arange(len(rows)), number),
            sku=there.sku[line],
            quantity=there.quantity[line],
            first=np.cumsum(self._room) - self._room,
            number=np.zeros_like(self._room),
            listed_order=np.zeros(self._used, np.int64),
            listed_items=np.zeros(self._used, np.int64),
            row=row,
        )
        _compiled().enlist(self._all, self._room, 0, len(line), self._used)
        self._show()

    def _show(self) -> None:
        """Make what is shown of the columns, for looking only."""
        if self._looked_at is not self._all:
            self._looked_at, self._views = self._all, Lines(*map(shown, self._all))
        (order_id, arrival_s, due_s, priority, items, open_lines, begin, order, sku, quantity, *others) = self._views
        n, m = self._orders, self._lines
        by_order = order_id[:n], arrival_s[:n], due_s[:n], priority[:n], items[:n], open_lines[:n], begin[: n + 1]
        self._shown = Lines(*by_order, order[:m], sku[:m], quantity[:m], *others)


def columns_of(orders: Sequence[Order], n_skus: int) -> Lines:
    """Return the columns of some orders, whose rows are their positions."""
    columns = LineColumns(n_skus, orders)
    columns._join(orders)
    return columns._shown


def stock_of(pods: Sequence[Pod], n_skus: int) -> Stock:
    """Return the columns of some pods, with the ids 0, 1, ..., of which none is about to leave a station."""
    return StockColumns(pods, n_skus, 0).stock(())


class StockColumns:
    """Keeps `Stock`: follows the pods that are noted.

    Parameters
    ----------
    pods
        The pods, by id.
    n_skus, n_picking
        Number of SKUs; number of picking stations, which have the lowest ids.
    """

    def __init__(self, pods: Sequence[Pod], n_skus: int, n_picking: int) -> None:
        self._pods, self._n_skus, self._n_picking = pods, n_skus, n_picking
        self._touched: set[tuple[Pod, int]] = set()  # SKUs of pods to be read anew
        for pod in pods:
            pod._touched = self._touched
        self._all: Stock | None = None
        self._moved = {*range(len(pods))}

    def note(self, pod: Pod) -> None:
        """Note that a pod may be elsewhere, bound for another station, or have other space."""
        self._moved.add(pod.id)

    def stock(self, leaving: Iterable[Pod]) -> Stock:
        """Return the columns as the pods are now.

        Parameters
        ----------
        leaving
            Pods that are about to leave a station.
        """
        if self._all is None:
            self._begin()
        elif self._touched:
            rows = np.array([(pod.id, sku, pod.free_items(sku)) for pod, sku in self._touched], np.int64)
            if missing := _compiled().put(self._all, rows):
                self._insert(rows[:missing])
        self._touched.clear()
        assert self._all is not None
        at, bound, cell, locations, space = self._all[-5:]
        for number in self._moved:
            pod = self._pods[number]
            location, space[number] = pod._location, pod.free_space
            bound[number] = -1
            for station in pod._itinerary:  # the last one of those where orders are picked
                if station < self._n_picking:
                    bound[number] = station
            if location is None:
                at[number], locations[number] = BUSY, -1
            else:
                at[number], locations[number] = BUSY if pod._itinerary else STORED, location
                cell[number] = location
        self._moved.clear()
        for pod in leaving:
            at[pod.id], cell[pod.id] = pod._itinerary[0], pod.cell
            self._moved.add(pod.id)
        return self._shown

    def _begin(self) -> None:
        """Read all pods."""
        rows = [n for pod in self._pods for i in sorted(pod._contents) for n in (pod.id, i, pod.free_items(i))]
        pod, sku, items = np.array(rows, np.int64).reshape(-1, 3).T.copy()
        ends = np.arange(len(self._pods) + 1), np.arange(self._n_skus + 1)
        by_sku = np.lexsort((pod, sku))
        of_pod, of_sku = pod.searchsorted(ends[0]), sku[by_sku].searchsorted(ends[1])
        where = np.zeros((5, len(self._pods)), np.int64)
        self._all = Stock(pod, sku, items, of_pod, by_sku, of_sku, *where)
        self._shown = Stock(*map(shown, self._all))

    def _insert(self, rows: Ints) -> None:
        """Take in entries of SKUs that pods never held."""
        for pod, sku, items in rows.tolist():
            there = self._all
            assert there is not None
            begin, end = there.of_pod[pod : pod + 2].tolist()
            entry = begin + int(there.sku[begin:end].searchsorted(sku))
            begin, end = there.of_sku[sku : sku + 2].tolist()
            at = begin + int(there.by_sku[begin:end].searchsorted(entry))
            there.of_pod[pod + 1 :] += 1
            there.of_sku[sku + 1 :] += 1
            by_sku = np.insert(there.by_sku + (there.by_sku >= entry), at, entry)
            new = {
                name: np.insert(getattr(there, name), entry, value)
                for name, value in zip(("pod", "sku", "items"), (pod, sku, items), strict=True)
            }
            self._all = there._replace(by_sku=by_sku, **new)
            self._shown = Stock(*map(shown, self._all))


def shown(array: NDArray[Any]) -> NDArray[Any]:
    """Return a view of an array, for looking only."""
    view = array[:]
    view.setflags(write=False)
    return view


def _longer(lines: Lines, names: Iterable[str], length: int, value: int = 0) -> Lines:
    """Return columns of which some are so long, filled up with a value."""
    longer = {}
    for name in names:
        old = getattr(lines, name)
        longer[name] = np.full(length, value, old.dtype)
        longer[name][: len(old)] = old
    return lines._replace(**longer)
