"""Whether some visits let whole orders fill the stations: compiled, and exact.

`fill` adds orders one by one to the vectors of places taken at the stations; every vector is kept once, with the order
that led to it. `spread` tries the ways to send a set of pods to the stations with a given number of visits. It leaves
out those that a cut forbids: of the items that the set completes, a group of stations that covers some of them alone
can take no more than its free places, and all but a known slack of the items have to find one.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from rmfs_mip.completing import next_set, sets_of

FOUND, NOT_FOUND, NO_SETS, TOO_MANY = 0, 1, 2, 3


@njit(cache=True)
def _options(a, order, mask, seen, packed, index, strides):  # type: ignore[no-untyped-def]
    """Write the vectors of places that an order can take, one byte per station and as index; return their number."""
    first, last = a.order_start[order], a.order_start[order + 1]
    stations = len(a.rooms)
    if a.whole:
        everywhere, items = (1 << stations) - 1, 0
        for line in range(first, last):
            everywhere &= mask[a.line_sku[line]]
            items += a.line_items[line]
        count = 0
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
def fill(a, mask, target):  # type: ignore[no-untyped-def]
    """Fill ``target`` places with orders whose SKUs are there (bit masks by SKU).

    Return whether that is possible, and the chosen orders with the places that each takes (one byte per station).
    """
    stations = len(a.rooms)
    strides, bias, guard, states = np.ones(stations, np.int64), 0, 0, 1
    for station in range(stations):
        strides[station] = states
        states *= a.rooms[station] + 1
        bias += (127 - a.rooms[station]) << (8 * station)
        guard += 128 << (8 * station)
    known, seen = np.zeros(states, np.bool_), np.zeros(states, np.bool_)
    vector, index, total = np.zeros(states, np.int64), np.zeros(states, np.int64), np.zeros(states, np.int64)
    came, order_of = np.full(states, -1), np.full(states, -1)
    packed, place = np.empty((2, states), np.int64), np.empty((2, states), np.int64)
    known[0], count = True, 1
    for order in range(len(a.order_start) - 1):
        served, items = True, 0
        for line in range(a.order_start[order], a.order_start[order + 1]):
            items += a.line_items[line]
            if mask[a.line_sku[line]] == 0:
                served = False
                break
        if not served:
            continue
        options, end = _options(a, order, mask, seen, packed, place, strides), count
        for at in range(end):
            for option in range(options):
                if (vector[at] + packed[0, option] + bias) & guard:
                    continue  # more than a station's room
                reached = index[at] + place[0, option]
                if known[reached]:
                    continue
                known[reached] = True
                vector[count], index[count] = vector[at] + packed[0, option], reached
                total[count], came[count], order_of[count] = total[at] + items, at, order
                if total[count] >= target:
                    return True, _way_back(count, vector, came, order_of)
                count += 1
    return target <= 0, _way_back(0, vector, came, order_of)


@njit(cache=True)
def _way_back(at, vector, came, order_of):  # type: ignore[no-untyped-def]
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
def _completed(a, pods):  # type: ignore[no-untyped-def]
    """Return per SKU the items of orders whose SKUs are all on these pods or at hand, and their sum."""
    there = a.at_hand > 0
    for pod in pods:
        for at in range(a.pod_start[pod], a.pod_start[pod + 1]):
            there[a.pod_sku[at]] = True
    items, total = np.zeros(len(there), np.int64), 0
    for order in range(len(a.order_start) - 1):
        first, last = a.order_start[order], a.order_start[order + 1]
        complete = True
        for line in range(first, last):
            complete &= there[a.line_sku[line]]
        if complete:
            for line in range(first, last):
                items[a.line_sku[line]] += a.line_items[line]
                total += a.line_items[line]
    return items, total


@njit(cache=True)
def _crowded(by_mask, rooms, slack):  # type: ignore[no-untyped-def]
    """Whether a group of stations alone covers more items than its places and the slack."""
    for group in range(1, 1 << len(rooms)):
        items = -slack
        for mask in range(1, group + 1):
            if mask & ~group == 0:
                items += by_mask[mask]
        for station in range(len(rooms)):
            items -= rooms[station] * (group >> station & 1)
        if items > 0:
            return True
    return False


@njit(cache=True)
def _whole_orders_short(a, mask, target):  # type: ignore[no-untyped-def]
    """Whether orders that have to go to a single station cannot fill the target: by cuts, as in `_crowded`."""
    stations = len(a.rooms)
    by_mask, total = np.zeros(1 << stations, np.int64), 0
    for order in range(len(a.order_start) - 1):
        where, items = (1 << stations) - 1, 0
        for line in range(a.order_start[order], a.order_start[order + 1]):
            where &= mask[a.line_sku[line]]
            items += a.line_items[line]
        for station in range(stations):
            if a.rooms[station] < items:
                where &= ~(1 << station)
        if where:
            by_mask[where] += items
            total += items
    return total < target or _crowded(by_mask, a.rooms, total - target)


@njit(cache=True)
def _ones(mask):  # type: ignore[no-untyped-def]
    ones = 0
    while mask:
        ones += mask & 1
        mask >>= 1
    return ones


@njit(cache=True)
def _next_stations(a, pod, sent, most, used):  # type: ignore[no-untyped-def]
    """Return the bit mask of stations after ``sent`` to send a pod to, at most ``most`` of them; 0 after the last.

    Of interchangeable stations, the first ``used`` have pods of the set; of the others, the first go first.
    """
    for mask in range(sent + 1, 1 << len(a.rooms)):
        fresh = mask >> used
        if mask & ~a.useful[pod] == 0 and _ones(mask) <= most and not (a.alike and fresh & (fresh + 1)):
            return mask
    return 0


@njit(cache=True)
def _settle(a, pod, sent, settled, items, mask, by_mask):  # type: ignore[no-untyped-def]
    """Let a pod bring its SKUs to stations, and count the items of those that no later pod brings."""
    for at in range(a.pod_start[pod], a.pod_start[pod + 1]):
        sku = a.pod_sku[at]
        mask[sku] |= sent
        if settled[sku]:
            by_mask[mask[sku]] += items[sku]


@njit(cache=True)
def spread(a, pods, visits, target, work, most_work):  # type: ignore[no-untyped-def]
    """Find stations for each of the pods, with so many visits in all, such that orders fill the target.

    Return whether there are some, a bit mask of stations per pod, and the orders as `fill` does. ``work[0]`` counts
    what was tried; above ``most_work`` the answer no proves nothing.
    """
    n, skus = len(pods), len(a.at_hand)
    items, total = _completed(a, pods)
    sent, chosen = np.zeros(n + 1, np.int64), np.empty((0, 2), np.int64)
    if total < target:
        return False, sent[:n], chosen
    open_later, settled = np.zeros(skus, np.bool_), np.zeros((n, skus), np.bool_)
    for depth in range(n - 1, -1, -1):
        for at in range(a.pod_start[pods[depth]], a.pod_start[pods[depth] + 1]):
            settled[depth, a.pod_sku[at]] = not open_later[a.pod_sku[at]]
            open_later[a.pod_sku[at]] = True
    mask, by_mask = np.zeros((n + 1, skus), np.int64), np.zeros((n + 1, 1 << len(a.rooms)), np.int64)
    left, used = np.zeros(n + 1, np.int64), np.zeros(n + 1, np.int64)
    left[0], mask[0], depth = visits, a.at_hand, 0
    for sku in range(skus):
        if not open_later[sku]:
            by_mask[0, a.at_hand[sku]] += items[sku]
    while depth >= 0 and work[0] <= most_work:
        if depth == n:
            if left[n] == 0 and not (a.whole and _whole_orders_short(a, mask[n], target)):
                work[0] += 10
                found, chosen = fill(a, mask[n], target)
                if found:
                    return True, sent[:n], chosen
            depth -= 1
            continue
        stations = _next_stations(a, pods[depth], sent[depth], left[depth] - (n - depth - 1), used[depth])
        sent[depth] = stations
        if stations == 0:
            depth -= 1
            continue
        work[0] += 1
        left[depth + 1], used[depth + 1] = left[depth] - _ones(stations), used[depth]
        while stations >> used[depth + 1]:
            used[depth + 1] += 1
        mask[depth + 1], by_mask[depth + 1] = mask[depth], by_mask[depth]
        _settle(a, pods[depth], stations, settled[depth], items, mask[depth + 1], by_mask[depth + 1])
        if not _crowded(by_mask[depth + 1], a.rooms, total - target):
            depth += 1
            sent[depth] = 0
    return False, sent[:n], chosen


@njit(cache=True)
def pods_that_fill(a, number, visits, target, work, most_work):  # type: ignore[no-untyped-def]
    """Search ``number`` pods that fill ``target`` places with so many visits.

    Stations are left aside at first: a set of pods that completes too little cannot fill them, wherever its pods go.
    Return `FOUND`, `NOT_FOUND` (there are none), `NO_SETS` (not even with any number of visits) or `TOO_MANY`
    (``work[0]`` went above ``most_work``), the pods, a bit mask of stations for each, and the orders as `fill` does.
    """
    items = np.zeros(len(a.order_start) - 1)
    for order in range(len(items)):
        for line in range(a.order_start[order], a.order_start[order + 1]):
            items[order] += a.line_items[line]
    sets, answer = sets_of(a, number, items, target), NO_SETS
    while next_set(a, sets, work, most_work):
        answer = NOT_FOUND
        found, masks, orders = spread(a, sets.chosen, visits, target, work, most_work)
        if found:
            return FOUND, sets.chosen, masks, orders
    if work[0] > most_work:
        answer = TOO_MANY
    return answer, sets.chosen, sets.chosen, np.empty((0, 2), np.int64)
