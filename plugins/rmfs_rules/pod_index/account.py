"""The account of open lines and free items, compiled: what changes when lines join or leave the backlog."""

from __future__ import annotations

from rmfs_core.jit import njit
from rmfs_rules.pod_index.period import NONE, WANTED, period_of
from rmfs_rules.pod_index.urging import find_front


@njit(cache=True)
def count(p, line, sign):
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
def insert(p, sku):
    """Take a SKU into those that have open lines, ascending."""
    at = p.numbers[WANTED]
    while at > 0 and p.wanted[at - 1] > sku:
        p.wanted[at] = p.wanted[at - 1]
        at -= 1
    p.wanted[at] = sku
    p.numbers[WANTED] += 1


@njit(cache=True)
def remove(p, sku):
    """Take a SKU from those that have open lines."""
    p.numbers[WANTED] -= 1
    at = p.numbers[WANTED]
    behind = p.wanted[at]
    while behind != sku:
        at -= 1
        behind, p.wanted[at] = p.wanted[at], behind


@njit(cache=True)
def bring(p, pod, station):
    """Note where a pod goes last, which has its free items then; NONE for nowhere."""
    before = p.pods[pod].last
    p.pods[pod].last = station
    for entry in p.entries[p.first[pod] : p.first[pod + 1]]:
        if before != NONE:
            p.available[entry.sku, before] -= entry.free
        if station != NONE:
            p.available[entry.sku, station] += entry.free


@njit(cache=True)
def move(words, at, ticks, placed, moved):
    """Note where pods are: each one's id, where it goes last, and its cell where it is free, shape (pods, 3)."""
    bring_all(period_of(words, at, ticks, placed), moved)


@njit(cache=True)
def bring_all(p, moved):
    """Note where pods are, in a period."""
    for i in range(len(moved)):
        pod, last, cell = moved[i, 0], moved[i, 1], moved[i, 2]
        if p.pods[pod].last != last:
            bring(p, pod, last)
        p.pods[pod].cell, p.pods[pod].free = cell, cell != NONE


@njit(cache=True)
def join(words, at, ticks, placed, begin, rows, orders):
    """Take in lines that joined the backlog; all of an order at once, one after another.

    Parameters
    ----------
    words, at, ticks, placed
        The period.
    begin
        How many lines were there.
    rows
        Order, SKU and items of each line, shape (3, lines).
    orders
        Order, arrival, when it is due, how many times more it is worth by its priority, and how many times at most, of
        each order, shape (orders, 5).
    """
    p = period_of(words, at, ticks, placed)
    for told in orders:
        new = p.orders[int(told[0])]
        new.arrival, new.due_s, new.worth, new.highest, new.left = int(told[1]), told[2], told[3], told[4], -1.0
        new.begin = NONE
    for i in range(rows.shape[1]):
        line, order, sku = begin + i, rows[0, i], rows[1, i]
        p.lines[line].order, p.lines[line].sku, p.lines[line].quantity = order, sku, rows[2, i]
        if p.orders[order].begin == NONE:
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
def update(words, at, ticks, placed, now, lines, entries, items):
    """Leave out lines that left the backlog, take in free items that changed, and find the front of pods.

    Parameters
    ----------
    words, at, ticks, placed
        The period.
    now
        The tick.
    lines
        Those that left.
    entries, items
        Entries that changed; and the free items of all.

    Returns
    -------
    How many pods are at the front.
    """
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
            if p.pods[entry.pod].last != NONE:
                p.available[entry.sku, p.pods[entry.pod].last] += items[i] - entry.free
            entry.free = p.holders[entry.holder].free = items[i]
    return find_front(p, now)
