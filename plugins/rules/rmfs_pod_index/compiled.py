"""What the lines of a period are worth, and which pod is best; compiled."""

from __future__ import annotations

from math import exp

import numpy as np
from numba import njit

from rmfs_core.clock import TICKS_PER_S
from rmfs_pod_index.period import CLOSE, FOUND, GAINING, LOOKED, NONE, NOW, PACKING_ROOM, WANTED

TINY = 1e-12
"""What sums of gains that are zero may come out as."""


@njit(cache=True)
def bring(p, pod, station, sign, shelves):  # type: ignore[no-untyped-def]
    """Add a pod's free items to those of a station, or take them away."""
    for entry in range(shelves.first[pod], shelves.first[pod + 1]):
        p.available[shelves.sku[entry], station] += sign * p.items[entry]


@njit(cache=True)
def share_visits(p, shelves, cost_s):  # type: ignore[no-untyped-def]
    """Work out seconds of a visit for each line of a SKU that no pod at or bound for a station has; 0 for others."""
    for sku in p.wanted[: p.numbers[WANTED]]:
        here = False
        for station in range(p.available.shape[1]):
            here = here or p.available[sku, station] > 0
        most = 0
        if not here:
            for k in range(shelves.first_with[sku], shelves.first_with[sku + 1]):
                if p.items[shelves.by_sku[k]] > 0:
                    most = max(most, p.lines_of[shelves.pod[shelves.by_sku[k]]])
        p.share[sku] = cost_s / most if most > 0 else 0.0


@njit(cache=True)
def look_at(o, order, sku, quantity, share, untaken, now_s, weights):  # type: ignore[no-untyped-def]
    """Work out what the seconds of an order's lines are divided by for their worth; ``o``: what there is of orders."""
    begin, end, due_s, worth, left, base, root, power = o
    seconds, factor = 0.0, worth[order]
    for line in range(begin[order], end[order]):
        if untaken[line]:
            seconds += weights.handle_s * quantity[line] + share[sku[line]]
    if due_s[order] < np.inf:
        slack_s = max(due_s[order] - now_s, 0.0)
        factor = (1.0 + (weights.due_factor - 1.0) * exp(-slack_s / weights.due_s)) * worth[order]
    left[order] = seconds
    if seconds != base[order]:  # to raise to a power takes longer than all else
        base[order], root[order] = seconds, seconds**weights.finish
    power[order] = root[order] / factor


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
def better_line(p, station, sku, more_than, best, most, weights):  # type: ignore[no-untyped-def]
    """Best of a line and the lines of a SKU that a station covers: of the largest worth, the oldest of equals.

    Of lines that want more items of their SKU than ``more_than``.

    Returns
    -------
    The line, NONE for none, and its worth.
    """
    # Each name for what a period has is given outside of the loop: to look it up takes longer than what it does
    order, sku_of, quantity, untaken, after, power = p.order, p.sku, p.quantity, p.untaken, p.after, p.power
    left, open_items, highest, shares, looked = p.left, p.open_items, p.highest, p.share, p.looked
    least, top, now_s = p.least, len(p.least) - 1, p.numbers[NOW] / TICKS_PER_S
    orders = p.begin, p.end, p.due_s, p.worth, left, p.base, p.root, power
    n_looked = p.numbers[LOOKED]
    plain, room = not (weights.packing or p.counts_orders[station]), p.room[station]
    here, share, line = p.available[sku, station], p.share[sku], p.head[sku]
    while line != NONE:
        q = quantity[line]
        if (
            untaken[line]
            and more_than < q <= here
            and (q <= room if plain else fits(p, line, station, weights.packing))
        ):
            seconds, whose = weights.handle_s * q + share, order[line]
            if left[whose] < 0:
                if seconds * highest[whose] < most * least[min(int(weights.handle_s * open_items[whose] + share), top)]:
                    line = after[line]
                    continue
                look_at(orders, whose, sku_of, quantity, shares, untaken, now_s, weights)
                looked[n_looked] = whose
                n_looked += 1
            w = seconds / power[whose]
            if best == NONE or w > most or (w == most and line < best):
                best, most = line, w
        line = after[line]
    p.numbers[LOOKED] = n_looked
    return best, most


@njit(cache=True)
def best_covered(p, station, weights):  # type: ignore[no-untyped-def]
    """Line of the largest worth that the pods of a station cover, NONE for none, and its worth."""
    best, most = NONE, 0.0
    for sku in p.wanted[: p.numbers[WANTED]]:
        if p.available[sku, station] > 0:
            best, most = better_line(p, station, sku, 0, best, most, weights)
    return best, most


