"""Fills slots at the stations with whole orders: compiled, and exact.

Orders are added one by one to the vectors of slots taken at the stations. `fill` keeps every vector once, with the
order that led to it. `fill_with_few_splits` keeps a vector again when it is reached with fewer newly split orders than
before: no more matters, because what can be added to a vector does not depend on how it came about, and more splits
leave less for others. Whether an order is split can be told from the slots it takes: at one station, or several.
"""

from __future__ import annotations

import numpy as np

from rmfs_core.jit import njit
from rmfs_rules.mip.compiled.pod_sets import complete

STEPS_PER_WORK = 100
"""Slots of an order added to a vector of slots, that count as one step of the search."""


@njit(cache=True)
def _options(a, order, mask, seen, packed, index, strides):
    """Write the vectors of slots that an order can take, one byte per station and as index; return their number."""
    first, last = a.order_start[order], a.order_start[order + 1]
    stations = len(a.rooms)
    if a.whole:
        everywhere, items, count = (1 << stations) - 1, a.items[order], 0
        for line in range(first, last):
            everywhere &= mask[a.line_sku[line]]
        for station in range(stations):
            if everywhere >> station & 1 and items <= a.rooms[station]:
                packed[0, count] = items << (8 * station)
                index[0, count] = items * strides[station]
                count += 1
        return count
    packed[0, 0], index[0, 0], count = 0, 0, 1
    for line in range(first, last):
        where, items, more = mask[a.line_sku[line]], a.line_items[line], 0
        for at in range(count):
            for station in range(stations):
                taken = (packed[0, at] >> (8 * station) & 255) + items
                if where >> station & 1 and taken <= a.rooms[station]:
                    vector = index[0, at] + items * strides[station]
                    if not seen[vector]:
                        seen[vector] = True
                        packed[1, more] = packed[0, at] + (items << (8 * station))
                        index[1, more] = vector
                        more += 1
        count = more
        for at in range(count):
            packed[0, at], index[0, at] = packed[1, at], index[1, at]
            seen[index[0, at]] = False
    return count


@njit(cache=True)
def _packing(rooms):
    """Return how vectors of slots are told apart.

    A step of each station in the index of a vector, two numbers that find out packed vectors (one byte per station)
    with more than a station's capacity (those with ``vector + bias & guard``), and the number of vectors.
    """
    strides, bias, guard, states = np.ones(len(rooms), np.int64), 0, 0, 1
    for station in range(len(rooms)):
        strides[station] = states
        states *= rooms[station] + 1
        bias += (127 - rooms[station]) << (8 * station)
        guard += 128 << (8 * station)
    return strides, bias, guard, states


@njit(cache=True)
def fill(a, mask, target):
    """Fill slots with orders whose SKUs are there.

    Parameters
    ----------
    a
        The period (`compiled.arrays.Arrays`).
    mask
        Per SKU the bit mask of the stations where it is.
    target
        Number of slots to fill.

    Returns
    -------
    found, chosen
        Whether that is possible; a row for each chosen order with the slots that it takes (one byte per station).
    """
    strides, bias, guard, states = _packing(a.rooms)
    known, seen = np.zeros(states, np.bool_), np.zeros(states, np.bool_)
    vector, index, total = np.zeros(states, np.int64), np.zeros(states, np.int64), np.zeros(states, np.int64)
    came, order_of = np.full(states, -1), np.full(states, -1)
    packed, place = np.empty((2, states), np.int64), np.empty((2, states), np.int64)
    known[0], count = True, 1
    for order in range(len(a.order_start) - 1):
        if not complete(a, order, mask):
            continue
        options, end = _options(a, order, mask, seen, packed, place, strides), count
        for at in range(end):
            for option in range(options):
                if (vector[at] + packed[0, option] + bias) & guard:
                    continue  # more than a station's capacity
                reached = index[at] + place[0, option]
                if known[reached]:
                    continue
                known[reached] = True
                vector[count], index[count] = vector[at] + packed[0, option], reached
                total[count], came[count], order_of[count] = total[at] + a.items[order], at, order
                if total[count] >= target:
                    return True, _way_back(count, vector, came, order_of)
                count += 1
    return target <= 0, _way_back(0, vector, came, order_of)


