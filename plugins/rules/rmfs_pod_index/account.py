"""The account of open lines and free items, compiled: what changes when lines join or leave the backlog."""

from __future__ import annotations

from numba import njit

from rmfs_pod_index.period import NONE, WANTED, period_of


@njit(cache=True)
def count(p, line, sign):  # type: ignore[no-untyped-def]
    """Count an open line where it counts, or no longer: for its SKU, its order, and the pods that have items for it."""
    sku, order = p.lines[line].sku, p.orders[p.lines[line].order]
    wanted, arrival = p.skus[sku], sign * order.arrival
    if wanted.number == 0:
        insert(p, sku)
    wanted.number += sign
    wanted.arrivals += arrival
    if wanted.number == 0:
        remove(p, sku)
    order.open_items += sign * p.lines[line].quantity
    for k in range(p.first_with[sku], p.first_with[sku + 1]):
        if p.holders[k].free > 0:
            p.ages[p.holders[k].pod].lines_of += sign
            p.ages[p.holders[k].pod].arrivals_of += arrival


@njit(cache=True)
def insert(p, sku):  # type: ignore[no-untyped-def]
    """Take a SKU into those that have open lines, ascending."""
    at = p.numbers[WANTED]
    while at > 0 and p.wanted[at - 1] > sku:
        p.wanted[at] = p.wanted[at - 1]
        at -= 1
    p.wanted[at] = sku
    p.numbers[WANTED] += 1


@njit(cache=True)
def remove(p, sku):  # type: ignore[no-untyped-def]
    """Take a SKU from those that have open lines."""
    p.numbers[WANTED] -= 1
    at = p.numbers[WANTED]
    behind = p.wanted[at]
    while behind != sku:
        at -= 1
        behind, p.wanted[at] = p.wanted[at], behind


@njit(cache=True)
def join(words, at, ticks, placed, begin, end):  # type: ignore[no-untyped-def]
    """Take in lines that joined the backlog; all of an order at once, one after another."""
    p = period_of(words, at, ticks, placed)
    for line in range(begin, end):
        order, sku = p.lines[line].order, p.lines[line].sku
        if line == begin or order != p.lines[line - 1].order:
            p.orders[order].begin = line
        p.orders[order].end = line + 1
        tail = p.skus[sku].tail
        p.lines[line].untaken = True
        p.lines[line].before, p.lines[line].after = tail, NONE
        if tail == NONE:
            p.skus[sku].head = line
        else:
            p.lines[tail].after = line
        p.skus[sku].tail = line
        count(p, line, 1)


@njit(cache=True)
def update(words, at, ticks, placed, lines, entries, items):  # type: ignore[no-untyped-def]
    """Leave out lines that left the backlog, and take in free items of the entries that changed."""
    p = period_of(words, at, ticks, placed)
    for line in lines:
        sku, before, after = p.lines[line].sku, p.lines[line].before, p.lines[line].after
        p.lines[line].untaken = False
        if before == NONE:
            p.skus[sku].head = after
        else:
            p.lines[before].after = after
        if after == NONE:
            p.skus[sku].tail = before
        else:
            p.lines[after].before = before
        count(p, line, -1)

    for i in entries:
        entry = p.entries[i]
        if items[i] != entry.free:
            sku, pod = p.skus[entry.sku], p.ages[entry.pod]
            sign = int(items[i] > 0) - int(entry.free > 0)
            pod.lines_of += sign * sku.number
            pod.arrivals_of += sign * sku.arrivals
            entry.free = p.holders[entry.holder].free = items[i]
