"""What is wanted of a pod: by the requests of a station, and by the backlog."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, Request, WarehouseView

Ids = NDArray[np.int64]
Values = NDArray[np.float64]
Worth = Callable[["Order"], float]
"""What an item of an order is worth."""


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
    """The open lines of the backlog, by SKU, the oldest order first."""

    def __init__(self, warehouse: WarehouseView) -> None:
        lines = warehouse.backlog_lines
        by_sku = np.argsort(lines.sku, kind="stable")
        self._warehouse = warehouse
        self._order, self._quantity = lines.order[by_sku], lines.quantity[by_sku]
        self._first = np.searchsorted(lines.sku[by_sku], np.arange(warehouse.n_skus + 1))
        self._items = np.concatenate(([0], np.cumsum(self._quantity)))

    def work(self, held: Held, worth: Worth) -> Values:
        """Return what the items are worth that each pod has for the backlog; those of the oldest orders first."""
        each = np.array([worth(order) for order in self._warehouse.backlog], np.float64)
        sums = np.concatenate(([0.0], np.cumsum(self._quantity * each[self._order])))
        start, end = self._items[self._first[held.sku]], self._items[self._first[held.sku + 1]]
        upto = np.minimum(start + np.minimum(held.items, end - start), end)
        values = np.interp(upto, self._items, sums) - np.interp(start, self._items, sums)
        return np.bincount(held.pod, weights=values, minlength=held.number).astype(np.float64)
