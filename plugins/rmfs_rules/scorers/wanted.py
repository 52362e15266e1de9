"""What is wanted of a pod: by the requests of a station, and by the backlog."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, Request, WarehouseView

Ids = NDArray[np.int64]
Values = NDArray[np.float64]
Worth = Callable[["Order"], float]
"""What an item of an order is worth."""
Since = Callable[["Order"], float]
"""From when on an order is worth more by the second, in seconds; infinite: never."""


@frozen(eq=False)
class Requests:
    """Uncovered requests of a station.

    Parameters
    ----------
    requests
        The requests, oldest first.
    skus
        Ids of their SKUs, ascending, shape (k,).
    column
        Where each request's SKU is among these.
    row
        Where each request's order is among those of the requests, first come, first there.
    needs
        Items by order and SKU, shape (orders, k).
    """

    requests: Sequence[Request]
    skus: Ids
    column: Ids
    row: Ids
    needs: NDArray[np.int64]

    @classmethod
    def of(cls, requests: Sequence[Request]) -> Requests:
        """Count requests by order and SKU."""
        rows = {order: i for i, order in enumerate(dict.fromkeys(request.order.id for request in requests))}
        row = np.array([rows[request.order.id] for request in requests], np.int64)
        skus, column = np.unique(np.array([request.sku for request in requests], np.int64), return_inverse=True)
        needs = np.zeros((len(rows), len(skus)), np.int64)
        np.add.at(needs, (row, column), 1)
        return cls(requests, skus, column, row, needs)

    def worth(self, worth: Worth) -> Values:
        """Return what each request is worth."""
        return np.array([worth(request.order) for request in self.requests])


@frozen(eq=False)
class Held:
    """Items on the candidate pods, an entry for each pod and SKU.

    Parameters
    ----------
    number
        Number of candidates.
    pod
        Which of the candidates, ascending.
    sku, items
        SKU id and number of items.
    """

    number: int
    pod: Ids
    sku: Ids
    items: Ids


class Backlog:
    """The open lines of the backlog by SKU, the oldest order first; what did not change since a call is not read again.

    Parameters
    ----------
    since
        From when on an order is worth more by the second, in seconds.
    """

    def __init__(self, since: Since) -> None:
        self._since, self._log = since, None
        self._begin(0)

    @classmethod
    def load(cls) -> None:
        """Load what is compiled, or compile it."""
        tiny = cls(lambda _order: 0.0)
        tiny._begin(1)
        tiny._work.join(0, 1, 0, tiny._lines, tiny._skus, tiny._orders, tiny._pool)
        tiny._work.leave(np.zeros(1, np.int64), tiny._lines, tiny._skus, tiny._open, tiny._pool)
        tiny.work(Held(1, *np.zeros((3, 1), np.int64)), 0.0)

    @property
    def whole(self) -> bool:
        """Whether no order of the backlog was assigned in part."""
        return not self._parts

    def update(self, warehouse: WarehouseView) -> None:
        """Take in what joined and left the backlog, whatever filters leave of it."""
        log: Any = warehouse.backlog_log()
        if log is not self._log:
            self._begin(warehouse.n_skus)
            self._log = log
        joined, left = log.joined(self._joined), log.left(self._left)
        self._join(warehouse, joined)
        self._left += len(left)
        if left:
            self._parts += self._work.leave(np.array(left, np.int64), self._lines, self._skus, self._open, self._pool)

    def read(self, warehouse: WarehouseView) -> None:
        """Take in the open lines of the backlog that is shown, and nothing else."""
        lines = warehouse.backlog_lines
        self._begin(warehouse.n_skus)
        self._log = None
        self._join(warehouse, np.array([lines.order_id, lines.sku, lines.quantity]))

    def work(self, held: Held, now_s: float, fixed: float = 0.0) -> Values:
        """Return what the items are worth that each pod has for the backlog; those of the oldest orders go first.

        An item is worth the seconds since its order's time, none if that is yet to come, divided by the items of the
        order that are not yet picked; and ``fixed`` besides.
        """
        worth: Values = self._work.worth(
            held.number, held.pod, held.sku, held.items, now_s, fixed, self._skus, self._pool
        )
        return worth

    def _begin(self, skus: int) -> None:
        """Start anew with an empty backlog."""
        from rmfs_rules.scorers import by_age  # compiled: imported when needed, for it takes its time

        self._work: Any = by_age
        self._joined = self._left = self._number = self._parts = self._used = 0
        self._lines = np.zeros((3, 256), np.int64)
        self._skus = np.zeros((4, skus), np.int64)
        self._pool = np.zeros((4, 256))
        self._open = np.zeros((2, 256), np.int64)  # lines of each order, in the backlog and at first
        self._orders = np.zeros((2, 256))  # since when it counts (s), items not yet picked

    def _join(self, warehouse: WarehouseView, rows: Ids) -> None:
        """Take in lines that joined, as order ids, SKU ids and numbers of items."""
        begin, end = self._joined, self._joined + rows.shape[1]
        if begin == end:
            return
        first = np.flatnonzero(np.diff(rows[0], prepend=-1))
        orders = [warehouse.order(order) for order in rows[0, first].tolist()]
        number = self._number + len(first)
        self._lines = _with_room(self._lines, end)
        self._open, self._orders = _with_room(self._open, number), _with_room(self._orders, number)
        self._orders[0, self._number : number] = [self._since(order) for order in orders]
        self._orders[1, self._number : number] = [order.unpicked_items for order in orders]
        count = np.diff(first, append=rows.shape[1])
        self._open[:, self._number : number] = count
        self._lines[0, begin:end] = np.repeat(np.arange(self._number, number), count)
        self._lines[1:, begin:end] = rows[1:]
        self._pool, self._used = self._work.join(
            begin, end, self._used, self._lines, self._skus, self._orders, self._pool
        )
        self._joined, self._number = end, number


def _with_room(array: NDArray[Any], columns: int) -> NDArray[Any]:
    """Return an array with so many columns at least."""
    while array.shape[1] < columns:
        array = np.concatenate([array, np.zeros_like(array)], axis=1)
    return array
