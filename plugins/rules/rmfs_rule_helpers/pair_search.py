"""Compiled work on the scores of pairs of order and station; `pair_scores` says what the arrays are."""

from __future__ import annotations

import numpy as np
from numba import njit

BLOCK = 128
"""Orders whose best scores are kept together."""
SIZES = 8
"""Sizes of orders whose best scores are kept apart; the last one has all that are larger, too."""
ORDER, SKU, QUANTITY, BEFORE, AFTER = range(5)
"""Rows of the lines: the order's place, SKU, items, and the lines of the same SKU before and after it (-1: none)."""
OPEN, ITEMS = range(2)
"""Rows of the orders: open lines (0: not in the backlog), and items."""


@njit(cache=True, inline="always")
def raise_best(station, order, orders, scores, best):  # type: ignore[no-untyped-def]
    """Let the best score of an order's block be no lower than the order's."""
    size, block = min(orders[ITEMS, order], SIZES) - 1, order // BLOCK
    best[station, block, size] = max(best[station, block, size], scores[station, order])


@njit(cache=True)
def update(  # type: ignore[no-untyped-def]
    rows, left, begin, number, first, room, available, ids, starts, lines, heads, orders, scores, best, known
):  # fmt: skip
    """Take in lines that joined the backlog from ``begin`` on and lines that left it, and what stations have available.

    ``rows`` has order id, SKU and items of those that joined; there is room for them in the arrays. Returns how many
    orders there are then, the first that may be in the backlog, the largest that joined, and how many more are in it in
    part.
    """
    number, largest = _join(rows, begin, number, ids, starts, lines, heads, orders, scores, best, known)
    parts = _leave(left, starts, lines, heads, orders, scores, best, known)
    while first < number and not orders[OPEN, first]:
        first += 1
    change_all(room, available, lines, heads, orders, scores, best, known)
    return number, first, largest, parts


@njit(cache=True)
def _join(rows, begin, number, ids, starts, lines, heads, orders, scores, best, known):  # type: ignore[no-untyped-def]
    """Take in lines that joined the backlog; lines of an order join together."""
    largest = 0
    for i in range(rows.shape[1]):
        line, sku, quantity = begin + i, rows[1, i], rows[2, i]
        if i == 0 or rows[0, i] != ids[number - 1]:
            ids[number], starts[number] = rows[0, i], line
            number += 1
        order = number - 1
        lines[ORDER, line], lines[SKU, line], lines[QUANTITY, line] = order, sku, quantity
        lines[BEFORE, line], lines[AFTER, line] = -1, heads[sku]
        if heads[sku] >= 0:
            lines[BEFORE, heads[sku]] = line
        heads[sku] = line
        orders[OPEN, order] += 1
        orders[ITEMS, order] += quantity
        largest = max(largest, orders[ITEMS, order])
        for station in range(len(known)):
            scores[station, order] += min(quantity, known[station, sku])
            raise_best(station, order, orders, scores, best)
    starts[number] = begin + rows.shape[1]
    return number, largest


@njit(cache=True)
def _leave(left, starts, lines, heads, orders, scores, best, known):  # type: ignore[no-untyped-def]
    """Take out lines that left the backlog; returns how many more orders are in it in part."""
    parts = 0
    for line in left:
        order, sku, quantity = lines[ORDER, line], lines[SKU, line], lines[QUANTITY, line]
        before, after = lines[BEFORE, line], lines[AFTER, line]
        if before >= 0:
            lines[AFTER, before] = after
        else:
            heads[sku] = after
        if after >= 0:
            lines[BEFORE, after] = before
        parts -= 0 < orders[OPEN, order] < starts[order + 1] - starts[order]
        orders[OPEN, order] -= 1
        orders[ITEMS, order] -= quantity
        parts += 0 < orders[OPEN, order] < starts[order + 1] - starts[order]
        for station in range(len(known)):
            scores[station, order] -= min(quantity, known[station, sku])
            if orders[OPEN, order]:
                raise_best(station, order, orders, scores, best)
    return parts


@njit(cache=True)
def change(station, sku, items, lines, heads, orders, scores, best, known):  # type: ignore[no-untyped-def]
    """Let a station have another number of items of a SKU available."""
    had = known[station, sku]
    known[station, sku] = items
    line = heads[sku]
    while line >= 0:
        order, quantity = lines[ORDER, line], lines[QUANTITY, line]
        scores[station, order] += min(quantity, items) - min(quantity, had)
        if items > had:
            raise_best(station, order, orders, scores, best)
        line = lines[AFTER, line]


@njit(cache=True)
def change_all(stations, available, lines, heads, orders, scores, best, known):  # type: ignore[no-untyped-def]
    """Let those stations have available what they have now."""
    for station in np.flatnonzero(stations):
        for sku in range(known.shape[1]):
            if available[station, sku] != known[station, sku]:
                change(station, sku, available[station, sku], lines, heads, orders, scores, best, known)


@njit(cache=True)
def best_pair(free, counts, load, first, number, orders, taken, scores, best):  # type: ignore[no-untyped-def]
    """Place of the order and id of the station with the highest score that fits; (-1, -1) when none fits.

    Ties go to the oldest order, then to the station with the lowest load, then the lowest id. ``best`` is at least the
    highest score in each block, and is put right where a block is looked through.
    """
    found, at, where = -1, -1, -1
    highest = np.empty(SIZES, np.int64)
    for station in range(len(free)):
        sizes = SIZES if counts[station] else min(free[station], SIZES)  # of orders that may fit
        if free[station] <= 0:
            continue
        for block in range(first // BLOCK, (number + BLOCK - 1) // BLOCK):
            bound = -1
            for size in range(sizes):
                bound = max(bound, best[station, block, size])
            if bound < found or (bound == found and at < block * BLOCK):
                continue
            highest[:] = -1
            for order in range(block * BLOCK, min((block + 1) * BLOCK, number)):
                if not orders[OPEN, order]:
                    continue
                score, items = scores[station, order], orders[ITEMS, order]
                size = min(items, SIZES) - 1
                highest[size] = max(highest[size], score)
                if score < found or taken[order] or (not counts[station] and items > free[station]):
                    continue
                if score > found or order < at or (order == at and load[station] < load[where]):
                    found, at, where = score, order, station
            best[station, block] = highest
    return at, where
