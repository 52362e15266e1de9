"""A good solution at once: few pods that complete much, improved by exchanging pods.

`station_by_station` fills one station after the other with whole orders: a solution of all three models. It does not
look at how many items a pod has: `rmfs_rules.mip.proof.proof.Proof.offer` does.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rmfs_rules.mip.period.effort import Effort
from rmfs_rules.mip.period.reduction import Reduced, highest, sums_of
from rmfs_rules.mip.period.solution import Assigned, Part
from rmfs_rules.mip.proof.feasible import subset

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

STEPS_PER_PAIR = 0.1
"""Effort of a pair of a pod and a line that it may serve, each time that all pods are compared."""
STEPS_PER_COMPARISON = 60
"""Further effort of a comparison."""
STARTS = 12
"""How many pods a set is begun with, one after the other."""
ROUNDS = 3
"""How often each pod of a set, and each station, is looked at again."""


class Completing:
    """Orders that pods complete, by the pairs of a pod and a line whose SKU it has.

    Pods, SKUs and orders have numbers of their own here: only what matters for lines that can be assigned.

    Parameters
    ----------
    reduced
        The period.
    effort
        Limit of the work for improving.

    Attributes
    ----------
    pods, skus, orders
        Numbered things, ascending: positions of pods, SKU ids, positions of orders.
    sizes
        Items of each order.
    open
        Whether each order is still to be had.
    """

    def __init__(self, reduced: Reduced, effort: Effort) -> None:
        self.reduced, self.effort = reduced, effort
        period, kept = reduced.period, reduced.candidates
        self.skus, self.line_sku = np.unique(period.line_sku[kept], return_inverse=True)
        self.orders, self.line_order = np.unique(period.line_order[kept], return_inverse=True)
        quantity = period.line_quantity[kept].astype(np.float64)
        self.sizes = np.bincount(self.line_order, weights=quantity, minlength=len(self.orders)).astype(np.int64)
        self.open = np.ones(len(self.orders), dtype=np.bool_)
        number_of = np.full(period.stock.n_skus, -1)
        number_of[self.skus] = np.arange(len(self.skus))
        pod, sku = period.stock.pod, period.stock.sku
        wanted = number_of[sku] >= 0
        self.pods, pod = np.unique(pod[wanted], return_inverse=True)
        sku = number_of[sku[wanted]]
        self.holds = np.zeros((len(self.pods), len(self.skus)), dtype=np.bool_)
        self.holds[pod, sku] = True
        by_sku = np.argsort(self.line_sku, kind="stable")
        first = np.searchsorted(self.line_sku[by_sku], sku)
        number = np.searchsorted(self.line_sku[by_sku], sku, side="right") - first
        entry = np.repeat(np.arange(len(sku)), number)
        line = by_sku[np.repeat(first - np.cumsum(number) + number, number) + np.arange(len(entry))]
        key = pod[entry] * max(len(self.orders), 1) + self.line_order[line]
        by_key = np.argsort(key, kind="stable")
        self.pair_sku = self.line_sku[line[by_key]]
        keys, self.pair_group = np.unique(key[by_key], return_inverse=True)
        self.group_pod, self.group_order = np.divmod(keys, max(len(self.orders), 1))
        self.preferred = period.preferred.pods[self.pods]
        self.steps = STEPS_PER_COMPARISON + STEPS_PER_PAIR * len(self.pair_group)

    def missing(self, there: Bools) -> Integers:
        """Return how many lines of each order have an SKU that is not there."""
        return np.bincount(self.line_order[~there[self.line_sku]], minlength=len(self.orders))

    def complete(self, there: Bools) -> Integers:
        """Return the open orders whose SKUs are all there."""
        return np.flatnonzero(self.open & (self.missing(there) == 0))

    def gains(self, there: Bools, missing: Integers) -> tuple[Floats, Floats]:
        """Return what each pod completes, in items, and how far it brings open orders.

        An order of which it brings c of the m SKUs that are missing counts ``(c / m) ** 2`` of its items there.
        """
        brought = np.bincount(self.pair_group, weights=~there[self.pair_sku], minlength=len(self.group_pod))
        share = brought / np.maximum(missing, 1)[self.group_order]
        items = np.where(self.open, self.sizes, 0)[self.group_order]
        done = np.bincount(self.group_pod, weights=items * (share >= 1.0), minlength=len(self.pods))
        closer = np.bincount(self.group_pod, weights=items * share * share, minlength=len(self.pods))
        return done.astype(np.float64, copy=False), closer.astype(np.float64, copy=False)

    def _affordable(self) -> bool:
        if not self.effort.allows(self.steps):
            return False
        self.effort.take(self.steps)
        return True

    def fewest(self, there: Bools, room: int) -> int:
        """Return a number of pods without which no open order that fits the free slots becomes complete."""
        missing = self.missing(there)
        brought = np.bincount(self.pair_group, weights=~there[self.pair_sku], minlength=len(self.group_pod))
        by_order = np.lexsort((-brought, self.group_order))
        order = self.group_order[by_order]
        first = np.searchsorted(order, np.arange(len(self.orders)))
        brought = brought[by_order]
        sums = np.cumsum(brought)
        before = (sums - brought)[first[order]] if len(order) else sums
        enough = sums - before >= missing[order]
        fits = self.open & (missing > 0) & (self.sizes <= room)
        slots = np.flatnonzero(enough & fits[order])
        return int((slots - first[order[slots]]).min()) + 1 if len(slots) else len(self.pods) + 1

    def pods_for(self, there: Bools, number: int, room: int, able: Bools) -> list[int]:
        """Return so many pods that complete many open orders, no more than fill the slots: the best of several tries.

        Each try begins with another of the pods that may be sent (``able``) and bring orders furthest alone.
        """
        if not number:
            return []
        _, closer = self.gains(there, self.missing(there))
        first = np.lexsort((-self.preferred, -np.round(np.where(able, closer, -1.0), 6)))
        best: tuple[int, list[int]] = (-1, [])
        for pod in first[: STARTS if number > 1 else 1].tolist():
            if closer[pod] <= 0 or (best[1] and not self._affordable()):
                break
            sent = self._from(pod, there, number, room, able)
            filled = self.filled(self.with_pods(there, sent), room)
            if len(sent) == number and filled > best[0]:
                best = filled, sent
            if filled >= room:
                break
        return best[1]

    def _from(self, first: int, there: Bools, number: int, room: int, able: Bools) -> list[int]:
        """Return so many pods: a first one, others added one by one, and each exchanged as long as that helps."""
        chosen = [first]
        while len(chosen) < number:
            pod = self._best(self.with_pods(there, chosen), room, able, chosen)
            if pod < 0:
                return chosen
            chosen.append(pod)
        for _ in range(ROUNDS if len(chosen) > 1 else 0):
            before = chosen[:]
            for place in range(len(chosen)):
                if self.filled(self.with_pods(there, chosen), room) >= room or not self._affordable():
                    return chosen
                others = chosen[:place] + chosen[place + 1 :]
                chosen[place] = self._best(self.with_pods(there, others), room, able, others)
            if chosen == before:
                break
        return chosen

    def with_pods(self, there: Bools, pods: Sequence[int]) -> Bools:
        """Return the SKUs that are there with these pods."""
        return there | self.holds[pods].any(axis=0) if pods else there

    def _best(self, there: Bools, room: int, able: Bools, chosen: Sequence[int]) -> int:
        """Return the pod that completes most in the slots, then brings orders furthest; -1 if none brings any."""
        missing = self.missing(there)
        done, closer = self.gains(there, missing)
        filled = np.minimum(done + float(self.sizes[self.open & (missing == 0)].sum()), room)
        worth = np.where(able, filled + closer, -1.0)
        worth[chosen] = -1.0
        worth = np.round(worth, 6)
        most = np.flatnonzero(worth == worth.max())
        best = int(most[self.preferred[most].argmax()])
        return best if worth[best] > 0 and closer[best] > 0 else -1

    def filled(self, there: Bools, room: int) -> int:
        """Return how many items of complete orders fit the free slots."""
        return highest(sums_of(self.sizes[self.complete(there)].tolist(), room), room)

    def fillable(self, room: int) -> int:
        """Return how many items of open orders fit the free slots, with all pods there."""
        return highest(sums_of(self.sizes[self.open].tolist(), room), room)


def station_by_station(reduced: Reduced, weight: float, effort: Effort) -> Assigned:
    """Return new visits and whole orders: for each station the pods that fill it best, with what the others left.

    Parameters
    ----------
    reduced
        The period, for the integrated model.
    weight
        W_u.
    effort
        Limit of the work for improving.
    """
    period = reduced.period
    completing = Completing(reduced, effort)
    pods: list[list[int]] = [[] for _ in period.capacities]
    taken: list[list[int]] = [[] for _ in period.capacities]
    costs = [weight * room for room in period.capacities]
    for again in range(ROUNDS):
        improved = False
        for station, room in enumerate(period.capacities):
            if again and not effort.allows(completing.steps):
                break
            completing.open[taken[station]] = True
            cost, sent, orders = _fill_station(completing, station, room, weight, costs[station])
            if cost < costs[station]:
                costs[station], pods[station], taken[station], improved = cost, sent, orders, True
            completing.open[taken[station]] = False
        if not improved:
            break
    parts = [
        Part(order, station, tuple(sku for sku, _ in period.lines_of(order)))
        for station, orders in enumerate(taken)
        for order in completing.orders[orders].tolist()
    ]
    return tuple((pod, station) for station, sent in enumerate(pods) for pod in sent), tuple(parts)


def _fill_station(
    completing: Completing, station: int, room: int, weight: float, most: float
) -> tuple[float, list[int], list[int]]:
    """Return the least cost below ``most`` found for one station, its new pods and its orders."""
    period = completing.reduced.period
    able = ~np.isin(completing.pods, period.inbound[station])
    there = period.covered[station, completing.skus]
    best: tuple[float, list[int], list[int]] = (most, [], [])
    number, fewest = 0, completing.fewest(there, room)
    least = weight * (room - completing.fillable(room))
    while number + least < best[0]:
        sent = completing.pods_for(there, number, room, able)
        if len(sent) < number:
            break
        complete = completing.complete(completing.with_pods(there, sent))
        complete = complete[completing.sizes[complete] <= room]
        complete = complete[np.argsort(-completing.sizes[complete], kind="stable")]  # small ones are of use elsewhere
        sizes = completing.sizes[complete].tolist()
        chosen = subset(sizes, room)
        cost = number + weight * (room - sum(sizes[place] for place in chosen))
        if cost < best[0]:
            best = cost, completing.pods[sent].tolist(), complete[chosen].tolist()
        number = max(number + 1, fewest)
    return best
