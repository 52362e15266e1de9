"""Compiled sums over what pods hold and what orders want; `scores` says what they are for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import helper, njit
from rmfs_core.warehouse import Lines, Stock

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

MANY = 1 << 32
"""More items than all orders want: where stock is unlimited."""


@helper
def listed(lines: Lines, sku: int) -> range:
    """Where the open lines of a SKU are, the oldest order first."""
    return range(lines.first[sku], lines.first[sku] + lines.number[sku])


@njit(cache=True, interpreted=True)
def completed(lines: Lines, stock: Stock, pods: Ints, wanted: Ints, each: Floats) -> Floats:
    """Worth of the orders that pods complete one after another, oldest first, each for itself.

    No item counts for two orders.

    Parameters
    ----------
    lines, stock
        The orders, and what is on pods.
    pods
        Ids of the pods in question.
    wanted
        Items by SKU that go elsewhere before.
    each
        Worth of each order, by row.
    """
    worth, enough, left = np.zeros(len(pods)), np.zeros(len(lines.open_lines), np.int64), np.zeros_like(wanted)
    for i in range(len(pods)):
        before, scarce, alone = np.int64(i) << 32, False, [np.int64(0) for _ in range(0)]
        for entry in range(stock.of_pod[pods[i]], stock.of_pod[pods[i] + 1]):
            sku = stock.sku[entry]
            left[sku] = max(stock.items[entry] - wanted[sku], 0)
            scarce = scarce or left[sku] < MANY
            for at in listed(lines, sku):
                if lines.listed_items[at] <= left[sku]:
                    order = lines.listed_order[at]
                    enough[order] = max(enough[order], before) + 1
                    if enough[order] - before == lines.open_lines[order]:
                        alone.append(order)
        alone.sort()
        for order in alone:
            there, whole = range(lines.begin[order], lines.begin[order + 1]), True
            if scarce:  # of unlimited stock, one order leaves enough for the next
                for line in there:
                    whole = whole and lines.quantity[line] <= left[lines.sku[line]]
                for line in there:
                    left[lines.sku[line]] -= whole * lines.quantity[line]
            worth[i] += whole * each[order]
    return worth


@njit(cache=True, interpreted=True)
def served(lines: Lines, stock: Stock, pods: Ints, wanted: Ints, each: Floats) -> Floats:
    """Worth of the items of orders that pods have free, each for itself; those of the oldest go first.

    Parameters
    ----------
    lines, stock, pods, wanted
        As `completed` has them.
    each
        Worth of an item of each order, by row.
    """
    worth = np.zeros(len(pods))
    for i in range(len(pods)):
        for entry in range(stock.of_pod[pods[i]], stock.of_pod[pods[i] + 1]):
            sku, of_sku = stock.sku[entry], 0.0
            left = max(stock.items[entry] - wanted[sku], 0)
            for at in listed(lines, sku):
                if left <= 0:
                    break
                items = min(left, lines.listed_items[at])
                of_sku += items * each[lines.listed_order[at]]
                left -= items
            worth[i] += of_sku
    return worth
