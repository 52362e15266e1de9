"""Compiled account of the open lines of each SKU, the oldest first; `wanted.Backlog` keeps it."""

from __future__ import annotations

import numpy as np

from rmfs_core.jit import njit

ORDER, SKU, QUANTITY = range(3)
"""Rows of the lines that ever joined: the order's place, SKU, items."""
START, LENGTH, ROOM, WANTED = range(4)
"""Of the SKUs: where their lines begin in the pool, how many are there, may be, and the items of all of them."""
LINE, SINCE_S, UNPICKED, ITEMS = range(4)
"""Rows of the pool, where lines of a SKU lie one behind the other: number of the line, since when its order counts (s),
the items of that which are not yet picked, and the line's items."""


@njit(cache=True)
def join(begin, end, used, lines, skus, orders, pool):
    """Put lines behind all others of their SKUs; return the pool, and how much of it is used."""
    for line in range(begin, end):
        sku = lines[SKU, line]
        length, start = skus[LENGTH, sku], skus[START, sku]
        if length == skus[ROOM, sku]:
            room = 2 * (length + 1)
            while used + room > pool.shape[1]:
                pool = np.concatenate((pool, np.zeros_like(pool)), axis=1)
            pool[:, used : used + length] = pool[:, start : start + length]
            skus[START, sku], skus[ROOM, sku] = used, room
            start, used = used, used + room
        at, order = start + length, lines[ORDER, line]
        pool[LINE, at], pool[ITEMS, at] = line, lines[QUANTITY, line]
        pool[SINCE_S, at], pool[UNPICKED, at] = orders[0, order], orders[1, order]
        skus[LENGTH, sku] += 1
        skus[WANTED, sku] += lines[QUANTITY, line]
    return pool, used


@njit(cache=True)
def leave(left, lines, skus, number, pool):
    """Take lines out; return how many more orders are in the backlog in part.

    ``number`` has the lines of each order that are in the backlog, and that were at first.
    """
    parts = 0
    for line in left:
        order, sku = lines[ORDER, line], lines[SKU, line]
        start, end = skus[START, sku], skus[START, sku] + skus[LENGTH, sku]
        at = start + np.searchsorted(pool[LINE, start:end], line)
        for row in range(len(pool)):
            for place in range(at, end - 1):
                pool[row, place] = pool[row, place + 1]
        skus[LENGTH, sku] -= 1
        skus[WANTED, sku] -= lines[QUANTITY, line]
        parts -= 0 < number[0, order] < number[1, order]
        number[0, order] -= 1
        parts += 0 < number[0, order] < number[1, order]
    return parts


@njit(cache=True)
def worth_of(sku, items, now_s, fixed, skus, pool):
    """What so many items of a SKU are worth that go to the oldest orders."""
    total, left = 0.0, float(items)
    for at in range(skus[START, sku], skus[START, sku] + skus[LENGTH, sku]):
        served = min(left, pool[ITEMS, at])  # no branch: which orders are late is hard to foresee
        total += served * (fixed + max(now_s - pool[SINCE_S, at], 0.0) / pool[UNPICKED, at])
        left -= served
        if left <= 0:
            break
    return total


@njit(cache=True)
def worth(number, pod, sku, items, now_s, fixed, skus, pool):
    """What the items on each of so many pods are worth; entries say which pod has how many items of which SKU."""
    values = np.zeros(number)
    of_all = np.full(skus.shape[1], -1.0)  # of a SKU, if there is enough for all orders
    for entry in range(len(pod)):
        which = sku[entry]
        if items[entry] < skus[WANTED, which]:
            values[pod[entry]] += worth_of(which, items[entry], now_s, fixed, skus, pool)
        else:
            if of_all[which] < 0:
                of_all[which] = worth_of(which, items[entry], now_s, fixed, skus, pool)
            values[pod[entry]] += of_all[which]
    return values
