"""What the lines of a period are worth, and which pod is best; compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

from rmfs_pod_index.period import FOUND, NONE, PACKING_ROOM

CLOSE = 1e-9
"""Relative difference up to which two indices count as equal: sums of the same numbers in another order may differ."""
TINY = 1e-12
"""What sums of gains that are zero may come out as."""


@njit(cache=True)
def sorted_by_sku(sku, n_skus):  # type: ignore[no-untyped-def]
    """Return entries or lines sorted by SKU, and where each SKU's begin."""
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
def grouped(order, order_id, sku, quantity, n_skus):  # type: ignore[no-untyped-def]
    """Return ids and open items of the orders of lines; the lines by SKU, where those of each begin, which have any."""
    ids = np.empty(order[-1] + 1 if len(order) else 0, np.int64)
    open_items = np.zeros(len(ids), np.int64)
    for line in range(len(order)):
        ids[order[line]] = order_id[line]
        open_items[order[line]] += quantity[line]
    by_sku, first = sorted_by_sku(sku, n_skus)
    return ids, open_items, by_sku, first, np.flatnonzero(first[1:] > first[:-1])


@njit(cache=True)
def unknown(ids, arrival):  # type: ignore[no-untyped-def]
    """Return the ids of which nothing is known."""
    found = np.empty(len(ids), np.int64)
    number = 0
    for i in ids:
        if i >= len(arrival) or arrival[i] < 0:
            found[number] = i
            number += 1
    return found[:number]


@njit(cache=True)
def bring(available, pod, station, sign, shelves, items):  # type: ignore[no-untyped-def]
    """Add a pod's free items to those of a station, or take them away."""
    for entry in range(shelves.first[pod], shelves.first[pod + 1]):
        available[station, shelves.sku[entry]] += sign * items[entry]


@njit(cache=True)
def brought_so_far(available, before, pods, last, shelves, items):  # type: ignore[no-untyped-def]
    """Set the items of each SKU that pods have free, at the stations where they go last: each counts once.

    ``before`` are the pods that ``available`` has items of.
    """
    for pod in before:
        for entry in range(shelves.first[pod], shelves.first[pod + 1]):
            available[:, shelves.sku[entry]] = 0
    for pod in pods:
        bring(available, pod, last[pod], 1, shelves, items)


@njit(cache=True)
def share_visits(share, first, wanted, available, shelves, items, cost_s):  # type: ignore[no-untyped-def]
    """Work out seconds of a visit for each line of a SKU that no pod at or bound for a station has, 0 before."""
    number = np.zeros(len(shelves.first) - 1, np.int64)
    for sku in wanted:
        for k in range(shelves.first_with[sku], shelves.first_with[sku + 1]):
            if items[shelves.by_sku[k]] > 0:
                number[shelves.pod[shelves.by_sku[k]]] += first[sku + 1] - first[sku]
    for sku in wanted:
        here = False
        for station in range(len(available)):
            here = here or available[station, sku] > 0
        most = 0
        for k in range(shelves.first_with[sku], shelves.first_with[sku + 1]):
            if items[shelves.by_sku[k]] > 0:
                most = max(most, number[shelves.pod[shelves.by_sku[k]]])
        if not here and most > 0:
            share[sku] = cost_s / most


@njit(cache=True)
def look_at(line, order, sku, quantity, share, untaken, factor, left, power, weights):  # type: ignore[no-untyped-def]
    """Work out, for the order of a line, what the seconds of its lines are divided by for their worth."""
    at, whose = line, order[line]
    while at > 0 and order[at - 1] == whose:
        at -= 1
    left[whose] = 0.0
    while at < len(order) and order[at] == whose:
        if untaken[at]:
            left[whose] += weights.handle_s * quantity[at] + share[sku[at]]
        at += 1
    power[whose] = left[whose] ** weights.finish
    if len(factor):
        power[whose] /= factor[whose]


