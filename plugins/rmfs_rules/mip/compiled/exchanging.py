"""Sets of pods that complete many orders, found by exchanging one pod after another: compiled, and quick.

A pod of the set gives way to another wherever the set then completes no less than before, or little less: threshold
accepting (Dueck and Scheuer 1990, https://doi.org/10.1016/0021-9991(90)90201-B), by less and less. All numbers are
whole, those drawn included, so the sets are the same on every machine.
"""

from __future__ import annotations

import numpy as np

from rmfs_core.jit import njit
from rmfs_rules.mip.compiled.pod_sets import complete, copied

THRESHOLD = 2
"""Items that a set may complete less than the one before, at first."""


@njit(cache=True)
def _drawn(state, numbers):
    """Return a number below ``numbers``, by a linear congruential generator."""
    state[0] = (state[0] * 1103515245 + 12345) & 0x7FFFFFFF
    return (state[0] >> 8) % numbers


@njit(cache=True)
def completed(a, pods, there):
    """Return the slots of the orders that these pods complete, with what is at hand; ``there`` is overwritten."""
    for sku in range(len(there)):
        there[sku] = a.at_hand[sku] > 0
    for pod in pods:
        for at in range(a.pod_start[pod], a.pod_start[pod + 1]):
            there[a.pod_sku[at]] = True
    items = 0
    for order in range(len(a.items)):
        if complete(a, order, there):
            items += a.items[order]
    return items


@njit(cache=True)
def exchanged(a, number, steps, seed):
    """Return the set of so many pods that completes most, of the sets tried, and the slots its orders take.

    Parameters
    ----------
    a
        The period (`compiled.arrays.Arrays`), with at least so many pods.
    number
        How many pods.
    steps
        How many exchanges are tried.
    seed
        Seed of the random numbers.
    """
    pods = len(a.pod_start) - 1
    there, state = np.zeros(len(a.at_hand), np.bool_), np.full(1, seed)
    chosen, best = np.arange(number), np.arange(number)
    items = most = completed(a, chosen, there)
    for step in range(steps if number else 0):
        place, pod = _drawn(state, number), _drawn(state, pods)
        worse = _drawn(state, THRESHOLD * (steps - step) // steps + 1)
        if (chosen == pod).any():
            continue
        before, chosen[place] = chosen[place], pod
        now = completed(a, chosen, there)
        if now < items - worse:
            chosen[place] = before
            continue
        items = now
        if items > most:
            most = items
            copied(chosen, best)
    return best, most
