"""Compiled work on what orders lack at stations; `lacking` says what the arrays are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import inlined, njit

BLOCK = 128
"""Orders with as many items that lie side by side, and whose best is kept."""
OUT = 1 << 20
"""What is added to the lines that an order lacks at all stations while it is chosen, or stock is lacking for it."""
GONE, NEVER = 1 << 28, 1 << 60
"""Lines that an order lacks which has left, and what a block promises that has no order in question."""
SCALE = 1_000_000
"""What one line that an order lacks counts at a station that counts orders."""
ORDER, SKU, QUANTITY, AT = range(4)
"""Rows of the lines: the order's place, SKU, items, and where the line is among those of its SKU."""
START, LENGTH, ROOM, MOST = range(4)
"""Of each SKU: where its lines begin in the pool, how many are there, may be, and the items that a line ever had."""
SLOT, WANTED, LINE = range(3)
"""Columns of the pool: where the line's order is among the blocks, items, and the line."""
OPEN, ITEMS, WHERE = range(3)
"""Rows of the orders: open lines (0: not in the backlog), items, and where it is among the blocks."""
NUMBER, JOINED, BLOCKS, USED, FIRST, PARTS = range(6)
"""Counts: orders and lines that joined, blocks, what is used of the pool, the first order that may be in the backlog,
and orders of it that were assigned in part."""


class Arrays(NamedTuple):
    """What is kept of the orders.

    Parameters
    ----------
    counts
        See `NUMBER`.
    ids, starts
        By place: the order's id, and where its lines begin; all of them end where those of the next one begin.
    orders, lines, shelves, pool
        See `OPEN`, `ORDER`, `START` and `SLOT`.
    wanted
        Open items by SKU.
    filling, of_size
        By number of items: the block that orders with so many join, -1 if there is none, and how many are open.
    at
        Items that stations have for the orders, and in the last row all pods together; shape (stations + 1, SKUs).
    lacks
        Lines that orders lack, by row of ``at`` and where they are; shape (stations + 1, blocks * `BLOCK`).
    places, sizes
        The order's place by where it is, -1 for none, and the number of items of a block's orders.
    value, least, who
        By station and block, of the order that goes first: what it lacks for each place, lines, and its place; a value
        of -1 says that this is not known. Shape (stations, blocks).
    counted
        Whether stations count orders.
    """

    counts: NDArray[np.int64]
    ids: NDArray[np.int64]
    starts: NDArray[np.int64]
    orders: NDArray[np.int64]
    lines: NDArray[np.int64]
    shelves: NDArray[np.int64]
    pool: NDArray[np.int32]
    wanted: NDArray[np.int64]
    filling: NDArray[np.int64]
    of_size: NDArray[np.int64]
    at: NDArray[np.int64]
    lacks: NDArray[np.int32]
    places: NDArray[np.int64]
    sizes: NDArray[np.int64]
    value: NDArray[np.int64]
    least: NDArray[np.int64]
    who: NDArray[np.int64]
    counted: NDArray[np.bool_]


@inlined
def is_lacking(items, quantity):
    """Whether a pod would have to be sent for a line, which none is sent for anyway (below 0)."""
    return 0 <= items < quantity


@inlined
def value_of(lacks, station, items, counted):
    """What orders of a block lack for each place that they take."""
    if lacks >= OUT:
        return NEVER
    return lacks * SCALE // (1 if counted[station] else items)


@inlined
def bump(station, slot, by, kept):
    """Let an order lack more lines at a station, or fewer."""
    kept.lacks[station, slot] += by
    block, place, lacks = slot // BLOCK, kept.places[slot], np.int64(kept.lacks[station, slot])
    if by > 0:
        if kept.who[station, block] == place:
            kept.value[station, block] = -1
    elif kept.value[station, block] >= 0:
        least = kept.least[station, block]
        if lacks < least:
            kept.value[station, block] = value_of(lacks, station, kept.sizes[block], kept.counted)
        if lacks < least or (lacks == least and place < kept.who[station, block]):
            kept.least[station, block], kept.who[station, block] = lacks, place