@njit(cache=True)
def fits(p, line, station, packing):  # type: ignore[no-untyped-def]
    """Whether a line may be taken and fits the free places of a station."""
    if not p.untaken[line]:
        return False
    order = p.order[line]
    if packing and not (p.split[order] or p.single[order] or p.numbers[PACKING_ROOM] > 0):
        return False
    if p.counts_orders[station]:
        return p.room[station] > 0 or p.placed[station, order]
    return p.quantity[line] <= p.room[station]


@njit(cache=True)
def best_covered(p, station, more_than, weights):  # type: ignore[no-untyped-def]
    """Line of the largest worth that the pods of a station cover, the oldest of equals, and its worth; NONE for none.

    Of lines that want more items of their SKU than ``more_than`` has alone.
    """
    # Each name for what a period has is given outside of the loops: to look it up takes longer than what they do
    order, sku_of, quantity, share, untaken = p.order, p.sku, p.quantity, p.share, p.untaken
    left, power, factor, by_sku, first, here = p.left, p.power, p.factor, p.by_sku, p.first, p.available[station]
    open_items, least = p.open_items, p.least
    plain = not (weights.packing or p.counts_orders[station])
    room, best, most = p.room[station], NONE, 0.0
    for sku in p.wanted:
        if here[sku] > 0:
            for k in range(first[sku], first[sku + 1]):
                line = by_sku[k]
                q = quantity[line]
                if not untaken[line] or q <= more_than[sku] or q > here[sku]:
                    continue
                if q <= room if plain else fits(p, line, station, weights.packing):
                    seconds, whose = weights.handle_s * q + share[sku], order[line]
                    if left[whose] < 0:
                        # What it could be worth at most takes no power to know
                        at_most = (1 + CLOSE) * seconds / least[open_items[whose]]
                        if (at_most * factor[whose] if len(factor) else at_most) < most:
                            continue
                        look_at(line, order, sku_of, quantity, share, untaken, factor, left, power, weights)
                    w = seconds / power[whose]
                    if best == NONE or w > most or (w == most and line < best):
                        best, most = line, w
    return best, most


@njit(cache=True)
def best_pods(p, station, bound, pods, shelves, weights):  # type: ignore[no-untyped-def]
    """Fill in ``found`` with the pods of the largest index for a station, if that is above ``bound``: all equal ones.

    For a station that no pod is at or bound for also those whose index is less by up to the share ``near``.

    The index of a pod is the largest ratio of worth to seconds, ``sum of w / (visit_s + handle_s * items)``, over the
    sets of lines that it would bring. That ratio is above r when the lines' ``w - r * handle_s * items``, those that
    are positive, add up to more than ``r * visit_s``: there each line decides for itself whether it is in the set. So r
    rises from the bound to the ratio of a better pod until no pod is better (Dinkelbach's method), at O(lines +
    contents) a step.
    """
    p.numbers[FOUND] = 0
    w, q, start, end = wanted_there(p, station, bound * weights.handle_s * (1 - 2 * CLOSE), weights)
    index, better = bound, NONE
    while True:
        values = gains(p, station, index * weights.handle_s, w, q, start, end, pods, shelves)
        best = NONE
        for pod in range(len(pods)):
            if pods[pod] and (best == NONE or values[pod] > values[best]):
                best = pod
        if best == NONE or values[best] <= index * weights.visit_s * (1 + CLOSE) + TINY:
            break
        better = best
        index = ratio(p, station, best, index * weights.handle_s, w, q, start, end, shelves, weights)
    if better != NONE:
        less = CLOSE if p.inbound[station] else max(CLOSE, weights.near)
        index = max(index * (1 - less), bound * (1 - 2 * CLOSE))  # below that, lines were left out
        values = gains(p, station, index * weights.handle_s, w, q, start, end, pods, shelves)
        for pod in range(len(pods)):
            if pods[pod] and values[pod] > index * weights.visit_s:
                p.found[p.numbers[FOUND]] = pod
                p.numbers[FOUND] += 1


