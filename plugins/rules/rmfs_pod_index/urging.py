"""Which pods are wanted enough to be sent, compiled: the ages of the lines that they have items for, added up."""

from __future__ import annotations

import numpy as np
from numba import njit

from rmfs_pod_index.period import AT_WORK, NONE, URGES


@njit(cache=True)
def needed(load, capacity, urge_ticks, full):  # type: ignore[no-untyped-def]
    """Ticks that ages add up to before a pod is sent to a station of which so many places are taken."""
    return int(urge_ticks * (1 + (full - 1) * min(load, capacity) / capacity))


@njit(cache=True)
def ages_of(sku, order, age, untaken, by_sku, first, enough):  # type: ignore[no-untyped-def]
    """Return the ages of the untaken lines of a SKU, added up, and their number; not much more than is enough."""
    ages, number = 0, 0
    for k in range(first[sku], first[sku + 1]):
        if untaken[by_sku[k]]:
            ages += age[order[by_sku[k]]]
            number += 1
            if ages >= enough:
                break
    return ages, number


@njit(cache=True)
def urges(lines, n_pods, shelves, items, enough):  # type: ignore[no-untyped-def]
    """Return the ages of the lines that each pod has items for, added up, and their number."""
    order, age, by_sku, first, wanted = lines
    untaken = np.ones(len(order), np.bool_)
    total, number = np.zeros(n_pods, np.int64), np.zeros(n_pods, np.int64)
    for sku in wanted:
        ages, n = ages_of(sku, order, age, untaken, by_sku, first, enough)
        for k in range(shelves.first_with[sku], shelves.first_with[sku + 1]):
            entry = shelves.by_sku[k]
            if items[entry] > 0:
                total[shelves.pod[entry]] += ages
                number[shelves.pod[entry]] += n
    return total, number


@njit(cache=True)
def next_urgent(total, number, passed, need):  # type: ignore[no-untyped-def]
    """Ticks until the ages of the lines of the next pod add up to so many, NONE for never; and whether one's do now.

    Ages have grown since they were added up.
    """
    soonest, urgent_now = NONE, False
    for pod in range(len(total)):
        missing = need - total[pod] - number[pod] * passed
        urgent_now = urgent_now or missing <= 0
        if number[pod] and missing > 0:
            ticks = -(-missing // number[pod])
            if soonest == NONE or ticks < soonest:
                soonest = ticks
    return soonest, urgent_now


@njit(cache=True)
def change_urges(p, sku, shelves, weights):  # type: ignore[no-untyped-def]
    """Work out anew what the lines of a SKU add to the pods that have it."""
    enough = needed(1, 1, weights.urge_ticks, weights.full)
    ages, _ = ages_of(sku, p.order, p.age, p.untaken, p.by_sku, p.first, enough)
    for k in range(shelves.first_with[sku], shelves.first_with[sku + 1]):
        entry = shelves.by_sku[k]
        if p.items[entry] > 0:
            p.urge[shelves.pod[entry]] += ages - p.ages[sku]
    p.ages[sku] = ages


@njit(cache=True)
def urgent(p, station, shelves, weights):  # type: ignore[no-untyped-def]
    """Which pods are wanted enough to be sent now: all of them where no station has anything to do."""
    if not (p.numbers[AT_WORK] and weights.urge_ticks):
        return p.movable
    if not p.numbers[URGES]:
        p.numbers[URGES] = 1
        p.ages[:] = 0
        for sku in p.wanted:
            change_urges(p, sku, shelves, weights)
    need = needed(p.load[station], p.capacity[station], weights.urge_ticks, weights.full)
    return p.movable & (p.urge >= need)
