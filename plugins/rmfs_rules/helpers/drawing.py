"""Lots without a look at the whole backlog: a few orders are drawn first, and go before all others that are alike.

Most often one of those that are drawn is among the best, and no other need be looked at. The draw knows nothing of the
orders: of any that are equally good, each is as likely as any other to go first.
"""

from __future__ import annotations

import numpy as np

from rmfs_core.jit import njit
from rmfs_rules.helpers.pair_search import ITEMS, OPEN, SIZE, SLOT, fits, lot, refresh_size, value_of

DRAWS = 256
"""How often an order is drawn."""
OTHER = 0x632BE59BD9B4E019
"""What makes another key of that of the lots."""


@njit(cache=True)
def draws(key, first, end):
    """Draw ids of orders from the first to before the end, some perhaps twice; the earlier one goes first."""
    drawn = np.empty(DRAWS, np.int64)
    for turn in range(DRAWS):
        drawn[turn] = first + np.int64(lot(np.uint64(key) ^ np.uint64(OTHER), turn) * (end - first))
    return drawn


@njit(cache=True)
def first_drawn(
    drawn, than, at, extra, largest, lanes, taken, blocks,
    shelves, most, pool, orders, scores, best, known, now, changes, seen, recent,
):  # fmt: skip
    """Place of the first drawn order that is as good as the best one, and its station; (-1, -1) if none is.

    Where late orders go first, none that is not late is as good as one that is. ``than`` has the best
    order and its station; the others are as `pair_search.best_pair` has them.
    """
    room, free, capacity, counts, load = at
    value = value_of(than[1], orders[SLOT, than[0]], than[0], orders, scores) + extra[than[1]]
    for order in drawn:
        if taken[order] or not orders[OPEN, order]:
            continue
        found, items, size = -1, orders[ITEMS, order], orders[SIZE, order]
        for station in range(len(room)):
            if found >= 0 and load[station] >= load[found]:
                continue
            fitting = fits(items, room[station], capacity[station], counts[station], largest)
            if not fitting and fits(items, free[station], capacity[station], counts[station], largest):
                for pair in range(lanes.shape[1]):
                    fitting |= lanes[0, pair] == station and lanes[1, pair] == order
            if fitting:
                refresh_size(
                    station, size, blocks, shelves, most, pool, orders, scores, best, known, now, changes, seen, recent
                )
                if value_of(station, orders[SLOT, order], order, orders, scores) + extra[station] == value:
                    found = station
        if found >= 0:
            return order, np.int64(found)
    return np.int64(-1), np.int64(-1)