@njit(cache=True)
def _way_back(at, vector, came, order_of):
    steps = 0
    step = at
    while came[step] >= 0:
        step = came[step]
        steps += 1
    chosen = np.empty((steps, 2), np.int64)
    for row in range(steps - 1, -1, -1):
        chosen[row, 0] = order_of[at]
        chosen[row, 1] = vector[at] - vector[came[at]]
        at = came[at]
    return chosen


@njit(cache=True)
def _is_split(packed):
    """Whether an order that takes these slots (one byte per station) is at several stations."""
    while packed & 255 == 0:
        packed >>= 8
    return packed > 255


@njit(cache=True)
def newly_split(a, chosen):
    """Return how many orders, chosen as `fill` returns them, are split and were whole until now."""
    count = 0
    for row in range(len(chosen)):
        count += _is_split(chosen[row, 1]) and not a.begun[chosen[row, 0]]
    return count


@njit(cache=True)
def _room_for(array, count):
    """Return the array with space for another ``count`` rows."""
    longer = np.empty((len(array) + max(count, len(array)), array.shape[1]), np.int64)
    for row in range(len(array)):
        for column in range(array.shape[1]):
            longer[row, column] = array[row, column]
    return longer


@njit(cache=True)
def fill_with_few_splits(a, mask, target, work):
    """Fill slots as `fill` does, with at most ``a.splits`` newly split orders.

    Vectors that cannot reach the target with all later orders are left behind.

    Parameters
    ----------
    a, mask, target
        As of `fill`.
    work
        A single number, to which what was tried is added.

    Returns
    -------
    found, chosen
        As `fill`.
    """
    strides, bias, guard, states = _packing(a.rooms)
    seen, fewest = np.zeros(states, np.bool_), np.full(states, a.splits + 1)
    packed, place = np.empty((2, states), np.int64), np.empty((2, states), np.int64)
    orders = np.array([order for order in range(len(a.items)) if complete(a, order, mask)], np.int64)
    later = a.items[orders].sum()
    nodes, count = np.zeros((1024, 6), np.int64), 1  # vector, its index, items, newly split, node before, order
    nodes[0, 4], nodes[0, 5], fewest[0] = -1, -1, 0
    alive = np.zeros(1, np.int64)
    for order in orders:
        first = count
        options = _options(a, order, mask, seen, packed, place, strides)
        later -= a.items[order]
        for node in alive:
            if count + options > len(nodes):
                nodes = _room_for(nodes, options)
            for option in range(options):
                vector = nodes[node, 0] + packed[0, option]
                if (vector + bias) & guard:
                    continue  # more than a station's capacity
                splits = nodes[node, 3] + (_is_split(packed[0, option]) and not a.begun[order])
                reached, total = nodes[node, 1] + place[0, option], nodes[node, 2] + a.items[order]
                if splits >= fewest[reached] or total + later < target:
                    continue
                fewest[reached] = splits
                nodes[count, 0], nodes[count, 1], nodes[count, 2] = vector, reached, total
                nodes[count, 3], nodes[count, 4], nodes[count, 5] = splits, node, order
                count += 1
                if total >= target:
                    return True, _way_back(count - 1, nodes[:, 0], nodes[:, 4], nodes[:, 5])
        work[0] += len(alive) * options // STEPS_PER_WORK
        alive = _still_alive(nodes, alive, first, count, fewest, target - later)
    return target <= 0, _way_back(0, nodes[:, 0], nodes[:, 4], nodes[:, 5])


@njit(cache=True)
def _still_alive(nodes, alive, first, count, fewest, least):
    """Return the nodes, old and new, that none with fewer splits replaces, and that have at least so many items."""
    kept, number = np.empty(len(alive) + count - first, np.int64), 0
    for at in range(len(kept)):
        node = alive[at] if at < len(alive) else first + at - len(alive)
        if nodes[node, 3] == fewest[nodes[node, 1]] and nodes[node, 2] >= least:
            kept[number] = node
            number += 1
    return kept[:number]
