"""Scores of lines and pods, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

NONE = -1
CLOSE = 1e-9
"""Relative difference up to which two indices count as equal: sums of the same numbers in another order may differ."""
TINY = 1e-12
"""What sums of gains that are zero may come out as."""


class Lines(NamedTuple):
    """Open lines of the backlog, oldest order first.

    Parameters
    ----------
    sku, quantity
        SKU id and items of each line.
    by_sku
        The lines, sorted by SKU.
    first
        Where in ``by_sku`` those of SKU i begin; those of the next one begin where they end.
    """

    sku: NDArray[np.int64]
    quantity: NDArray[np.int64]
    by_sku: NDArray[np.int64]
    first: NDArray[np.int64]


class Contents(NamedTuple):
    """What the pods hold.

    Parameters
    ----------
    first
        Where the entries of pod p begin; those of the next one begin where they end.
    sku, items
        SKU id and free items of each entry.
    """

    first: NDArray[np.int64]
    sku: NDArray[np.int64]
    items: NDArray[np.int64]


@njit(cache=True)
def line_costs(lines, pods, here, handle_s, cost_s):  # type: ignore[no-untyped-def]
    """Seconds of each line: handling, and a share of a visit where no pod at or bound for a station has its SKU."""
    most = np.zeros(len(lines.first) - 1, dtype=np.int64)
    for pod in range(len(pods.first) - 1):
        number = 0
        for entry in range(pods.first[pod], pods.first[pod + 1]):
            if pods.items[entry] > 0:
                number += lines.first[pods.sku[entry] + 1] - lines.first[pods.sku[entry]]
        for entry in range(pods.first[pod], pods.first[pod + 1]):
            if pods.items[entry] > 0:
                most[pods.sku[entry]] = max(most[pods.sku[entry]], number)
    cost = handle_s * lines.quantity
    for line in range(len(cost)):
        sku = lines.sku[line]
        if not here[sku] and most[sku] > 0:
            cost[line] += cost_s / most[sku]
    return cost


@njit(cache=True)
def best_covered(lines, worth, fits, available):  # type: ignore[no-untyped-def]
    """Line of the largest worth that the pods of a station cover, the oldest of equals; NONE where they cover none."""
    best = NONE
    for sku in range(len(available)):
        if available[sku] > 0:
            for k in range(lines.first[sku], lines.first[sku + 1]):
                line = lines.by_sku[k]
                better = best == NONE or worth[line] > worth[best] or (worth[line] == worth[best] and line < best)
                if better and fits[line] and lines.quantity[line] <= available[sku]:
                    best = line
    return best


@njit(cache=True)
def best_pods(bound, candidates, lines, worth, fits, pods, available, handle_s, visit_s):  # type: ignore[no-untyped-def]
    """Pods of the largest index for a station, if that is above ``bound``: all that are equal.

    The index of a pod is the largest ratio of worth to seconds, ``sum of w / (visit_s + handle_s * items)``, over the
    sets of lines that it would bring. That ratio is above r when the lines' ``w - r * handle_s * items``, those that
    are positive, add up to more than ``r * visit_s``: there each line decides for itself whether it is in the set. So r
    rises from the bound to the ratio of a better pod until no pod is better (Dinkelbach's method), at O(lines +
    contents) a step.
    """
    index, better = bound, candidates[:0]
    values = np.empty(len(candidates))
    while True:
        _values(index, values, candidates, lines, worth, fits, pods, available, handle_s)
        best = np.argmax(values) if len(values) else NONE
        if best == NONE or values[best] <= index * visit_s * (1 + CLOSE) + TINY:
            break
        better = candidates[best : best + 1]
        index = _ratio(better[0], index * handle_s, lines, worth, fits, pods, available, handle_s, visit_s)
    if len(better):
        index *= 1 - CLOSE
        _values(index, values, candidates, lines, worth, fits, pods, available, handle_s)
        better = candidates[values > index * visit_s]
    return better


@njit(cache=True)
def _values(index, values, candidates, lines, worth, fits, pods, available, handle_s):  # type: ignore[no-untyped-def]
    """Fill in what each candidate brings beyond an index for each second of handling."""
    rate = index * handle_s
    whole, wanted = _gains_by_sku(rate, lines, worth, fits, available)
    for k in range(len(candidates)):
        values[k] = _gain(candidates[k], rate, lines, worth, fits, pods, available, whole, wanted)


@njit(cache=True)
def _gains_by_sku(rate, lines, worth, fits, available):  # type: ignore[no-untyped-def]
    """What a pod with enough items of each SKU brings beyond a rate, and how many items that takes."""
    whole, wanted = np.zeros(len(available)), np.zeros(len(available), dtype=np.int64)
    for line in range(len(worth)):
        sku, quantity = lines.sku[line], lines.quantity[line]
        gain = worth[line] - rate * quantity
        if gain > 0 and fits[line] and quantity > available[sku]:
            whole[sku] += gain
            wanted[sku] += quantity
    return whole, wanted


@njit(cache=True)
def _gain(pod, rate, lines, worth, fits, pods, available, whole, wanted):  # type: ignore[no-untyped-def]
    """Sum of what the lines that a pod would bring are worth beyond a rate."""
    total = 0.0
    for entry in range(pods.first[pod], pods.first[pod + 1]):
        sku = pods.sku[entry]
        if pods.items[entry] > 0 and wanted[sku] > 0:
            items = pods.items[entry] + available[sku]
            if wanted[sku] <= items:
                total += whole[sku]
            else:
                for line in _brought(sku, items, rate, lines, worth, fits, available):
                    total += worth[line] - rate * lines.quantity[line]
    return total


@njit(cache=True)
def _ratio(pod, rate, lines, worth, fits, pods, available, handle_s, visit_s):  # type: ignore[no-untyped-def]
    """Worth to seconds of the lines that a pod would bring and that are worth more than a rate."""
    total, seconds = 0.0, visit_s
    for entry in range(pods.first[pod], pods.first[pod + 1]):
        sku = pods.sku[entry]
        if pods.items[entry] > 0:
            for line in _brought(sku, pods.items[entry] + available[sku], rate, lines, worth, fits, available):
                total += worth[line]
                seconds += handle_s * lines.quantity[line]
    return total / seconds


@njit(cache=True)
def _brought(sku, items, rate, lines, worth, fits, available):  # type: ignore[no-untyped-def]
    """Lines of a SKU that so many items bring, the largest gains first."""
    of_sku = lines.by_sku[lines.first[sku] : lines.first[sku + 1]]
    gains = worth[of_sku] - rate * lines.quantity[of_sku]
    chosen = np.empty(len(of_sku), dtype=np.int64)
    number = 0
    for k in np.argsort(-gains, kind="mergesort"):
        if gains[k] <= 0:
            break
        line = of_sku[k]
        if fits[line] and available[sku] < lines.quantity[line] <= items:
            chosen[number] = line
            number += 1
            items -= lines.quantity[line]
    return chosen[:number]


@njit(cache=True)
def urgent(candidates, lines, untaken, ages, pods, urge_s):  # type: ignore[no-untyped-def]
    """Which pods hold items of lines whose ages add up to so many seconds."""
    by_sku = np.zeros(len(lines.first) - 1)
    for line in range(len(ages)):
        if untaken[line]:
            by_sku[lines.sku[line]] += ages[line]
    enough = np.zeros(len(candidates), dtype=np.bool_)
    for k in range(len(candidates)):
        total = 0.0
        for entry in range(pods.first[candidates[k]], pods.first[candidates[k] + 1]):
            if pods.items[entry] > 0:
                total += by_sku[pods.sku[entry]]
        enough[k] = total >= urge_s
    return enough