@inlined
def exclude(slot, by, kept):
    """Let an order be out of the question at all stations (`OUT`), or no longer (-`OUT`)."""
    for station in range(len(kept.counted)):
        bump(station, slot, by, kept)


@inlined
def change(row, sku, items, kept):
    """Let a station, or all pods together, have another number of items of a SKU."""
    had, most = kept.at[row, sku], kept.shelves[sku, MOST]
    kept.at[row, sku] = items
    if min(had, most) == min(items, most) or (had < 0 and items < 0):
        return
    for at in range(kept.shelves[sku, START], kept.shelves[sku, START] + kept.shelves[sku, LENGTH]):
        quantity, slot = kept.pool[at, WANTED], kept.pool[at, SLOT]
        more = np.int64(is_lacking(items, quantity)) - np.int64(is_lacking(had, quantity))
        if more == 0:
            continue
        if row < len(kept.counted):
            bump(row, slot, more, kept)
        else:
            kept.lacks[row, slot] += more
            if kept.lacks[row, slot] == max(more, 0):  # the first line for which stock is lacking, or none any more
                exclude(slot, more * OUT, kept)


@njit(cache=True)
def let(at, taken, kept):
    """Let stations and all pods have so many items, and orders be chosen no longer."""
    for place in taken:
        exclude(kept.orders[WHERE, place], -OUT, kept)
    for row in range(len(at)):
        for sku in range(at.shape[1]):
            if at[row, sku] != kept.at[row, sku]:
                change(row, sku, at[row, sku], kept)


@njit(cache=True)
def join(rows, kept):
    """Take in lines (order id, SKU, items) that joined, those of an order together; there is room in the arrays."""
    counts, begin = kept.counts, kept.counts[JOINED]
    before = counts[NUMBER]
    for i in range(rows.shape[1]):
        line, quantity = begin + i, rows[2, i]
        if i == 0 or rows[0, i] != rows[0, i - 1]:
            kept.ids[counts[NUMBER]], kept.starts[counts[NUMBER]] = rows[0, i], line
            counts[NUMBER] += 1
        place = counts[NUMBER] - 1
        kept.lines[ORDER, line], kept.lines[SKU, line], kept.lines[QUANTITY, line] = place, rows[1, i], quantity
        kept.orders[OPEN, place] += 1
        kept.orders[ITEMS, place] += quantity
        kept.wanted[rows[1, i]] += quantity
    counts[JOINED] += rows.shape[1]
    kept.starts[counts[NUMBER]] = counts[JOINED]
    for place in range(before, counts[NUMBER]):
        slot = slot_for(place, kept)
        for line in range(kept.starts[place], kept.starts[place + 1]):
            shelve(line, slot, kept)
        for row in range(len(kept.at)):
            lacks = 0
            for line in range(kept.starts[place], kept.starts[place + 1]):
                lacks += is_lacking(kept.at[row, kept.lines[SKU, line]], kept.lines[QUANTITY, line])
            kept.lacks[row, slot] = lacks
        exclude(slot, OUT if kept.lacks[len(kept.counted), slot] else 0, kept)


@inlined
def slot_for(place, kept):
    """Return where an order that joined is among the blocks: behind the last one with as many items."""
    items = kept.orders[ITEMS, place]
    block = kept.filling[items]
    slot = block * BLOCK
    if block >= 0:
        while slot < (block + 1) * BLOCK and kept.places[slot] >= 0:
            slot += 1
    if block < 0 or slot == (block + 1) * BLOCK:
        block = kept.counts[BLOCKS]
        kept.counts[BLOCKS] += 1
        kept.filling[items], kept.sizes[block], slot = block, items, block * BLOCK
    kept.places[slot], kept.orders[WHERE, place] = place, slot
    kept.of_size[items] += 1
    return slot


