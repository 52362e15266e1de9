"""Which pods have the largest index for a station, compiled."""

from __future__ import annotations

import numpy as np

from rmfs_core.jit import njit
from rmfs_core.warehouse import Stock
from rmfs_rules.pod_index.period import CLOSE, NONE, Bids, Bools, Floats, Ints, Period, fits, worth_of

TINY = 1e-12
"""Largest rounding error of sums of gains that are zero."""


@njit(cache=True, interpreted=True)
def best_pods(p: Period, station: int, bound: float) -> Ints:
    """Return the able pods of the largest index for a station, if that is above ``bound``: all equals.

    For a station that no pod is at or bound for also those whose index is less by up to the share ``near``.

    The index of a pod is the largest ratio of worth to seconds, ``sum of w / (visit_s + handle_s * items)``, over the
    sets of lines that it would bring. That ratio is above r when the lines' ``w - r * handle_s * items``, those that
    are positive, add up to more than ``r * visit_s``: there each line decides for itself whether it is in the set. So r
    rises from the bound to the ratio of a better pod until no pod is better (Dinkelbach's method), at O(lines +
    contents) a step.
    """
    weights, pods = p.weights, p.pods
    find_bids(p, station, bound * weights.handle_s * (1 - 2 * CLOSE))
    index, better = bound, NONE
    while True:
        find_gains(p, station, index * weights.handle_s)
        best = NONE
        for pod in pods.urgent:
            if pods.gain[pod] > 0 and (best == NONE or pods.gain[pod] > pods.gain[best]):
                best = pod
        if best == NONE or pods.gain[best] <= index * weights.visit_s * (1 + CLOSE) + TINY:
            break
        better = best
        index = ratio(p, station, best, index * weights.handle_s)
    if better == NONE:
        return pods.urgent[:0]
    less = CLOSE if p.stations[station]["inbound"] else max(CLOSE, weights.near)
    index = max(index * (1 - less), bound * (1 - 2 * CLOSE))  # below that, lines were left out
    find_gains(p, station, index * weights.handle_s)
    return pods.urgent[pods.gain[pods.urgent] > index * weights.visit_s]


@njit(cache=True, interpreted=True)
def find_within(wanted: Ints, stock: Stock, movable: Bools) -> tuple[Ints, Ints]:
    """Return `Bids.within` and `Bids.bearers`."""
    within, bearers, number, n_skus = np.empty((len(wanted), 3), np.int64), np.empty_like(stock.by_sku), 0, 0
    for sku in wanted:
        begin = number
        for k in range(stock.of_sku[sku], stock.of_sku[sku + 1]):
            entry = stock.by_sku[k]
            if stock.items[entry] > 0 and movable[stock.pod[entry]]:
                bearers[number] = entry
                number += 1
        if number > begin:
            within[n_skus, 0], within[n_skus, 1], within[n_skus, 2] = sku, begin, number
            n_skus += 1
    return within[:n_skus], bearers[:number]


@njit(cache=True, interpreted=True)
def find_bids(p: Period, station: int, rate: float) -> None:
    """Fill in ``bids`` with the lines that a station does not cover and that may be worth more than a rate."""
    lines, bids, handle_s, number = p.lines, p.bids, p.weights.handle_s, 0
    for i in range(len(bids.within)):
        sku = bids.within[i, 0]
        bids.first[sku], here, share, other = number, p.available[sku, station], p.share[sku], 0
        for another in range(p.available.shape[1]):
            if another != station:
                other = max(other, p.available[sku, another])
        for at in range(lines.first[sku], lines.first[sku] + lines.number[sku]):
            quantity, order = p.items[at], lines.listed_order[at]
            if quantity > here and quantity and fits(p, order, quantity, station):
                seconds = handle_s * quantity + share
                w = worth_of(p, order, seconds, share, rate * quantity)
                if w >= 0:
                    bids.worth[number] = w * p.weights.elsewhere if quantity <= other else w
                    bids.items[number] = quantity
                    number += 1
        bids.end[sku] = number


@njit(cache=True, interpreted=True)
def find_gains(p: Period, station: int, rate: float) -> None:
    """Fill in what each able pod brings beyond a rate."""
    bids, gains, able, of_pod, free = p.bids, p.pods.gain, p.pods.able, p.stock.pod, p.stock.items
    for pod in p.pods.urgent:
        gains[pod] = 0.0
    for i in range(len(bids.within)):
        sku, begin, end = bids.within[i, 0], bids.within[i, 1], bids.within[i, 2]
        whole, items = 0.0, 0
        for k in range(bids.first[sku], bids.end[sku]):
            gain = bids.worth[k] - rate * bids.items[k]
            if gain > 0:
                whole += gain
                items += bids.items[k]
        if items:
            ranked = bids.bearers[:0]
            for entry in bids.bearers[begin:end]:
                if able[of_pod[entry]]:
                    held = free[entry] + p.available[sku, station]
                    if items <= held:
                        gains[of_pod[entry]] += whole
                        continue
                    if not len(ranked):
                        ranked = by_gain(bids, sku, rate)
                    for k in ranked:
                        if bids.items[k] <= held:
                            gains[of_pod[entry]] += bids.worth[k] - rate * bids.items[k]
                            held -= bids.items[k]


@njit(cache=True, interpreted=True)
def by_gain(bids: Bids, sku: int, rate: float) -> Ints:
    """Return the lines of a SKU that gain more than a rate, the largest gains first."""
    first, end = bids.first[sku], bids.end[sku]
    gain: Floats = bids.worth[first:end] - rate * bids.items[first:end]
    ranked = np.argsort(-gain, kind="mergesort")
    return first + ranked[: (gain > 0).sum()]  # type: ignore[no-any-return]


@njit(cache=True, interpreted=True)
def ratio(p: Period, station: int, pod: int, rate: float) -> float:
    """Return worth to seconds of the lines that a pod would bring and that are worth more than a rate."""
    bids, total, time_s = p.bids, 0.0, p.weights.visit_s
    for entry in range(p.stock.of_pod[pod], p.stock.of_pod[pod + 1]):
        sku = p.stock.sku[entry]
        if p.stock.items[entry] > 0 and bids.end[sku] > bids.first[sku]:
            held = p.stock.items[entry] + p.available[sku, station]
            for k in by_gain(bids, sku, rate):
                if bids.items[k] <= held:
                    total += bids.worth[k]
                    time_s += p.weights.handle_s * bids.items[k]
                    held -= bids.items[k]
    return total / time_s
