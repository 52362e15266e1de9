"""What a station wants of a pod."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, Request

Ids = NDArray[np.int64]
Values = NDArray[np.float64]


@frozen(eq=False)
class Requests:
    """Uncovered requests of a station.

    Parameters
    ----------
    requests
        The requests, oldest first.
    items
        Items of each that are uncovered, shape (requests,).
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
    items: Ids
    skus: Ids
    column: Ids
    row: Ids
    needs: NDArray[np.int64]

    @classmethod
    def of(cls, requests: Sequence[Request], items: Sequence[int]) -> Requests:
        """Count items of requests by order and SKU."""
        rows = {order: i for i, order in enumerate(dict.fromkeys(request.order.id for request in requests))}
        row = np.array([rows[request.order.id] for request in requests], np.int64)
        skus, column = np.unique(np.array([request.sku for request in requests], np.int64), return_inverse=True)
        needs = np.zeros((len(rows), len(skus)), np.int64)
        np.add.at(needs, (row, column), items)
        return cls(requests, np.array(items, np.int64), skus, column, row, needs)

    def worth(self, worth: Callable[[Order], float]) -> Values:
        """Return what an item of each request is worth."""
        return np.array([worth(request.order) for request in self.requests])
