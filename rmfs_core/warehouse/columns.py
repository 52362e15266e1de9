"""The warehouse in columns: open lines of orders and items of pods as arrays, which rules make their scores of.

Columns follow the objects when they are asked for, and cost what has changed since. Nobody but the kernel writes them.
Whatever a rule reads of them holds for one call: afterwards they change in place, and orders get other rows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]

NEVER = -(1 << 62)
"""Tick at which an order is due that has no due time."""

STORED, BUSY = -1, -2
"""Where a pod may leave from (`Stock.at`): its storage location, or nowhere; else the id of the station it leaves."""


CAPACITY = np.dtype([(name, np.int64) for name in ("free", "load", "capacity", "counts_orders", "inbound")])
"""Capacity of a picking station, as `Station` has it: in items, or in orders where it counts these; and its pods."""


class Lines(NamedTuple):
    """Orders of the backlog and their open lines as columns.

    Each order has a *row* of the columns by order, the oldest order the first. An order that has left keeps its row
    for a while, with no items and no open lines. **Rows hold for one call**: orders that are there are moved together
    when many have left, so nobody may keep a row, or an array of rows, until the next call.

    Compiled functions take it as it is: ``lines.items[row]``. All arrays are read-only.

    Parameters
    ----------
    order_id
        Id of the order, int64, shape (orders,).
    arrival_s, due_s
        When it arrived, and when it is due, infinite without a due time; seconds, float64, shape (orders,).
    priority
        How urgent it is, higher first; int64, shape (orders,).
    items, open_lines
        Its open items and open lines; 0 once it has left the backlog. int64, shape (orders,).
    begin
        Its lines, open or not, are ``begin[row]`` to before ``begin[row + 1]``. int64, shape (orders + 1,).
    order, sku, quantity
        Row of the line's order, SKU id, and items; 0 items once the line is assigned. int64, shape (lines,).
    first, number
        The open lines of a SKU are at ``first[sku]`` to before ``first[sku] + number[sku]`` of the next two, those of
        the oldest order first. int64, shape (n_skus,).
    listed_order, listed_items
        Row of the line's order, and items, int64, longer than all lists together.
    row
        Row by order id, -1 for orders that are not there; int64, longer than the highest id.
    """

    order_id: Ints
    arrival_s: NDArray[np.float64]
    due_s: NDArray[np.float64]
    priority: Ints
    items: Ints
    open_lines: Ints
    begin: Ints
    order: Ints
    sku: Ints
    quantity: Ints
    first: Ints
    number: Ints
    listed_order: Ints
    listed_items: Ints
    row: Ints

    @property
    def begun(self) -> Ints:
        """Rows of the orders of which some lines are assigned and others open, ascending."""
        begun = (self.open_lines > 0) & (self.open_lines < np.diff(self.begin))
        return np.flatnonzero(begun)

    def of_order(self, row: int) -> list[tuple[int, int]]:
        """Return SKU and items of each open line of an order."""
        there = slice(*self.begin[row : row + 2].tolist())
        lines = zip(self.sku[there].tolist(), self.quantity[there].tolist(), strict=True)
        return [(sku, items) for sku, items in lines if items]


class Stock(NamedTuple):
    """Items of the pods that no request was promised, and where the pods are, as columns.

    What it says holds for one call; later it changes in place. Compiled functions take it as it is:
    ``stock.items[entry]``. All arrays are read-only.

    Parameters
    ----------
    pod, sku
        Pod id and SKU id of each entry, sorted by pod and SKU: every SKU that the pod ever held. int64, shape
        (entries,).
    items
        Free items, also none; `UNLIMITED` (2**40) where the stock is unlimited. int64, shape (entries,).
    of_pod
        The entries of a pod are ``of_pod[pod]`` to before ``of_pod[pod + 1]``. int64, shape (pods + 1,).
    by_sku
        All entries, sorted by SKU and pod. int64, shape (entries,).
    of_sku
        The entries of a SKU are ``by_sku[of_sku[sku]]`` to before ``by_sku[of_sku[sku + 1]]``. int64, shape
        (n_skus + 1,).
    at
        Where a pod may be sent from: `STORED` (-1) for a stored pod that is bound nowhere, the id of the station that
        it is about to leave, `BUSY` (-2) for all others. int64, shape (pods,).
    bound
        Id of the picking station that a pod is at or bound for last, -1: none. int64, shape (pods,).
    cell
        Cell index of a pod that may be sent; whatever for others. int64, shape (pods,).
    location
        Cell index of the storage location that a pod stands in, bound or not; -1 while it is carried. int64, shape
        (pods,).
    space
        Space of the pod's capacity that neither items nor bundles to come take; `UNLIMITED` without a capacity. int64,
        shape (pods,).
    """

    pod: Ints
    sku: Ints
    items: Ints
    of_pod: Ints
    by_sku: Ints
    of_sku: Ints
    at: Ints
    bound: Ints
    cell: Ints
    location: Ints
    space: Ints
