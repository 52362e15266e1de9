"""Compiled work on the scores of pairs of order and station; `pair_scores` says what the arrays are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import inlined, njit

BLOCK = 128
"""Orders of a size whose scores lie side by side, and whose best is kept."""
SIZES = 8
"""Sizes of orders that are kept apart, by the items they have when they join; the last one has all larger ones, too."""
RECENT = 1024
"""Changes of what is available that are remembered by station, as table * SKUs + SKU."""
ORDER, SKU, QUANTITY, AT = range(4)
"""Rows of the lines: the order's place, SKU, items, and where the line is among those of its SKU and size."""
START, LENGTH, ROOM = range(3)
"""Of the shelves, one for each SKU and size: where their lines begin in the pool, how many are there, may be."""
OPEN, ITEMS, SIZE, SLOT = range(4)
"""Rows of the orders: open lines (0: not in the backlog), items, the size among `SIZES`, and where its scores are."""
PLACE, WANTED, LINE, SCORE = range(4)
"""Columns of the pool: the order's place, items, the line, and where the order's scores are."""
FIRST, NUMBER = range(2)
"""Rows of the counts by size: blocks that all orders have left, oldest first, and orders that ever joined."""
LATE = 1 << 30
"""What an order scores besides once it is late, where such orders go first."""
LATE_TO_ALL = -1
"""Of the scores by station, the last: what an order scores besides at each of the others."""
EXACT = 2.0**-53
"""What 53 bits of a lot are multiplied by, to lie between 0 and 1."""


class Blocks(NamedTuple):
    """Where scores are: orders of a size share blocks, in the order in which they joined.

    Parameters
    ----------
    places
        The order's place by where its scores are; -1: none, or it has left.
    oldest, least
        By block: the place of the first order, and the lowest rank of any that joined.
    of_size
        Blocks by size, shape (sizes, blocks).
    counts
        See `FIRST` and `NUMBER`, shape (2, sizes).
    """

    places: NDArray[np.int32]
    oldest: NDArray[np.int64]
    least: NDArray[np.float64]
    of_size: NDArray[np.int64]
    counts: NDArray[np.int64]


@inlined
def value_of(station, slot, order, orders, scores):  # type: ignore[no-untyped-def]
    """What a pair counts: its score, and by less than one the share of the order's lines that the second table has."""
    score = np.float64(scores[0, station, slot] + scores[0, LATE_TO_ALL, slot])
    return score if len(scores) == 1 else score + 0.5 * (scores[1, station, slot] / orders[OPEN, order])


@inlined
def raise_best(station, slot, order, orders, scores, ranks, best):  # type: ignore[no-untyped-def]
    """Let the best value of an order's block, and the first rank that has it, be no worse than the order's."""
    block, value = slot // BLOCK, value_of(station, slot, order, orders, scores)
    if value > best[0, station, block]:
        best[0, station, block], best[1, station, block] = value, ranks[order]
    elif value == best[0, station, block]:
        best[1, station, block] = min(best[1, station, block], ranks[order])


@njit(cache=True)
def update(  # type: ignore[no-untyped-def]
    rows, left, begin, number, first, used, ids, starts, lines, blocks,
    shelves, most, pool, orders, scores, ranks, best, known,
):  # fmt: skip
    """Take in lines that joined the backlog from ``begin`` on, and lines that left it.

    ``rows`` has order id, SKU and items of those that joined; there is room for them in the arrays, but for the pool,
    which grows. Returns how many orders there are then, the first that may be in the backlog, the largest that joined,
    how many more are in it in part, how many late ones left it, the pool, and how much of it is used.
    """
    before = number
    number, largest = _join(rows, begin, number, ids, starts, lines, blocks, orders, scores, ranks)
    pool, used = _add(before, number, used, starts, lines, shelves, most, pool, orders, scores, ranks, best, known)
    parts, late = _leave(left, starts, lines, blocks, shelves, pool, orders, scores, ranks, best, known)
    while first < number and not orders[OPEN, first]:
        first += 1
    for size in range(SIZES):  # all have left a block if the next one begins with the first order, or before it
        while (blocks.counts[FIRST, size] + 1) * BLOCK < blocks.counts[NUMBER, size]:
            if blocks.oldest[blocks.of_size[size, blocks.counts[FIRST, size] + 1]] > first:
                break
            blocks.counts[FIRST, size] += 1
    return number, first, largest, parts, late, pool, used