@inlined
def shelve(line, slot, kept):
    """Put a line to those of its SKU."""
    sku, quantity = kept.lines[SKU, line], kept.lines[QUANTITY, line]
    length, start = kept.shelves[sku, LENGTH], kept.shelves[sku, START]
    if length == kept.shelves[sku, ROOM]:
        used = kept.counts[USED]
        for at in range(length):
            for column in range(3):
                kept.pool[used + at, column] = kept.pool[start + at, column]
            kept.lines[AT, kept.pool[used + at, LINE]] = used + at
        start, kept.shelves[sku, START], kept.shelves[sku, ROOM] = used, used, 2 * (length + 1)
        kept.counts[USED] += 2 * (length + 1)
    at = start + length
    kept.pool[at, SLOT], kept.pool[at, WANTED], kept.pool[at, LINE] = slot, quantity, line
    kept.lines[AT, line] = at
    kept.shelves[sku, LENGTH] += 1
    kept.shelves[sku, MOST] = max(kept.shelves[sku, MOST], quantity)


@njit(cache=True)
def leave(left, kept):
    """Take out lines that left the backlog."""
    for line in left:
        place, sku = kept.lines[ORDER, line], kept.lines[SKU, line]
        at, last = kept.lines[AT, line], kept.shelves[sku, START] + kept.shelves[sku, LENGTH] - 1
        for column in range(3):
            kept.pool[at, column] = kept.pool[last, column]
        kept.lines[AT, kept.pool[at, LINE]] = at
        kept.shelves[sku, LENGTH] -= 1
        kept.wanted[sku] -= kept.lines[QUANTITY, line]
        had, lines = kept.orders[OPEN, place], kept.starts[place + 1] - kept.starts[place]
        kept.orders[OPEN, place] -= 1
        kept.counts[PARTS] += np.int64(had > 1) * np.int64(had == lines) - np.int64(had == 1) * np.int64(lines > 1)
        if had == 1:
            slot = kept.orders[WHERE, place]
            kept.of_size[kept.orders[ITEMS, place]] -= 1
            for station in range(len(kept.counted)):
                bump(station, slot, GONE, kept)
    while kept.counts[FIRST] < kept.counts[NUMBER] and not kept.orders[OPEN, kept.counts[FIRST]]:
        kept.counts[FIRST] += 1


@njit(cache=True)
def close_up(kept):
    """Let the orders of the backlog lie side by side again, those of a size in blocks without gaps."""
    lacks = kept.lacks.copy()
    kept.counts[BLOCKS] = 0
    kept.filling[:], kept.of_size[:], kept.places[:] = -1, 0, -1
    kept.value[:], kept.least[:], kept.who[:] = NEVER, GONE, -1
    for place in range(kept.counts[FIRST], kept.counts[NUMBER]):
        if not kept.orders[OPEN, place]:
            continue
        before = kept.orders[WHERE, place]
        slot = slot_for(place, kept)
        kept.lacks[:, slot] = lacks[:, before]
        for line in range(kept.starts[place], kept.starts[place + 1]):
            at, sku = kept.lines[AT, line], kept.lines[SKU, line]
            if at < kept.shelves[sku, START] + kept.shelves[sku, LENGTH] and kept.pool[at, LINE] == line:
                kept.pool[at, SLOT] = slot  # others have left
    kept.value[:, : kept.counts[BLOCKS]] = -1


@inlined
def look_through(station, block, kept):
    """Find which order of a block goes first at a station."""
    least, first = np.int64(GONE), np.int64(-1)
    for slot in range(block * BLOCK, (block + 1) * BLOCK):
        if kept.lacks[station, slot] < least and kept.places[slot] >= 0:
            least, first = np.int64(kept.lacks[station, slot]), kept.places[slot]
    kept.least[station, block], kept.who[station, block] = least, first
    kept.value[station, block] = value_of(least, station, kept.sizes[block], kept.counted)
