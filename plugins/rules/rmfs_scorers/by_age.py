"""Compiled account of the open lines of each SKU, the oldest first; `wanted.Backlog` keeps it."""

from __future__ import annotations

import numpy as np
from numba import njit

ORDER, SKU, QUANTITY, NEXT, BEFORE = range(5)
"""Rows of the lines: the order's place, SKU, items, and the lines of the SKU that come next and before."""
FIRST, LAST, WANTED = range(3)
"""Rows of the SKUs: the first and the last line, and the items of all of them."""
SINCE_S, UNPICKED = range(2)
"""Rows of the orders."""
NONE = -1


@njit(cache=True)
def join(begin, end, lines, skus):  # type: ignore[no-untyped-def]
    """Put lines behind all others of their SKUs."""
    for line in range(begin, end):
        sku = lines[SKU, line]
        last = skus[LAST, sku]
        lines[NEXT, line], lines[BEFORE, line] = NONE, last
        if last == NONE:
            skus[FIRST, sku] = line
        else:
            lines[NEXT, last] = line
        skus[LAST, sku] = line
        skus[WANTED, sku] += lines[QUANTITY, line]


@njit(cache=True)
def leave(left, lines, skus, number):  # type: ignore[no-untyped-def]
    """Take lines out; return how many more orders are in the backlog in part.

    ``number`` has the lines of each order that are in the backlog, and that were at first.
    """
    parts = 0
    for line in left:
        order, sku, after, before = lines[ORDER, line], lines[SKU, line], lines[NEXT, line], lines[BEFORE, line]
        if before == NONE:
            skus[FIRST, sku] = after
        else:
            lines[NEXT, before] = after
        if after == NONE:
            skus[LAST, sku] = before
        else:
            lines[BEFORE, after] = before
        skus[WANTED, sku] -= lines[QUANTITY, line]
        parts -= 0 < number[0, order] < number[1, order]
        number[0, order] -= 1
        parts += 0 < number[0, order] < number[1, order]
    return parts


@njit(cache=True)
def worth_of(sku, items, now_s, fixed, lines, skus, orders):  # type: ignore[no-untyped-def]
    """What so many items of a SKU are worth that go to the oldest orders."""
    total, line = 0.0, skus[FIRST, sku]
    while items > 0 and line != NONE:
        served, order = min(items, lines[QUANTITY, line]), lines[ORDER, line]
        total += served * (fixed + max(now_s - orders[SINCE_S, order], 0.0) / orders[UNPICKED, order])
        items -= served
        line = lines[NEXT, line]
    return total


@njit(cache=True)
def worth(number, pod, sku, items, now_s, fixed, lines, skus, orders):  # type: ignore[no-untyped-def]
    """What the items on each of so many pods are worth; entries say which pod has how many items of which SKU."""
    values = np.zeros(number)
    of_all = np.full(skus.shape[1], -1.0)  # of a SKU, if there is enough for all orders
    for entry in range(len(pod)):
        which = sku[entry]
        if items[entry] < skus[WANTED, which]:
            values[pod[entry]] += worth_of(which, items[entry], now_s, fixed, lines, skus, orders)
        else:
            if of_all[which] < 0:
                of_all[which] = worth_of(which, items[entry], now_s, fixed, lines, skus, orders)
            values[pod[entry]] += of_all[which]
    return values
