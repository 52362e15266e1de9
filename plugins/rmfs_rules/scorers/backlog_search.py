"""Compiled sums over what pods hold and what the backlog wants; `scores` says what they are for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import inlined, njit

if TYPE_CHECKING:
    from rmfs_core.warehouse import Lines, Stock

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

MANY = 1 << 32
"""More items than all orders want: where stock is unlimited."""


@njit(cache=True)
def items_on(stock: Stock, pods: Ints, skus: Ints) -> Ints:
    """Free items of SKUs, ascending, on pods; shape (pods, SKUs)."""
    items = np.zeros((len(pods), len(skus)), np.int64)
    for i in range(len(pods)):
        column = 0
        for entry in range(stock.of_pod[pods[i]], stock.of_pod[pods[i] + 1]):
            while column < len(skus) and skus[column] < stock.sku[entry]:
                column += 1
            if column < len(skus) and skus[column] == stock.sku[entry]:
                items[i, column] = stock.items[entry]
    return items


@inlined
def listed(lines: Lines, sku: int) -> range:
    """Where the open lines of a SKU are, the oldest order first."""
    return range(lines.first[sku], lines.first[sku] + lines.number[sku])


@njit(cache=True)
def completed(lines: Lines, stock: Stock, pods: Ints, wanted: Ints) -> Ints:
    """Orders that each pod completes one after another, oldest first, with what is free but for what is wanted by SKU.

    No item counts for two orders.
    """
    number, enough, left = np.zeros(len(pods), np.int64), np.zeros(len(lines.items), np.int64), np.zeros_like(wanted)
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
        if not scarce:  # of unlimited stock, one order leaves enough for the next
            number[i] = len(alone)
            continue
        alone.sort()
        for order in alone:
            there, whole = range(lines.begin[order], lines.begin[order + 1]), True
            for line in there:
                whole = whole and lines.quantity[line] <= left[lines.sku[line]]
            number[i] += whole
            for line in there:
                left[lines.sku[line]] -= whole * lines.quantity[line]
    return number


@njit(cache=True)
def worth(
    lines: Lines, stock: Stock, pods: Ints, wanted: Ints, since_s: Floats, unpicked: Ints, now_s: float, by_age: bool
) -> Floats:
    """What the backlog's items are worth that each pod has free but for what is wanted by SKU; the oldest go first.

    An item is worth 1, or, ``by_age``, the seconds since its order's time, if that has come, by the order's items that
    are not yet picked.
    """
    values = np.zeros(len(pods))
    for i in range(len(pods)):
        for entry in range(stock.of_pod[pods[i]], stock.of_pod[pods[i] + 1]):
            sku, of_sku = stock.sku[entry], 0.0
            left = max(stock.items[entry] - wanted[sku], 0)
            for at in listed(lines, sku):
                if left <= 0:
                    break
                order, served = lines.listed_order[at], min(left, lines.listed_items[at])
                of_sku += served * (max(now_s - since_s[order], 0.0) / unpicked[order] if by_age else 1.0)
                left -= served
            values[i] += of_sku
    return values