@njit(cache=True)
def _join(rows, begin, number, ids, starts, lines, blocks, orders, scores, ranks):  # type: ignore[no-untyped-def]
    """Take in lines that joined the backlog; lines of an order join together."""
    largest, before = 0, number
    for i in range(rows.shape[1]):
        line, quantity = begin + i, rows[2, i]
        if i == 0 or rows[0, i] != ids[number - 1]:
            ids[number], starts[number] = rows[0, i], line
            number += 1
        order = number - 1
        lines[ORDER, line], lines[SKU, line], lines[QUANTITY, line] = order, rows[1, i], quantity
        orders[OPEN, order] += 1
        orders[ITEMS, order] += quantity
        largest = max(largest, orders[ITEMS, order])
    starts[number] = begin + rows.shape[1]
    for order in range(before, number):
        size = min(orders[ITEMS, order], SIZES) - 1
        turn, at = divmod(blocks.counts[NUMBER, size], BLOCK)
        if at == 0:  # another block, the next one of all
            block = ((blocks.counts[NUMBER] + BLOCK - 1) // BLOCK).sum()
            blocks.of_size[size, turn], blocks.oldest[block], blocks.least[block] = block, order, np.inf
        block = blocks.of_size[size, turn]
        blocks.least[block] = min(blocks.least[block], ranks[order])
        blocks.places[block * BLOCK + at] = order
        blocks.counts[NUMBER, size] += 1
        orders[SIZE, order], orders[SLOT, order] = size, block * BLOCK + at
        scores[:, :, orders[SLOT, order]] = 0
    return number, largest


@njit(cache=True)
def _add(before, number, used, starts, lines, shelves, most, pool, orders, scores, ranks, best, known):  # type: ignore[no-untyped-def]
    """Shelve and score the lines of orders that joined; return the pool, and how much of it is used."""
    for line in range(starts[before], starts[number]):
        order, sku, quantity = lines[ORDER, line], lines[SKU, line], lines[QUANTITY, line]
        size = orders[SIZE, order]
        length, start = shelves[sku, size, LENGTH], shelves[sku, size, START]
        if length == shelves[sku, size, ROOM]:
            room = 2 * (length + 1)
            while used + room > len(pool):
                pool = np.concatenate((pool, np.zeros_like(pool)))
            for at in range(length):
                pool[used + at] = pool[start + at]
                lines[AT, pool[used + at, LINE]] = used + at
            shelves[sku, size, START], shelves[sku, size, ROOM] = used, room
            used += room
        at = shelves[sku, size, START] + length
        slot = orders[SLOT, order]
        pool[at, PLACE], pool[at, WANTED], pool[at, LINE], pool[at, SCORE] = order, quantity, line, slot
        lines[AT, line] = at
        shelves[sku, size, LENGTH] += 1
        most[sku] = max(most[sku], quantity)
        for table in range(len(known)):
            for station in range(known.shape[1]):
                scores[table, station, slot] += min(quantity, known[table, station, sku, size])
    for order in range(before, number):
        for station in range(known.shape[1]):
            raise_best(station, orders[SLOT, order], order, orders, scores, ranks, best)
    return pool, used


@njit(cache=True)
def _leave(left, starts, lines, blocks, shelves, pool, orders, scores, ranks, best, known):  # type: ignore[no-untyped-def]
    """Take out lines that left the backlog; return how many more orders are in it in part, and how many late ones left.

    Orders that left score less than any other.
    """
    parts = late = 0
    for line in left:
        order, sku, quantity = lines[ORDER, line], lines[SKU, line], lines[QUANTITY, line]
        size, slot = orders[SIZE, order], orders[SLOT, order]
        at, last = lines[AT, line], shelves[sku, size, START] + shelves[sku, size, LENGTH] - 1
        pool[at] = pool[last]
        lines[AT, pool[at, LINE]] = at
        shelves[sku, size, LENGTH] -= 1
        parts -= 0 < orders[OPEN, order] < starts[order + 1] - starts[order]
        orders[OPEN, order] -= 1
        orders[ITEMS, order] -= quantity
        parts += 0 < orders[OPEN, order] < starts[order + 1] - starts[order]
        if not orders[OPEN, order]:
            late += scores[0, LATE_TO_ALL, slot] == LATE
            blocks.places[slot] = scores[:, :, slot] = -1
            continue
        for station in range(known.shape[1]):
            for table in range(len(known)):
                scores[table, station, slot] -= min(quantity, known[table, station, sku, size])
            raise_best(station, slot, order, orders, scores, ranks, best)
    return parts, late
