"""What the lines of a period are worth, and which pod is best; compiled."""

from __future__ import annotations

from math import exp

import numpy as np

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.jit import njit
from rmfs_rules.pod_index.period import CLOSE, FOUND, GAINING, LOOKED, NONE, NOW, PACKING_ROOM, WANTED, WITHIN

TINY = 1e-12
"""What sums of gains that are zero may come out as."""


@njit(cache=True)
def share_visits(p):
    """Work out seconds of a visit for each line of a SKU that no pod at or bound for a station has; 0 for others."""
    for sku in p.wanted[: p.numbers[WANTED]]:
        here = False
        for station in range(p.available.shape[1]):
            here = here or p.available[sku, station] > 0
        most = 0
        if not here:
            for k in range(p.first_with[sku], p.first_with[sku + 1]):
                if p.holders[k].free > 0:
                    most = max(most, p.ages[p.holders[k].pod].lines_of)
        p.skus[sku].share = p.weights[0].cost_s / most if most > 0 else 0.0


@njit(cache=True)
def look_at(p, order):
    """Work out what the seconds of an order's lines are divided by for their worth."""
    weights, o, seconds = p.weights[0], p.orders[order], 0.0
    factor = o.worth
    for line in p.lines[o.begin : o.end]:
        if line.untaken:
            seconds += weights.handle_s * line.quantity + p.skus[line.sku].share
    if o.due_s < np.inf:
        slack_s = max(o.due_s - p.numbers[NOW] / TICKS_PER_S, 0.0)
        factor = (1.0 + (weights.due_factor - 1.0) * exp(-slack_s / weights.due_s)) * o.worth
    o.left = seconds
    if seconds != o.base:  # to raise to a power takes longer than all else
        o.base, o.root = seconds, seconds**weights.finish
    o.power = o.root / factor


@njit(cache=True)
def fits(p, line, station):
    """Whether a line may be taken and fits the free places of a station."""
    if not p.lines[line].untaken:
        return False
    order = p.lines[line].order
    if p.weights[0].packing and not (p.orders[order].split or p.orders[order].single or p.numbers[PACKING_ROOM] > 0):
        return False
    if p.stations[station].counts_orders:
        return p.stations[station].room > 0 or p.placed[station, order]
    return p.lines[line].quantity <= p.stations[station].room


@njit(cache=True)
def better_line(p, station, sku, more_than, best, most):
    """Best of a line and the lines of a SKU that a station covers: of the largest worth, the oldest of equals.

    Of lines that want more items of their SKU than ``more_than``.

    Returns
    -------
    The line, NONE for none, and its worth.
    """
    weights = p.weights[0]
    # Each name for what a period has is given outside of the loop: to look it up takes longer than what it does
    lines, orders, looked, least, top = p.lines, p.orders, p.looked, p.least, len(p.least) - 1
    n_looked = p.numbers[LOOKED]
    plain, room = not (weights.packing or p.stations[station].counts_orders), p.stations[station].room
    here, share, line = p.available[sku, station], p.skus[sku].share, p.skus[sku].head
    while line != NONE:
        wants = lines[line]
        q = wants.quantity
        if wants.untaken and more_than < q <= here and (q <= room if plain else fits(p, line, station)):
            seconds, o = weights.handle_s * q + share, orders[wants.order]
            if o.left < 0:
                if seconds * o.highest < most * least[min(int(weights.handle_s * o.open_items + share), top)]:
                    line = wants.after
                    continue
                look_at(p, wants.order)
                looked[n_looked] = wants.order
                n_looked += 1
            w = seconds / o.power
            if best == NONE or w > most or (w == most and line < best):
                best, most = line, w
        line = wants.after
    p.numbers[LOOKED] = n_looked
    return best, most


@njit(cache=True)
def best_covered(p, station):
    """Line of the largest worth that the pods of a station cover, NONE for none, and its worth."""
    best, most = NONE, 0.0
    for sku in p.wanted[: p.numbers[WANTED]]:
        if p.available[sku, station] > 0:
            best, most = better_line(p, station, sku, 0, best, most)
    return best, most


@njit(cache=True)
def best_pods(p, station, bound):
    """Fill in ``found`` with the able pods of the largest index for a station, if that is above ``bound``: all equals.

    For a station that no pod is at or bound for also those whose index is less by up to the share ``near``.

    The index of a pod is the largest ratio of worth to seconds, ``sum of w / (visit_s + handle_s * items)``, over the
    sets of lines that it would bring. That ratio is above r when the lines' ``w - r * handle_s * items``, those that
    are positive, add up to more than ``r * visit_s``: there each line decides for itself whether it is in the set. So r
    rises from the bound to the ratio of a better pod until no pod is better (Dinkelbach's method), at O(lines +
    contents) a step.
    """
    weights = p.weights[0]
    p.numbers[FOUND] = 0
    find_wanted_there(p, station, bound * weights.handle_s * (1 - 2 * CLOSE))
    index, better = bound, NONE
    while True:
        find_gains(p, station, index * weights.handle_s)
        best = NONE
        for pod in p.gaining[: p.numbers[GAINING]]:
            if (
                best == NONE
                or p.pods[pod].gain > p.pods[best].gain
                or (p.pods[pod].gain == p.pods[best].gain and pod < best)
            ):
                best = pod
        if best == NONE or p.pods[best].gain <= index * weights.visit_s * (1 + CLOSE) + TINY:
            break
        better = best
        index = ratio(p, station, best, index * weights.handle_s)
    if better != NONE:
        less = CLOSE if p.stations[station].inbound else max(CLOSE, weights.near)
        index = max(index * (1 - less), bound * (1 - 2 * CLOSE))  # below that, lines were left out
        find_gains(p, station, index * weights.handle_s)
        for pod in p.gaining[: p.numbers[GAINING]]:
            if p.pods[pod].gain > index * weights.visit_s:
                p.found[p.numbers[FOUND]] = pod
                p.numbers[FOUND] += 1


