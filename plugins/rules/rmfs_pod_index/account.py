"""The account of open lines and free items, compiled: what changes when lines join or leave the backlog."""

from __future__ import annotations

import numpy as np
from numba import njit

from rmfs_pod_index.period import NONE, WANTED


@njit(cache=True)
def sorted_by_sku(sku, n_skus):  # type: ignore[no-untyped-def]
    """Return entries sorted by SKU, and where each SKU's begin."""
    first = np.zeros(n_skus + 1, np.int64)
    for i in sku:
        first[i + 1] += 1
    for i in range(n_skus):
        first[i + 1] += first[i]
    to, by_sku = first.copy(), np.empty(len(sku), np.int64)
    for line in range(len(sku)):
        by_sku[to[sku[line]]] = line
        to[sku[line]] += 1
    return by_sku, first


@njit(cache=True)
def count(p, line, sign, shelves):  # type: ignore[no-untyped-def]
    """Count an open line where it counts, or no longer: for its SKU, its order, and the pods that have items for it."""
    sku, arrival = p.sku[line], sign * p.arrival[p.order[line]]
    p.number[sku] += sign
    p.arrivals[sku] += arrival
    p.open_items[p.order[line]] += sign * p.quantity[line]
    for k in range(shelves.first_with[sku], shelves.first_with[sku + 1]):
        entry = shelves.by_sku[k]
        if p.items[entry] > 0:
            p.lines_of[shelves.pod[entry]] += sign
            p.arrivals_of[shelves.pod[entry]] += arrival


@njit(cache=True)
def join(p, begin, end, shelves):  # type: ignore[no-untyped-def]
    """Take in lines that joined the backlog; all of an order at once, one after another."""
    for line in range(begin, end):
        order, sku = p.order[line], p.sku[line]
        if line == begin or order != p.order[line - 1]:
            p.begin[order] = line
        p.end[order] = line + 1
        p.untaken[line] = True
        p.before[line], p.after[line] = p.tail[sku], NONE
        if p.tail[sku] == NONE:
            p.head[sku] = line
        else:
            p.after[p.tail[sku]] = line
        p.tail[sku] = line
        count(p, line, 1, shelves)


@njit(cache=True)
def update(p, lines, items, shelves):  # type: ignore[no-untyped-def]
    """Leave out lines that left the backlog, and take in what free items there are; none: as many as there were."""
    for line in lines:
        sku, before, after = p.sku[line], p.before[line], p.after[line]
        p.untaken[line] = False
        if before == NONE:
            p.head[sku] = after
        else:
            p.after[before] = after
        if after == NONE:
            p.tail[sku] = before
        else:
            p.before[after] = before
        count(p, line, -1, shelves)

    for entry in range(len(items)):
        if items[entry] != p.items[entry]:
            sku, pod = shelves.sku[entry], shelves.pod[entry]
            sign = int(items[entry] > 0) - int(p.items[entry] > 0)
            p.lines_of[pod] += sign * p.number[sku]
            p.arrivals_of[pod] += sign * p.arrivals[sku]
            p.items[entry] = items[entry]


@njit(cache=True)
def find_wanted(p):  # type: ignore[no-untyped-def]
    """List the SKUs that have open lines."""
    number = 0
    for sku in range(len(p.number)):
        if p.number[sku]:
            p.wanted[number] = sku
            number += 1
    p.numbers[WANTED] = number
