"""Sets of k pods for one station, each with the best orders that it serves: the compiled part of pricing."""

from __future__ import annotations

import numpy as np
from numba import njit

from rmfs_mip.completing import SLIP, next_set, sets_of


@njit(cache=True)
def _knapsack(a, values, there, best):  # type: ignore[no-untyped-def]
    """Return the greatest sum of values of completed orders that fit into one station."""
    room = len(best) - 1
    best[:] = 0.0
    for order in range(len(a.order_start) - 1):
        complete, size = values[order] > 0, 0
        for line in range(a.order_start[order], a.order_start[order + 1]):
            complete &= there[a.line_sku[line]]
            size += a.line_items[line]
        if complete:
            for place in range(room, size - 1, -1):
                best[place] = max(best[place], best[place - size] + values[order])
    return best[room]


@njit(cache=True)
def best_sets(a, number, values, least, kept, work, most_work):  # type: ignore[no-untyped-def]
    """Return the worths of sets of ``number`` pods and the sets, in no order.

    These are the ``kept`` best of those worth at least ``least``. The worth of a set is the greatest sum of ``values``
    over orders that it completes and that fit into a station. The answer is complete only if ``work[0]`` stays within
    ``most_work``.
    """
    best = np.zeros(a.rooms[0] + 1)
    worths, sets, found = np.zeros(kept), np.zeros((kept, number), np.int64), 0
    search = sets_of(a, number, values, least)
    while next_set(a, search, work, most_work):
        work[0] += 1
        worth = _knapsack(a, values, search.there[number], best)
        if worth < search.least[0] - SLIP:
            continue
        place = int(worths.argmin()) if found == kept else found
        worths[place], sets[place] = worth, search.chosen
        found = min(found + 1, kept)
        if found == kept:
            search.least[0] = max(least, worths.min() + 2 * SLIP)  # what is kept is not replaced by equals
    return worths[:found], sets[:found]
