"""Compiled work on the scores of pairs of order and station; `pair_scores` says what the arrays are."""

from __future__ import annotations

import numpy as np
from numba import njit

BLOCK = 128
"""Orders whose best scores are kept together."""
SIZES = 8
"""Sizes of orders that are kept apart, by the items they have when they join; the last one has all larger ones, too."""
RECENT = 1024
"""Changes of what is available that are remembered by station, as table * SKUs + SKU."""
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
def update(  # type: ignore[no-untyped-def]
    rows, left, begin, number, first, used, ids, starts, lines, shelves, most, pool, orders, scores, ranks, best, known
):  # fmt: skip
    """Take in lines that joined the backlog from ``begin`` on, and lines that left it.

    ``rows`` has order id, SKU and items of those that joined; there is room for them in the arrays, but for the pool,
    which grows. Returns how many orders there are then, the first that may be in the backlog, the largest that joined,
    how many more are in it in part, the pool, and how much of it is used.
    """
    before = number
    number, largest = _join(rows, begin, number, ids, starts, lines, orders)
    pool, used = _add(before, number, used, starts, lines, shelves, most, pool, orders, scores, ranks, best, known)
    parts = _leave(left, starts, lines, shelves, pool, orders, scores, ranks, best, known)
    while first < number and not orders[OPEN, first]:
        first += 1
    return number, first, largest, parts, pool, used


@njit(cache=True)
def _join(rows, begin, number, ids, starts, lines, orders):  # type: ignore[no-untyped-def]
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
    for order in range(before, number):
        orders[SIZE, order] = min(orders[ITEMS, order], SIZES) - 1
    starts[number] = begin + rows.shape[1]
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
                lines[AT, pool[used + at, 2]] = used + at
            shelves[sku, size, START], shelves[sku, size, ROOM] = used, room
            used += room
        at = shelves[sku, size, START] + length
        pool[at, 0], pool[at, 1], pool[at, 2] = order, quantity, line
        lines[AT, line] = at
        shelves[sku, size, LENGTH] += 1
        most[sku] = max(most[sku], quantity)
        for table in range(len(known)):
            for station in range(known.shape[1]):
                scores[table, station, order] += min(quantity, known[table, station, sku, size])
    for order in range(before, number):
        for station in range(known.shape[1]):
            raise_best(station, orders[SIZE, order], order, orders, scores, ranks, best)
    return pool, used


@njit(cache=True)
def _leave(left, starts, lines, shelves, pool, orders, scores, ranks, best, known):  # type: ignore[no-untyped-def]
    """Take out lines that left the backlog; return how many more orders are in it in part."""
    parts = 0
    for line in left:
        order, sku, quantity = lines[ORDER, line], lines[SKU, line], lines[QUANTITY, line]
        size = orders[SIZE, order]
        at, last = lines[AT, line], shelves[sku, size, START] + shelves[sku, size, LENGTH] - 1
        pool[at] = pool[last]
        lines[AT, pool[at, 2]] = at
        shelves[sku, size, LENGTH] -= 1
        parts -= 0 < orders[OPEN, order] < starts[order + 1] - starts[order]
        orders[OPEN, order] -= 1
        orders[ITEMS, order] -= quantity
        parts += 0 < orders[OPEN, order] < starts[order + 1] - starts[order]
        for station in range(known.shape[1]):
            for table in range(len(known)):
                scores[table, station, order] -= min(quantity, known[table, station, sku, size])
            if orders[OPEN, order]:
                raise_best(station, size, order, orders, scores, ranks, best)
    return parts


@njit(cache=True)
def note(table, available, now, changes, recent):  # type: ignore[no-untyped-def]
    """Note what is available now, and what of that has changed; scores follow when they matter."""
    for station in range(len(available)):
        for sku in range(available.shape[1]):
            if available[station, sku] != now[table, station, sku]:
                now[table, station, sku] = available[station, sku]
                recent[station, changes[station] % RECENT] = table * available.shape[1] + sku
                changes[station] += 1


@njit(cache=True)
def refresh(  # type: ignore[no-untyped-def]
    station, size, shelves, most, pool, orders, scores, ranks, best, known, now, changes, seen, recent
):
    """Bring the scores of the orders of a size at a station up to what is available there now."""
    begin, end, skus = seen[station, size], changes[station], known.shape[2]
    if begin == end:
        return
    seen[station, size] = end
    every = end - begin > RECENT  # more has changed than is remembered: look at all SKUs
    if every:
        begin, end = 0, len(known) * skus
    for raised in range(2):  # last, so that nothing is raised that falls again
        for at in range(begin, end):
            which = at if every else recent[station, at % RECENT]
            table, sku = which // skus, which % skus
            if (now[table, station, sku] > known[table, station, sku, size]) == (raised == 1):
                change(table, station, size, sku, shelves, most, pool, orders, scores, ranks, best, known, now)


@njit(cache=True)
def change(  # type: ignore[no-untyped-def]
    table, station, size, sku, shelves, most, pool, orders, scores, ranks, best, known, now
):
    """Bring the scores of the orders of a size with a SKU up to what is available of it at a station now."""
    had, items = min(known[table, station, sku, size], most[sku]), min(now[table, station, sku], most[sku])
    known[table, station, sku, size] = now[table, station, sku]
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
    """Let orders score more everywhere, whatever is available; return how many of them are in the backlog."""
    count = 0
    for order in places:
        count += orders[OPEN, order] > 0
        for station in range(scores.shape[1]):
            scores[0, station, order] += by
            if orders[OPEN, order]:
                raise_best(station, orders[SIZE, order], order, orders, scores, ranks, best)
    return count


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
    recent,
):
    """Place of the order and id of the station that go first of those that fit; (-1, -1) when none fits.

    The highest value, then the lowest rank, the oldest order, the station with the lowest load, the lowest id. ``best``
    is no worse than the best of each block, and is put right where a block is looked through. ``at`` has room, free
    places, capacity, whether orders are counted, and load, by station; ``limits`` the items of the largest order that
    fits, the first and the number of places, and what an order can score beyond its items. ``lanes`` has pairs of
    station and order that all free places are for, not room alone.
    """
    if limits[1] == limits[2]:  # no order is left, and there may be no block either
        return np.int64(-1), np.int64(-1)
    room, free, capacity, counts, load = at
    begin, end = limits[1] // BLOCK, (limits[2] + BLOCK - 1) // BLOCK
    leader = (-np.inf, np.inf, np.int64(-1), np.int64(0), np.int64(-1))
    for size in range(SIZES - 1, -1, -1):
        for station in range(len(room)):
            if room[station] <= 0 or (not counts[station] and size >= room[station] != capacity[station]):
                continue
            if size < SIZES - 1 and size + 1 + limits[3] + extra[station] < leader[0]:
                continue  # what is available now is looked at when it matters
            refresh(station, size, shelves, most, pool, orders, scores, ranks, best, known, now, changes, seen, recent)
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
            refresh(station, size, shelves, most, pool, orders, scores, ranks, best, known, now, changes, seen, recent)
            value = value_of(station, order, orders, scores) + extra[station]
            place = lot(key, ids[order]) if key else ranks[order]
            if is_better(value, place, order, load[station], station, leader):
                leader = (value, place, np.int64(order), load[station], np.int64(station))
    return leader[2], leader[4]
