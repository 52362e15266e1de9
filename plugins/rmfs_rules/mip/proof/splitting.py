"""New visits where few orders may be split over time (18): found by exchanging pods, filled by a program of their own.

Nothing here bounds the optimum; where as many visits fill all slots as the bound says, they prove it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rmfs_rules.mip.period.effort import Effort
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Visits

ORDERS_PER_STEP = 5
"""Orders that a step of the effort looks at for one pod."""

Table = NDArray[np.float64]  # whole numbers; products of these are far faster


def visits_for_few_splits(reduced: Reduced, number: int, splits: int, effort: Effort) -> Visits | None:
    """Return new visits with which all slots may be filled though few orders are split; None if none are found.

    The visits are shared out over the stations. Each in turn gets the pod with the highest estimate, until none gets a
    better one. The estimate counts the items of orders that some station covers, for each station no more than it has
    slots for, and of the others the items that all stations cover together, those of the best ``splits`` orders.

    Parameters
    ----------
    reduced
        The period.
    number
        How many visits.
    splits
        How many orders may newly be split.
    effort
        Rest of the period's effort; the search takes from it.
    """
    orders, rooms = _Orders(reduced), np.array(reduced.capacities)
    stations = [visit % len(rooms) for visit in range(number)]
    sent: list[int | None] = [None] * number
    best, steps = -1.0, len(orders.holds) * number * len(orders.items) // ORDERS_PER_STEP
    while effort.allows(steps):
        effort.take(steps)
        before = best
        for visit, station in enumerate(stations):
            covered = reduced.period.covered.copy()
            for other, chosen in enumerate(sent):
                if chosen is not None and other != visit:
                    covered[stations[other]] |= orders.holds[chosen] > 0
            estimates = orders.estimates(covered, station, rooms, splits)
            if estimates.max() > best or sent[visit] is None:
                best, sent[visit] = float(estimates.max()), int(estimates.argmax())
        if best == before:
            if best < reduced.reachable_sum:
                return None
            return tuple((pod, station) for pod, station in zip(sent, stations, strict=True) if pod is not None)
    return None


class _Orders:
    """Items of the orders of a period, their sizes, and which SKUs the pods hold.

    Parameters
    ----------
    reduced
        The period.
    """

    def __init__(self, reduced: Reduced) -> None:
        period, lines = reduced.period, reduced.candidates
        items = np.zeros((len(period.orders), period.stock.n_skus))
        np.add.at(items, (period.line_order[lines], period.line_sku[lines]), period.line_quantity[lines])
        sizes = np.zeros(len(items))
        np.add.at(sizes, period.line_order, period.line_quantity)  # with lines that cannot be assigned
        some = items.any(axis=1)
        self.items, self.sizes = items[some], sizes[some]
        self.holds = period.stock.holds

    def estimates(self, covered: NDArray[np.bool_], station: int, rooms: NDArray[np.int64], splits: int) -> Table:
        """Return the estimate with each pod at the station besides what is covered (stations x SKUs)."""
        sizes = self.sizes
        whole = self.items @ covered.T == sizes[:, None]  # orders x stations
        elsewhere = np.delete(whole, station, axis=1)
        filled = np.minimum(sizes @ elsewhere, np.delete(rooms, station)).sum()
        here = self._with_each(covered[station]) == sizes[:, None]  # orders x pods
        somewhere = here | elsewhere.any(axis=1)[:, None]
        parts = np.where(somewhere, 0, self._with_each(np.logical_or.reduce(covered)))
        split = np.sort(parts, axis=0)[len(parts) - min(splits, len(parts)) :].sum(axis=0)
        estimates: Table = np.minimum(filled + np.minimum(sizes @ here, rooms[station]), sizes @ somewhere) + split
        return estimates

    def _with_each(self, covered: NDArray[np.bool_]) -> Table:
        """Return the items of each order that each pod covers together with what is covered."""
        counts: Table = (self.items @ covered)[:, None] + np.where(covered, 0, self.items) @ self.holds.T
        return counts