@njit(cache=True)
def wanted_there(p, station, rate, weights):  # type: ignore[no-untyped-def]
    """Return worth and items of the lines that a station does not cover, by SKU, and where those of each SKU are.

    Of lines that may be worth more than a rate.
    """
    order, sku_of, quantity, share, untaken = p.order, p.sku, p.quantity, p.share, p.untaken
    left, power, factor, by_sku, first, available = p.left, p.power, p.factor, p.by_sku, p.first, p.available
    plain = not (weights.packing or p.counts_orders[station])
    open_items, least, room, number = p.open_items, p.least, p.room[station], 0
    w, q = np.empty(len(order)), np.empty(len(order), np.int64)
    start, end = np.zeros(len(share), np.int64), np.zeros(len(share), np.int64)
    for sku in p.wanted:
        start[sku] = number
        other, here = 0, available[station, sku]
        for i in range(len(available)):
            if i != station:
                other = max(other, available[i, sku])
        for k in range(first[sku], first[sku + 1]):
            line = by_sku[k]
            items = quantity[line]
            if not untaken[line] or items <= here:
                continue
            if items <= room if plain else fits(p, line, station, weights.packing):
                seconds, whose = weights.handle_s * items + share[sku], order[line]
                if left[whose] < 0:
                    at_most = (1 + CLOSE) * seconds / least[open_items[whose]]
                    if (at_most * factor[whose] if len(factor) else at_most) <= rate * items:
                        continue
                    look_at(line, order, sku_of, quantity, share, untaken, factor, left, power, weights)
                w[number] = seconds / power[whose]
                if items <= other:
                    w[number] *= weights.elsewhere
                q[number] = items
                number += 1
        end[sku] = number
    return w, q, start, end


@njit(cache=True)
def gains(p, station, rate, w, q, start, end, pods, shelves):  # type: ignore[no-untyped-def]
    """Return what each pod brings beyond a rate."""
    values = np.zeros(len(pods))
    first_with, by_sku, pod_of, held_items, here = shelves.first_with, shelves.by_sku, shelves.pod, p.items, p.available
    for sku in p.wanted:
        whole, items = 0.0, 0
        for k in range(start[sku], end[sku]):
            gain = w[k] - rate * q[k]
            if gain > 0:
                whole += gain
                items += q[k]
        if items:
            for e in range(first_with[sku], first_with[sku + 1]):
                pod, held = pod_of[by_sku[e]], held_items[by_sku[e]]
                if held > 0 and pods[pod]:
                    held += here[station, sku]
                    if items <= held:
                        values[pod] += whole
                    else:
                        for k in brought(held, rate, w, q, start[sku], end[sku]):
                            values[pod] += w[k] - rate * q[k]
    return values


@njit(cache=True)
def ratio(p, station, pod, rate, w, q, start, end, shelves, weights):  # type: ignore[no-untyped-def]
    """Worth to seconds of the lines that a pod would bring and that are worth more than a rate."""
    total, time_s = 0.0, weights.visit_s
    for entry in range(shelves.first[pod], shelves.first[pod + 1]):
        sku = shelves.sku[entry]
        if p.items[entry] > 0 and end[sku] > start[sku]:
            held = p.items[entry] + p.available[station, sku]
            for k in brought(held, rate, w, q, start[sku], end[sku]):
                total += w[k]
                time_s += weights.handle_s * q[k]
    return total / time_s


@njit(cache=True)
def brought(held, rate, w, q, start, end):  # type: ignore[no-untyped-def]
    """Return the lines of a SKU that so many items bring, the largest gains first."""
    gain = w[start:end] - rate * q[start:end]
    chosen = np.empty(end - start, np.int64)
    number = 0
    for k in np.argsort(-gain, kind="mergesort"):
        if gain[k] <= 0:
            break
        if q[start + k] <= held:
            chosen[number] = start + k
            number += 1
            held -= q[start + k]
    return chosen[:number]