@njit(cache=True)
def best_pods(p, station, bound, shelves, weights):  # type: ignore[no-untyped-def]
    """Fill in ``found`` with the able pods of the largest index for a station, if that is above ``bound``: all equals.

    For a station that no pod is at or bound for also those whose index is less by up to the share ``near``.

    The index of a pod is the largest ratio of worth to seconds, ``sum of w / (visit_s + handle_s * items)``, over the
    sets of lines that it would bring. That ratio is above r when the lines' ``w - r * handle_s * items``, those that
    are positive, add up to more than ``r * visit_s``: there each line decides for itself whether it is in the set. So r
    rises from the bound to the ratio of a better pod until no pod is better (Dinkelbach's method), at O(lines +
    contents) a step.
    """
    p.numbers[FOUND] = 0
    find_wanted_there(p, station, bound * weights.handle_s * (1 - 2 * CLOSE), weights)
    index, better = bound, NONE
    while True:
        find_gains(p, station, index * weights.handle_s, shelves)
        best = NONE
        for pod in p.gaining[: p.numbers[GAINING]]:
            if best == NONE or p.values[pod] > p.values[best] or (p.values[pod] == p.values[best] and pod < best):
                best = pod
        if best == NONE or p.values[best] <= index * weights.visit_s * (1 + CLOSE) + TINY:
            break
        better = best
        index = ratio(p, station, best, index * weights.handle_s, shelves, weights)
    if better != NONE:
        less = CLOSE if p.inbound[station] else max(CLOSE, weights.near)
        index = max(index * (1 - less), bound * (1 - 2 * CLOSE))  # below that, lines were left out
        find_gains(p, station, index * weights.handle_s, shelves)
        for pod in p.gaining[: p.numbers[GAINING]]:
            if p.values[pod] > index * weights.visit_s:
                p.found[p.numbers[FOUND]] = pod
                p.numbers[FOUND] += 1


@njit(cache=True)
def find_wanted_there(p, station, rate, weights):  # type: ignore[no-untyped-def]
    """Fill in worth and items of the lines that a station does not cover, by SKU, and where those of each SKU are.

    Of lines that may be worth more than a rate.
    """
    order, sku_of, quantity, untaken, after, power = p.order, p.sku, p.quantity, p.untaken, p.after, p.power
    left, open_items, highest, shares, looked = p.left, p.open_items, p.highest, p.share, p.looked
    least, top, now_s = p.least, len(p.least) - 1, p.numbers[NOW] / TICKS_PER_S
    orders = p.begin, p.end, p.due_s, p.worth, left, p.base, p.root, power
    n_looked = p.numbers[LOOKED]
    plain, room = not (weights.packing or p.counts_orders[station]), p.room[station]
    w, q, number = p.w, p.q, 0
    for sku in p.wanted[: p.numbers[WANTED]]:
        p.start[sku] = number
        other, here, share = 0, p.available[sku, station], p.share[sku]
        for i in range(p.available.shape[1]):
            if i != station:
                other = max(other, p.available[sku, i])
        line = p.head[sku]
        while line != NONE:
            items = quantity[line]
            if untaken[line] and items > here and (items <= room if plain else fits(p, line, station, weights.packing)):
                seconds, whose = weights.handle_s * items + share, order[line]
                if left[whose] < 0:
                    if (
                        seconds * highest[whose]
                        < rate * items * least[min(int(weights.handle_s * open_items[whose] + share), top)]
                    ):
                        line = after[line]
                        continue
                    look_at(orders, whose, sku_of, quantity, shares, untaken, now_s, weights)
                    looked[n_looked] = whose
                    n_looked += 1
                w[number] = seconds / power[whose]
                if items <= other:
                    w[number] *= weights.elsewhere
                q[number] = items
                number += 1
            line = after[line]
        p.stop[sku] = number
    p.numbers[LOOKED] = n_looked


@njit(cache=True)
def find_gains(p, station, rate, shelves):  # type: ignore[no-untyped-def]
    """Fill in what each able pod brings beyond a rate, and list those that bring anything."""
    w, q, values, gaining, able, held_items = p.w, p.q, p.values, p.gaining, p.able, p.items
    first_with, by_sku, pod_of = shelves.first_with, shelves.by_sku, shelves.pod
    for pod in gaining[: p.numbers[GAINING]]:
        values[pod] = 0.0
    number = 0
    for sku in p.wanted[: p.numbers[WANTED]]:
        whole, items = 0.0, 0
        for k in range(p.start[sku], p.stop[sku]):
            gain = w[k] - rate * q[k]
            if gain > 0:
                whole += gain
                items += q[k]
        if items:
            for e in range(first_with[sku], first_with[sku + 1]):
                pod, held = pod_of[by_sku[e]], held_items[by_sku[e]]
                if held > 0 and able[pod]:
                    before = values[pod]
                    held += p.available[sku, station]
                    if items <= held:
                        values[pod] += whole
                    else:
                        for k in brought(held, rate, w, q, p.start[sku], p.stop[sku]):
                            values[pod] += w[k] - rate * q[k]
                    if before == 0.0 and values[pod] > 0.0:
                        gaining[number] = pod
                        number += 1
    p.numbers[GAINING] = number


@njit(cache=True)
def ratio(p, station, pod, rate, shelves, weights):  # type: ignore[no-untyped-def]
    """Worth to seconds of the lines that a pod would bring and that are worth more than a rate."""
    total, time_s = 0.0, weights.visit_s
    for entry in range(shelves.first[pod], shelves.first[pod + 1]):
        sku = shelves.sku[entry]
        if p.items[entry] > 0 and p.number[sku] and p.stop[sku] > p.start[sku]:
            held, k = p.items[entry] + p.available[sku, station], p.start[sku]
            if p.stop[sku] == k + 1:
                if p.q[k] <= held and p.w[k] > rate * p.q[k]:
                    total += p.w[k]
                    time_s += weights.handle_s * p.q[k]
                continue
            for k in brought(held, rate, p.w, p.q, p.start[sku], p.stop[sku]):
                total += p.w[k]
                time_s += weights.handle_s * p.q[k]
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
