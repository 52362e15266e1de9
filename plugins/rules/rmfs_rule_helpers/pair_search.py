"""Compiled work on the scores of pairs of order and station; `pair_scores` says what the arrays are."""

from __future__ import annotations

import numpy as np
from numba import njit

BLOCK = 128
"""Orders whose best scores are kept together."""
SIZES = 8
"""Sizes of orders that are kept apart, by the items they have when they join; the last one has all larger ones, too."""
ORDER, SKU, QUANTITY, AT = range(4)
"""Rows of the lines: the order's place, SKU, items, and where the line is among those of its SKU and size."""
START, LENGTH, ROOM = range(3)
"""Of the shelves, one for each SKU and size: where their lines begin in the pool, how many are there, may be."""
OPEN, ITEMS, SIZE = range(3)
"""Rows of the orders: open lines (0: not in the backlog), items, and the size among `SIZES`."""
EXACT = 2.0**-53
"""What 53 bits of a lot are multiplied by, to lie between 0 and 1."""


@njit(cache=True, inline="always")
def value_of(station, order, orders, scores):  # type: ignore[no-untyped-def]
    """What a pair counts: its score, and by less than one the share of the order's lines that the second table has."""
    if len(scores) == 1:
        return np.float64(scores[0, station, order])
    return scores[0, station, order] + 0.5 * (scores[1, station, order] / orders[OPEN, order])


@njit(cache=True, inline="always")
def raise_best(station, size, order, orders, scores, ranks, best):  # type: ignore[no-untyped-def]
    """Let the best value of an order's block, and the first rank that has it, be no worse than the order's."""
    block, value = order // BLOCK, value_of(station, order, orders, scores)
    if value > best[0, station, size, block]:
        best[0, station, size, block], best[1, station, size, block] = value, ranks[order]
    elif value == best[0, station, size, block]:
        best[1, station, size, block] = min(best[1, station, size, block], ranks[order])


@njit(cache=True)
def add(begin, end, used, lines, shelves, most, pool, orders, scores, ranks, best, known):  # type: ignore[no-untyped-def]
    """Take in lines that joined the backlog, of orders whose items are counted; return how much of the pool is used."""
    for line in range(begin, end):
        order, sku, quantity = lines[ORDER, line], lines[SKU, line], lines[QUANTITY, line]
        size = orders[SIZE, order]
        length = shelves[sku, size, LENGTH]
        if length == shelves[sku, size, ROOM]:
            before = shelves[sku, size, START]
            for at in range(length):
                pool[used + at] = pool[before + at]
                lines[AT, pool[used + at, 2]] = used + at
            shelves[sku, size, START], shelves[sku, size, ROOM] = used, 2 * (length + 1)
            used += 2 * (length + 1)
        at = shelves[sku, size, START] + length
        pool[at, 0], pool[at, 1], pool[at, 2] = order, quantity, line
        lines[AT, line] = at
        shelves[sku, size, LENGTH] += 1
        most[sku] = max(most[sku], quantity)
        for table in range(len(known)):
            for station in range(known.shape[1]):
                scores[table, station, order] += min(quantity, known[table, station, size, sku])
    for line in range(begin, end):
        for station in range(known.shape[1]):
            raise_best(station, orders[SIZE, lines[ORDER, line]], lines[ORDER, line], orders, scores, ranks, best)
    return used


@njit(cache=True)
def close(left, lines, shelves, pool, orders, scores, ranks, best, known):  # type: ignore[no-untyped-def]
    """Take out lines that left the backlog."""
    for line in left:
        order, sku, quantity = lines[ORDER, line], lines[SKU, line], lines[QUANTITY, line]
        size = orders[SIZE, order]
        at, last = lines[AT, line], shelves[sku, size, START] + shelves[sku, size, LENGTH] - 1
        pool[at] = pool[last]
        lines[AT, pool[at, 2]] = at
        shelves[sku, size, LENGTH] -= 1
        orders[OPEN, order] -= 1
        orders[ITEMS, order] -= quantity
        for station in range(known.shape[1]):
            for table in range(len(known)):
                scores[table, station, order] -= min(quantity, known[table, station, size, sku])
            if orders[OPEN, order]:
                raise_best(station, size, order, orders, scores, ranks, best)


