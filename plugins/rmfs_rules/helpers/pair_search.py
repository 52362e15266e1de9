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
def value_of(station, slot, order, orders, scores):
    """What a pair counts: its score, and by less than one the share of the order's lines that the second table has."""
    score = np.float64(scores[0, station, slot] + scores[0, LATE_TO_ALL, slot])
    return score if len(scores) == 1 else score + 0.5 * (scores[1, station, slot] / orders[OPEN, order])


@inlined
def raise_best(station, slot, order, orders, scores, ranks, best):
    """Let the best value of an order's block, and the first rank that has it, be no worse than the order's."""
    block, value = slot // BLOCK, value_of(station, slot, order, orders, scores)
    if value > best[0, station, block]:
        best[0, station, block], best[1, station, block] = value, ranks[order]
    elif value == best[0, station, block]:
        best[1, station, block] = min(best[1, station, block], ranks[order])


@njit(cache=True)
def update(
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
def _join(rows, begin, number, ids, starts, lines, blocks, orders, scores, ranks):
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
def _add(before, number, used, starts, lines, shelves, most, pool, orders, scores, ranks, best, known):
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
def _leave(left, starts, lines, blocks, shelves, pool, orders, scores, ranks, best, known):
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


@njit(cache=True)
def note(table, available, now, changes, recent):
    """Note what is available now, and what of that has changed; scores follow when they matter."""
    for station in range(len(available)):
        for sku in range(available.shape[1]):
            if available[station, sku] != now[table, station, sku]:
                now[table, station, sku] = available[station, sku]
                recent[station, changes[station] % RECENT] = table * available.shape[1] + sku
                changes[station] += 1


@njit(cache=True)
def refresh(station, size, blocks, shelves, most, pool, orders, scores, best, known, now, changes, seen, recent):
    """Do what `refresh_size` does, for who is not compiled."""
    refresh_size(station, size, blocks, shelves, most, pool, orders, scores, best, known, now, changes, seen, recent)


@inlined
def refresh_size(station, size, blocks, shelves, most, pool, orders, scores, best, known, now, changes, seen, recent):
    """Bring the scores of the orders of a size at a station up to what is available there now."""
    begin, end, skus = seen[station, size], changes[station], known.shape[2]
    if begin == end:
        return
    seen[station, size] = end
    every = end - begin > RECENT  # more has changed than is remembered: look at all SKUs
    if every:
        begin, end = 0, len(known) * skus
    for at in range(begin, end):
        which = at if every else recent[station, at % RECENT]
        change(which // skus, station, size, which % skus, shelves, most, pool, scores, known, now)
    promise(station, size, blocks, orders, scores, best)


@inlined
def change(table, station, size, sku, shelves, most, pool, scores, known, now):
    """Bring the scores of the orders of a size with a SKU up to what is available of it at a station now."""
    had, items = min(known[table, station, sku, size], most[sku]), min(now[table, station, sku], most[sku])
    known[table, station, sku, size] = now[table, station, sku]
    if items != had:
        start = shelves[sku, size, START]
        for at in range(start, start + shelves[sku, size, LENGTH]):
            quantity = pool[at, WANTED]
            scores[table, station, pool[at, SCORE]] += min(quantity, items) - min(quantity, had)


@inlined
def promise(station, size, blocks, orders, scores, best):
    """Let each block of a size promise the best value of its orders, and a rank that is no worse than theirs."""
    for turn in range(blocks.counts[FIRST, size], (blocks.counts[NUMBER, size] + BLOCK - 1) // BLOCK):
        block = blocks.of_size[size, turn]
        begin, end = block * BLOCK, (block + 1) * BLOCK
        value = np.float64(-1)
        if len(scores) == 1:  # a loop that the compiler makes take many at once
            highest = scores[0, station, begin] + scores[0, LATE_TO_ALL, begin]
            for slot in range(begin, end):
                highest = max(highest, scores[0, station, slot] + scores[0, LATE_TO_ALL, slot])
            value = np.float64(highest)
        else:
            for slot in range(begin, end):
                if blocks.places[slot] >= 0:
                    value = max(value, value_of(station, slot, blocks.places[slot], orders, scores))
        best[0, station, block], best[1, station, block] = value, blocks.least[block]


@njit(cache=True)
def lift(late, orders, scores, changes, recent):
    """Let orders be late, which goes before whatever is available; return how many of them are in the backlog.

    What their blocks promise follows when it matters: of one SKU it is noted that it may have changed.
    """
    number = 0
    for order in late:
        if orders[OPEN, order]:
            scores[0, LATE_TO_ALL, orders[SLOT, order]] = LATE
            number += 1
    for station in range(len(changes)):
        recent[station, changes[station] % RECENT] = 0
        changes[station] += 1
    return number


@inlined
def lot(key, order):
    """Number from 0 to 1 that an order draws, by its id: SplitMix64, begun with a key."""
    mixed = np.uint64(key) + np.uint64(order + 1) * np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.float64((mixed ^ (mixed >> np.uint64(31))) >> np.uint64(11)) * EXACT


@inlined
def fits(items, free, capacity, counts, largest):
    """Whether an order of so many items fits a station; one larger than any fits an empty one."""
    return free > 0 if counts else (items <= free or (items > largest and 0 < free == capacity))


@inlined
def is_better(value, rank, order, load, station, than):
    """Whether a pair goes before the best so far: by value, rank, age, and the load and id of its station."""
    if value != than[0]:
        return value > than[0]
    if rank != than[1]:
        return rank < than[1]
    if order != than[2]:
        return order < than[2]
    return load < than[3] or (load == than[3] and station < than[4])


@inlined
def likely(bound, rank, blocks):
    """Return which of some blocks promises most."""
    best = 0
    for turn in range(1, len(blocks)):
        block, than = blocks[turn], blocks[best]
        if bound[block] > bound[than] or (bound[block] == bound[than] and rank[block] < rank[than]):
            best = turn
    return best


@inlined
def may_lead(value, rank, oldest, key, leader):
    """Whether a block may have a pair that goes before the best so far, by what it promises and its oldest order."""
    if value != leader[0] or key:
        return value >= leader[0]
    return rank < leader[1] or (rank == leader[1] and leader[2] >= oldest)


@inlined
def look_through(block, station, at, extra, largest, key, ids, taken, blocks, orders, scores, ranks, best, leader):
    """Return the best pair, this or one of the orders of a block; put right what the block promises."""
    best[0, station, block], best[1, station, block] = -1.0, np.inf
    for slot in range(block * BLOCK, (block + 1) * BLOCK):
        order = blocks.places[slot]
        if order < 0:
            continue
        raise_best(station, slot, order, orders, scores, ranks, best)
        value = value_of(station, slot, order, orders, scores) + extra[station]
        if value < leader[0] or taken[order]:
            continue
        if fits(orders[ITEMS, order], at[0, station], at[2, station], at[3, station], largest):
            rank = lot(key, ids[order]) if key else ranks[order]
            if is_better(value, rank, order, at[4, station], station, leader):
                leader = (value, rank, np.int64(order), at[4, station], np.int64(station))
    return leader


@njit(cache=True)
def best_pair(
    at, extra, limits, lanes, key, ids, taken, blocks,
    shelves, most, pool, orders, scores, ranks, best, known, now, changes, seen, recent,
):  # fmt: skip
    """Place of the order and id of the station that go first of those that fit; (-1, -1) when none fits.

    The highest value, then the lowest rank, the oldest order, the station with the lowest load, the lowest id. ``best``
    is no worse than the best of each block, and is put right where a block is looked through. ``at`` has room, free
    places, capacity, whether orders are counted, and load, by station; ``limits`` the items of the largest order that
    fits, and what an order can score beyond its items. ``lanes`` has pairs of station and order that all free places
    are for, not room alone.
    """
    room, free, capacity, counts, load = at
    leader = (-np.inf, np.inf, np.int64(-1), np.int64(0), np.int64(-1))
    for size in range(SIZES - 1, -1, -1):
        begin, end = blocks.counts[FIRST, size], (blocks.counts[NUMBER, size] + BLOCK - 1) // BLOCK
        there = blocks.of_size[size, begin:end]
        if begin == end:
            continue
        for station in range(len(room)):
            if room[station] <= 0 or (not counts[station] and size >= room[station] != capacity[station]):
                continue
            if size < SIZES - 1 and size + 1 + limits[1] + extra[station] < leader[0]:
                continue  # what is available now is looked at when it matters
            refresh_size(
                station, size, blocks, shelves, most, pool, orders, scores, best, known, now, changes, seen, recent
            )
            bound, rank = best[0, station], best[1, station]
            first = likely(bound, rank, there)
            for turn in range(-1, len(there)):
                block = there[first if turn < 0 else turn]
                promised = bound[block] + extra[station]
                if bound[block] >= 0 and may_lead(promised, rank[block], blocks.oldest[block], key, leader):
                    leader = look_through(
                        block,
                        station,
                        at,
                        extra,
                        limits[0],
                        key,
                        ids,
                        taken,
                        blocks,
                        orders,
                        scores,
                        ranks,
                        best,
                        leader,
                    )
    for pair in range(lanes.shape[1]):
        station, order = lanes[0, pair], lanes[1, pair]
        items, size = orders[ITEMS, order], orders[SIZE, order]
        if taken[order] or not orders[OPEN, order]:
            continue
        if fits(items, free[station], capacity[station], counts[station], limits[0]):
            refresh_size(
                station, size, blocks, shelves, most, pool, orders, scores, best, known, now, changes, seen, recent
            )
            value = value_of(station, orders[SLOT, order], order, orders, scores) + extra[station]
            place = lot(key, ids[order]) if key else ranks[order]
            if is_better(value, place, order, load[station], station, leader):
                leader = (value, place, np.int64(order), load[station], np.int64(station))
    return leader[2], leader[4]
