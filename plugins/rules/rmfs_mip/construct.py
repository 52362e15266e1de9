"""A first solution with whole orders: pods are added for the orders that need the fewest of them.

It is feasible for all three models, and never empty while some order fits some station.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rmfs_mip.reduction import Reduced

Visits = tuple[tuple[int, int], ...]


def whole_order_visits(reduced: Reduced, weight: float) -> Visits:
    """Return new visits for whole orders, found greedily.

    Again and again, the order and station are taken that save most: W_u for each item, less the pods that have to come.
    Among equals, the order with the fewest missing SKUs, then the oldest.
    """
    period = reduced.period
    rooms = list(period.capacities)
    covered = period.covered.copy()
    types = {order: kind for kind in reduced.types for order in kind.orders}
    wanted = np.zeros((len(period.orders), period.stock.n_skus), dtype=np.bool_)
    for order, kind in types.items():
        wanted[order, [sku for sku, _ in kind.lines]] = True
    sizes = np.array([types[o].size if o in types else 0 for o in range(len(period.orders))])
    left = sizes > 0
    visits: list[tuple[int, int]] = []
    preferred = period.preferred.pods.copy()
    while True:
        station, order = _best(wanted, covered, sizes, left, rooms, weight)
        if order < 0:
            return tuple(visits)
        missing = wanted[order] & ~covered[station]
        while missing.any():
            demand = period.stock.holds @ (wanted[left].sum(axis=0) * ~covered[station])
            brings = period.stock.holds @ missing
            pod = int(np.lexsort((-demand, -preferred, -brings))[0])
            visits.append((pod, station))
            if period.preferred.once_sent is not None:
                preferred[pod] = period.preferred.once_sent
            covered[station] |= period.stock.holds[pod] > 0
            missing &= ~covered[station]
        left[order] = False
        rooms[station] -= int(sizes[order])


def _best(
    wanted: NDArray[np.bool_],
    covered: NDArray[np.bool_],
    sizes: NDArray[np.int64],
    left: NDArray[np.bool_],
    rooms: list[int],
    weight: float,
) -> tuple[int, int]:
    """Return station and order that save most, or (-1, -1) when none fits or pays."""
    best, found = (0.0, float("-inf")), (-1, -1)
    for station, room in enumerate(rooms):
        fits = np.flatnonzero(left & (sizes <= room))
        if len(fits):
            missing = (wanted[fits] & ~covered[station]).sum(axis=1)
            saved = (weight * sizes[fits] - missing) / sizes[fits]
            at = int(np.lexsort((missing, -saved))[0])
            if (saved[at], -missing[at]) > best:
                best, found = (float(saved[at]), -float(missing[at])), (station, int(fits[at]))
    return found