@njit(cache=True)
def refresh(  # type: ignore[no-untyped-def]
    station, size, shelves, most, pool, orders, scores, ranks, best, known, now, changes, seen
):
    """Bring the scores of the orders of a size at a station up to what is available there now."""
    if seen[station, size] == changes[station]:
        return
    seen[station, size] = changes[station]
    changed = np.empty(known.shape[3], np.int64)
    for table in range(len(known)):
        fewer, more = 0, known.shape[3]  # SKUs of which fewer are available from the left, the others from the right
        for sku in range(known.shape[3]):
            if now[table, station, sku] < known[table, station, size, sku]:
                changed[fewer] = sku
                fewer += 1
            elif now[table, station, sku] > known[table, station, size, sku]:
                more -= 1
                changed[more] = sku
        for at in range(fewer):
            change(table, station, size, changed[at], shelves, most, pool, orders, scores, ranks, best, known, now)
        for at in range(more, known.shape[3]):  # last, so that nothing is raised that falls again
            change(table, station, size, changed[at], shelves, most, pool, orders, scores, ranks, best, known, now)


@njit(cache=True)
def change(  # type: ignore[no-untyped-def]
    table, station, size, sku, shelves, most, pool, orders, scores, ranks, best, known, now
):
    """Bring the scores of the orders of a size with a SKU up to what is available of it at a station now."""
    had, items = min(known[table, station, size, sku], most[sku]), min(now[table, station, sku], most[sku])
    known[table, station, size, sku] = now[table, station, sku]
    if items == had:
        return
    for at in range(shelves[sku, size, START], shelves[sku, size, START] + shelves[sku, size, LENGTH]):
        order, quantity = pool[at, 0], pool[at, 1]
        more = min(quantity, items) - min(quantity, had)
        scores[table, station, order] += more
        if more > 0:
            raise_best(station, size, order, orders, scores, ranks, best)


@njit(cache=True)
def lift(places, by, orders, scores, ranks, best):  # type: ignore[no-untyped-def]
    """Let orders score more everywhere, whatever is available."""
    for order in places:
        for station in range(scores.shape[1]):
            scores[0, station, order] += by
            if orders[OPEN, order]:
                raise_best(station, orders[SIZE, order], order, orders, scores, ranks, best)


@njit(cache=True)
def completed(items, shelves, pool, orders, enough):  # type: ignore[no-untyped-def]
    """Places of the orders that a pod completes which has so many free items of each SKU; ``enough`` is all zeros."""
    held = np.flatnonzero(items)
    places = [np.int64(0) for _ in range(0)]
    for size in range(SIZES):
        for sku in held:
            start = shelves[sku, size, START]
            for at in range(start, start + shelves[sku, size, LENGTH]):
                if pool[at, 1] <= items[sku]:
                    order = pool[at, 0]
                    enough[order] += 1
                    if enough[order] == orders[OPEN, order]:
                        places.append(np.int64(order))
        for sku in held:
            start = shelves[sku, size, START]
            for at in range(start, start + shelves[sku, size, LENGTH]):
                enough[pool[at, 0]] = 0
    return np.array(places, np.int64)


@njit(cache=True)
def lot(key, order):  # type: ignore[no-untyped-def]
    """Number from 0 to 1 that an order draws, by its id: SplitMix64, begun with a key."""
    mixed = np.uint64(key) + np.uint64(order + 1) * np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.float64((mixed ^ (mixed >> np.uint64(31))) >> np.uint64(11)) * EXACT


@njit(cache=True, inline="always")
def fits(items, free, capacity, counts, largest):  # type: ignore[no-untyped-def]
    """Whether an order of so many items fits a station; one larger than any fits an empty one."""
    return free > 0 if counts else (items <= free or (items > largest and 0 < free == capacity))


@njit(cache=True, inline="always")
def is_better(value, rank, order, load, station, than):  # type: ignore[no-untyped-def]
    """Whether a pair goes before the best so far: by value, rank, age, and the load and id of its station."""
    if value != than[0]:
        return value > than[0]
    if rank != than[1]:
        return rank < than[1]
    if order != than[2]:
        return order < than[2]
    return load < than[3] or (load == than[3] and station < than[4])