@njit(cache=True)
def find_within(p):
    """List the SKUs with open lines of which movable pods have items, and these pods."""
    number, n_skus = 0, 0
    for sku in p.wanted[: p.numbers[WANTED]]:
        begin = number
        for holder in p.holders[p.first_with[sku] : p.first_with[sku + 1]]:
            if holder.free > 0 and p.pods[holder.pod].movable:
                p.bearers[number] = holder
                number += 1
        if number > begin:
            p.within[n_skus].sku, p.within[n_skus].begin, p.within[n_skus].end = sku, begin, number
            n_skus += 1
    p.numbers[WITHIN] = n_skus


@njit(cache=True)
def find_wanted_there(p, station, rate):
    """Fill in worth and items of the lines that a station does not cover, by SKU, and where those of each SKU are.

    Of lines that may be worth more than a rate, and that movable pods have items for.
    """
    weights = p.weights[0]
    lines, orders, looked, least, top = p.lines, p.orders, p.looked, p.least, len(p.least) - 1
    n_looked = p.numbers[LOOKED]
    plain, room = not (weights.packing or p.stations[station].counts_orders), p.stations[station].room
    bids, number = p.bids, 0
    for one in p.within[: p.numbers[WITHIN]]:
        sku = one.sku
        p.skus[sku].start = number
        other, here, share = NONE, p.available[sku, station], p.skus[sku].share
        line = p.skus[sku].head
        while line != NONE:
            wants = lines[line]
            q = wants.quantity
            if wants.untaken and q > here and (q <= room if plain else fits(p, line, station)):
                seconds, o = weights.handle_s * q + share, orders[wants.order]
                if o.left < 0:
                    worthless = rate * q * least[min(int(weights.handle_s * o.open_items + share), top)]
                    if seconds * o.highest < worthless:
                        line = wants.after
                        continue
                    look_at(p, wants.order)
                    looked[n_looked] = wants.order
                    n_looked += 1
                w = seconds / o.power
                if other == NONE:
                    other = 0
                    for i in range(p.available.shape[1]):
                        if i != station:
                            other = max(other, p.available[sku, i])
                bids[number].worth = w * weights.elsewhere if q <= other else w
                bids[number].items = q
                number += 1
            line = wants.after
        p.skus[sku].stop = number
    p.numbers[LOOKED] = n_looked


@njit(cache=True)
def find_gains(p, station, rate):
    """Fill in what each able pod brings beyond a rate, and list those that bring anything."""
    bids, pods, skus, gaining, bearers = p.bids, p.pods, p.skus, p.gaining, p.bearers
    for pod in gaining[: p.numbers[GAINING]]:
        pods[pod].gain = 0.0
    number = 0
    for one in p.within[: p.numbers[WITHIN]]:
        sku, whole, items = one.sku, 0.0, 0
        for k in range(skus[sku].start, skus[sku].stop):
            gain = bids[k].worth - rate * bids[k].items
            if gain > 0:
                whole += gain
                items += bids[k].items
        if items:
            for k in range(one.begin, one.end):
                pod = bearers[k].pod
                if pods[pod].able:
                    before, held = pods[pod].gain, bearers[k].free + p.available[sku, station]
                    if items <= held:
                        pods[pod].gain += whole
                    else:
                        for bid in brought(held, rate, bids, skus[sku].start, skus[sku].stop):
                            pods[pod].gain += bids[bid].worth - rate * bids[bid].items
                    if before == 0.0 and pods[pod].gain > 0.0:
                        gaining[number] = pod
                        number += 1
    p.numbers[GAINING] = number


@njit(cache=True)
def ratio(p, station, pod, rate):
    """Worth to seconds of the lines that a pod would bring and that are worth more than a rate."""
    weights = p.weights[0]
    total, time_s = 0.0, weights.visit_s
    for entry in range(p.first[pod], p.first[pod + 1]):
        sku = p.entries[entry].sku
        if p.entries[entry].free > 0 and p.skus[sku].number and p.skus[sku].stop > p.skus[sku].start:
            held, k = p.entries[entry].free + p.available[sku, station], p.skus[sku].start
            if p.skus[sku].stop == k + 1:
                if p.bids[k].items <= held and p.bids[k].worth > rate * p.bids[k].items:
                    total += p.bids[k].worth
                    time_s += weights.handle_s * p.bids[k].items
                continue
            for k in brought(held, rate, p.bids, p.skus[sku].start, p.skus[sku].stop):
                total += p.bids[k].worth
                time_s += weights.handle_s * p.bids[k].items
    return total / time_s


@njit(cache=True)
def brought(held, rate, bids, start, end):
    """Return the lines of a SKU that so many items bring, the largest gains first."""
    gain = np.array([bid.worth - rate * bid.items for bid in bids[start:end]])
    chosen = np.empty(end - start, np.int64)
    number = 0
    for k in np.argsort(-gain, kind="mergesort"):
        if gain[k] <= 0:
            break
        if bids[start + k].items <= held:
            chosen[number] = start + k
            number += 1
            held -= bids[start + k].items
    return chosen[:number]
