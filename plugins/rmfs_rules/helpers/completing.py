"""Compiled look-ups of the orders that pods complete; `pair_scores` says what the arrays are."""

from __future__ import annotations

import numpy as np

from rmfs_core.jit import njit
from rmfs_rules.helpers.pair_search import (
    AT,
    LENGTH,
    LINE,
    OPEN,
    ORDER,
    PLACE,
    QUANTITY,
    SIZE,
    SIZES,
    SKU,
    START,
    WANTED,
)


@njit(cache=True)
def completed_by(pod, sku, items, shelves, pool, orders, enough):
    """Pairs of pod and place, shape (2, n), of the orders that pods complete which hold items of SKUs, one entry each.

    Entries are sorted by pod; ``enough`` is all zeros.
    """
    pairs, begin = [(np.int64(0), np.int64(0)) for _ in range(0)], 0
    while begin < len(pod):
        end = begin
        while end < len(pod) and pod[end] == pod[begin]:
            end += 1
        for size in range(SIZES):
            for entry in range(begin, end):
                start = shelves[sku[entry], size, START]
                for at in range(start, start + shelves[sku[entry], size, LENGTH]):
                    if pool[at, WANTED] <= items[entry]:
                        order = pool[at, PLACE]
                        enough[order] += 1
                        if enough[order] == orders[OPEN, order]:
                            pairs.append((np.int64(pod[begin]), np.int64(order)))
            for entry in range(begin, end):
                start = shelves[sku[entry], size, START]
                for at in range(start, start + shelves[sku[entry], size, LENGTH]):
                    enough[pool[at, PLACE]] = 0
        begin = end
    found = np.empty((2, len(pairs)), np.int64)
    for i in range(len(pairs)):
        found[0, i], found[1, i] = pairs[i]
    return found


@njit(cache=True, inline="always")
def is_open(line, orders, lines, shelves, pool):
    """Whether a line is still in the backlog: it is where it was put on its shelf."""
    size, at = orders[SIZE, lines[ORDER, line]], lines[AT, line]
    start = shelves[lines[SKU, line], size, START]
    return start <= at < start + shelves[lines[SKU, line], size, LENGTH] and pool[at, LINE] == line


@njit(cache=True)
def while_stock_lasts(pods, places, pod, sku, items, starts, lines, shelves, pool, orders):
    """Which of the orders that pods complete are completed if a pod's items go to one after another.

    Pairs are sorted by pod, as are entries, one for each SKU of a pod.
    """
    kept, left, pair = np.zeros(len(pods), np.bool_), np.zeros(len(shelves), np.int64), 0
    for begin in range(len(pod)):
        if begin == 0 or pod[begin] != pod[begin - 1]:  # another pod
            left[:] = 0
            for entry in range(begin, len(pod)):
                if pod[entry] != pod[begin]:
                    break
                left[sku[entry]] = items[entry]
            while pair < len(pods) and pods[pair] == pod[begin]:
                order, enough = places[pair], True
                for line in range(starts[order], starts[order + 1]):
                    if is_open(line, orders, lines, shelves, pool) and lines[QUANTITY, line] > left[lines[SKU, line]]:
                        enough = False
                for line in range(starts[order], starts[order + 1]):
                    if enough and is_open(line, orders, lines, shelves, pool):
                        left[lines[SKU, line]] -= lines[QUANTITY, line]
                kept[pair] = enough
                pair += 1
    return kept


@njit(cache=True)
def count(order, sign, left, starts, lines, shelves, pool, orders, by_sku, first, pod, number, counts):
    """Count an order for the pods that have enough for all its lines, those that are open or have just left."""
    wanted, turn = [0 for _ in range(0)], 0
    for line in range(starts[order], starts[order + 1]):
        just = turn < len(left) and left[turn] == line
        if just:
            turn += 1
        if just or (orders[OPEN, order] and is_open(line, orders, lines, shelves, pool)):
            wanted.append(line)
    if not wanted:
        return
    for place in range(first[lines[SKU, wanted[0]]], first[lines[SKU, wanted[0]] + 1]):
        one, enough = pod[by_sku[place]], True
        for line in wanted:
            sku = lines[SKU, line]
            at, end = first[sku], first[sku + 1]
            beyond = end
            while at < beyond:
                middle = (at + beyond) // 2
                if pod[by_sku[middle]] < one:
                    at = middle + 1
                else:
                    beyond = middle
            if at == end or pod[by_sku[at]] != one or number[by_sku[at]] < lines[QUANTITY, line]:
                enough = False
                break
        if enough:
            counts[one] += sign


@njit(cache=True)
def recount(before, end, left, starts, lines, shelves, pool, orders, by_sku, first, pod, number, counts):
    """Take lines that left (ascending), and the orders from ``before`` to the end, into what pods complete alone.

    Entries of pods and SKUs are in ``by_sku`` by SKU and pod, from ``first`` on.
    """
    at = 0
    while at < len(left):  # orders of which lines left: they counted as they were before
        order, begin = lines[ORDER, left[at]], at
        while at < len(left) and lines[ORDER, left[at]] == order:
            at += 1
        if order < before:
            count(order, -1, left[begin:at], starts, lines, shelves, pool, orders, by_sku, first, pod, number, counts)
            count(order, 1, left[:0], starts, lines, shelves, pool, orders, by_sku, first, pod, number, counts)
    for order in range(before, end):
        count(order, 1, left[:0], starts, lines, shelves, pool, orders, by_sku, first, pod, number, counts)