@njit(cache=True)
def likely(bound, rank, begin, end):  # type: ignore[no-untyped-def]
    """Return the block that promises most."""
    best = begin
    for block in range(begin + 1, end):
        if bound[block] > bound[best] or (bound[block] == bound[best] and rank[block] < rank[best]):
            best = block
    return best


@njit(cache=True, inline="always")
def may_lead(value, rank, block, key, leader):  # type: ignore[no-untyped-def]
    """Whether a block may have a pair that goes before the best so far, by what it promises."""
    if value != leader[0] or key:
        return value >= leader[0]
    return rank < leader[1] or (rank == leader[1] and leader[2] >= block * BLOCK)


@njit(cache=True)
def look_through(  # type: ignore[no-untyped-def]
    block, station, size, at, extra, limits, key, ids, taken, orders, scores, ranks, best, leader
):
    """Return the best pair, this or one of the orders of a size in a block; put right what the block promises."""
    best[0, station, size, block], best[1, station, size, block] = -1.0, np.inf
    for order in range(block * BLOCK, min((block + 1) * BLOCK, limits[2])):
        if not orders[OPEN, order] or orders[SIZE, order] != size:
            continue
        raise_best(station, size, order, orders, scores, ranks, best)
        value = value_of(station, order, orders, scores) + extra[station]
        if value < leader[0] or taken[order]:
            continue
        if fits(orders[ITEMS, order], at[0, station], at[2, station], at[3, station], limits[0]):
            rank = lot(key, ids[order]) if key else ranks[order]
            if is_better(value, rank, order, at[4, station], station, leader):
                leader = (value, rank, np.int64(order), at[4, station], np.int64(station))
    return leader


@njit(cache=True)
def best_pair(  # type: ignore[no-untyped-def]
    at,
    extra,
    limits,
    lanes,
    key,
    ids,
    taken,
    shelves,
    most,
    pool,
    orders,
    scores,
    ranks,
    best,
    known,
    now,
    changes,
    seen,
):
    """Place of the order and id of the station that go first of those that fit; (-1, -1) when none fits.

    The highest value, then the lowest rank, the oldest order, the station with the lowest load, the lowest id. ``best``
    is no worse than the best of each block, and is put right where a block is looked through. ``at`` has room, free
    places, capacity, whether orders are counted, and load, by station; ``limits`` the items of the largest order that
    fits, the first and the number of places, and what an order can score beyond its items. ``lanes`` has pairs of
    station and order that all free places are for, not room alone.
    """
    room, free, capacity, counts, load = at
    begin, end = limits[1] // BLOCK, (limits[2] + BLOCK - 1) // BLOCK
    leader = (-np.inf, np.inf, np.int64(-1), np.int64(0), np.int64(-1))
    for size in range(SIZES - 1, -1, -1):
        for station in range(len(room)):
            if room[station] <= 0 or (not counts[station] and size >= room[station] != capacity[station]):
                continue
            if size < SIZES - 1 and size + 1 + limits[3] + extra[station] < leader[0]:
                continue  # what is available now is looked at when it matters
            refresh(station, size, shelves, most, pool, orders, scores, ranks, best, known, now, changes, seen)
            bound, rank = best[0, station, size], best[1, station, size]
            first = likely(bound, rank, begin, end)
            for turn in range(begin - 1, end):
                block = first if turn < begin else turn
                if bound[block] >= 0 and may_lead(bound[block] + extra[station], rank[block], block, key, leader):
                    leader = look_through(
                        block, station, size, at, extra, limits, key, ids, taken, orders, scores, ranks, best, leader
                    )
    for pair in range(lanes.shape[1]):
        station, order = lanes[0, pair], lanes[1, pair]
        items, size = orders[ITEMS, order], orders[SIZE, order]
        if taken[order] or not orders[OPEN, order]:
            continue
        if fits(items, free[station], capacity[station], counts[station], limits[0]):
            refresh(station, size, shelves, most, pool, orders, scores, ranks, best, known, now, changes, seen)
            value = value_of(station, order, orders, scores) + extra[station]
            place = lot(key, ids[order]) if key else ranks[order]
            if is_better(value, place, order, load[station], station, leader):
                leader = (value, place, np.int64(order), load[station], np.int64(station))
    return leader[2], leader[4]
