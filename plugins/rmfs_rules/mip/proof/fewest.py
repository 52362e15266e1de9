"""The optimum by trying values of objective (1) from the bound upwards, for models that assign orders completely.

A value is v = k visits and W_u for each of u slots that stay free, which could be filled. Whether k visits fill all
but u of those slots is settled exactly by the compiled search for sets of pods (`compiled.pod_sets`), their
stations (`compiled.spreading`) and the orders (`compiled.stacking`): the first v for which they do is
the optimum. These leave aside that SKUs may be scarce; whether the pods found have enough is settled by a program for
their stations (`proof.aggregated.assigned_with`), and if not, the search goes on.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import prod
from typing import Any

import numpy as np
from attrs import define, field
from numpy.typing import NDArray

from rmfs_rules.mip.compiled import exchanging, pod_sets, spreading
from rmfs_rules.mip.compiled.arrays import LARGEST_ROOM, MOST_STATES, MOST_STATIONS, Arrays, arrays_of, price_of
from rmfs_rules.mip.period.placing import short_of
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Assigned, Model, Part, Visits
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.aggregated import assigned_with

WORK_OF_A_PROGRAM = 10_000
"""Steps that count for a program that says whether pods have enough: about as many as are done in its time."""
EXCHANGES, TRIES = 100_000, 2
"""Exchanges of a pod that are tried for sets of one size, and how often that begins anew."""
PRICE_OF_EXCHANGE = 0.0015
"""Effort of one, for each order."""
SHARE_OF_EXCHANGES = 20
"""The part of what is left of the effort that they may take each time."""
QUICK_WORK = 20_000
"""Steps of the search for the stations of a set of pods that was found by exchanging."""


@define
class FewestVisits:
    """Searches one period.

    Parameters
    ----------
    reduced
        The period, for one of the two models that assign orders completely.
    weight
        W_u, a whole number.
    most_work
        When to give up, in steps of the compiled searches.
    splits
        How many orders may newly be split; None for any number.
    limits
        Solver and limits.
    """

    reduced: Reduced
    weight: int
    most_work: int
    splits: int | None = None
    limits: Limits = field(factory=Limits)
    _work: NDArray[np.int64] = field(factory=lambda: np.zeros(1, dtype=np.int64), init=False)
    _arrays: Arrays = field(init=False)
    _pods: list[int] = field(init=False)
    _too_few: dict[int, int] = field(factory=dict, init=False)
    """Target to a number of pods that complete too little for it, wherever they go."""

    @property
    def possible(self) -> bool:
        """Whether the stations are few and small enough to tell all vectors of slots taken apart."""
        rooms = self.reduced.capacities
        states = prod(room + 1 for room in rooms)
        return len(rooms) <= MOST_STATIONS and max(rooms) <= LARGEST_ROOM and states <= MOST_STATES

    def run(self, lower: int, upper: int) -> tuple[int, Assigned | None]:
        """Return a lower bound on the value, and a solution with that value if there is one below ``upper``.

        Parameters
        ----------
        lower, upper
            Known bounds: no solution has a value below ``lower``, and one has ``upper``.
        """
        self._arrays, self._pods = arrays_of(self.reduced, self.splits)
        for value in range(lower, upper):
            for free in range(value // self.weight + 1):
                known, found = self._fills(value - free * self.weight, self.reduced.reachable_sum - free)
                if found is not None:
                    return value, found
                if not known:
                    return value, None
        return upper, None

    def quickly(self, lower: int, upper: int) -> Assigned | None:
        """Return a solution with a value from ``lower`` to below ``upper``, or None.

        It fills all slots that can be filled. Sets of pods, one smaller than the other as long as some are found, are
        found by exchanging pods; the stations that they go to by the exact search.
        """
        self._arrays, self._pods = arrays_of(self.reduced, self.splits)
        found = None
        for number in range(min(upper - 1, len(self._pods)), lower - 1, -1):
            better = self._exchanged(number, self.reduced.reachable_sum)
            if better is None:
                break
            found = better
        return found

    def _exchanged(self, number: int, target: int) -> Assigned | None:
        """Return a solution with one visit each of so many pods, which are found by exchanging them, or None."""
        price, effort = PRICE_OF_EXCHANGE * len(self.reduced.orders), self.limits.effort
        for seed in range(1, TRIES + 1):
            steps = int(min(EXCHANGES, effort.left / SHARE_OF_EXCHANGES / price))
            effort.take(steps * price)
            pods, items = exchanging.exchanged(self._arrays, number, steps, seed)
            if items >= target:
                pods, work = np.sort(pods), np.zeros(1, dtype=np.int64)
                price_of_step = price_of(self.reduced, len(self._pods), 1)
                most = effort.most(QUICK_WORK, price_of_step)
                found, masks, orders = spreading.spread(self._arrays, pods, number, target, work, most)
                effort.take(price_of_step * float(work[0]))
                if found:
                    sent = self._sent(pods.tolist(), masks.tolist())
                    return sent, self._parts(sent, orders.tolist())
        return None

    def _sent(self, pods: list[int], masks: list[int]) -> Visits:
        """Return the visits of pods (numbers) to the stations of their bit masks."""
        stations = range(len(self.reduced.capacities))
        return tuple((self._pods[p], s) for p, mask in zip(pods, masks, strict=True) for s in stations if mask >> s & 1)

    def _fills(self, visits: int, target: int) -> tuple[bool, Assigned | None]:
        """Return whether it is known if so many visits fill the target, and how they do."""
        stations = len(self.reduced.capacities)
        fewest = max(-(-visits // stations), self._too_few.get(target, -1) + 1)
        for number in range(fewest, min(visits, len(self._pods)) + 1):
            answer = spreading.NOT_FOUND
            for answer, pods, masks, orders in self._answers(number, visits, target):
                if answer == spreading.FOUND:
                    sent = self._sent(pods, masks)
                    known, parts = self._served(sent, orders, target)
                    if parts is not None:
                        return True, (sent, parts)
                    if not known:
                        return False, None
            if answer == spreading.TOO_MANY:
                return False, None
            if answer == spreading.NO_SETS:
                self._too_few[target] = number
        return True, None

    def _answers(self, number: int, visits: int, target: int) -> Iterator[tuple[int, list[int], list[int], Any]]:
        """Yield what the search finds, one after the other; last that it finds nothing more."""
        sets = pod_sets.sets_of(self._arrays, number, self._arrays.items.astype(np.float64), float(target))
        refused, last, answer = -1, None, spreading.FOUND
        while answer == spreading.FOUND:
            with self._most_work(number) as most_work:
                answer, pods, masks, orders = spreading.next_that_fills(
                    self._arrays, sets, refused, visits, target, self._work, most_work
                )
            refused, last = refused + 1 if pods.tolist() == last else 1, pods.tolist()
            yield answer, last, masks.tolist(), orders.tolist()

    @contextmanager
    def _most_work(self, number: int) -> Iterator[int]:
        """Say up to where a search for so many pods may count, and take what it does from the effort."""
        effort, before = self.limits.effort, int(self._work[0])
        price = price_of(self.reduced, len(self._pods), number)
        most = before + effort.most(max(self.most_work - before, 0), price)
        yield most
        done = int(self._work[0])
        effort.take(price * (done - before))
        effort.short |= most < self.most_work and done > most

    def _served(self, sent: Visits, orders: list[list[int]], target: int) -> tuple[bool, tuple[Part, ...] | None]:
        """Return whether it is known if these visits fill the target with the items that the pods have, and how."""
        parts, reduced = self._parts(sent, orders), self.reduced
        if not len(reduced.scarce) or short_of(reduced.period, sent, parts) is None:
            return True, parts
        self._work[0] += WORK_OF_A_PROGRAM
        return assigned_with(reduced, sent, self.weight, self.splits, self.limits, target)

    def _parts(self, visits: Visits, orders: list[list[int]]) -> tuple[Part, ...]:
        """Give the lines of each order to stations, as many items to each as was found."""
        period, reduced = self.reduced.period, self.reduced
        covered = period.covered_with(visits)
        stations = range(len(reduced.capacities))
        parts = []
        for number, packed in orders:
            order = reduced.orders[number]
            lines = period.lines_of(order)
            slots = [packed >> (8 * station) & 255 for station in stations]
            if reduced.model is Model.INTEGRATED:
                where = [next(s for s in stations if slots[s])] * len(lines)
            else:
                where = _stations_of([([s for s in stations if covered[s, i]], q) for i, q in lines], slots)
            for station in sorted(set(where)):
                skus = tuple(sku for (sku, _), at in zip(lines, where, strict=True) if at == station)
                parts.append(Part(order, station, skus))
        return tuple(parts)


def _stations_of(lines: list[tuple[list[int], int]], slots: list[int]) -> list[int]:
    """Choose a station for each line (stations that cover it, items) such that the slots are taken exactly."""
    if not lines:
        return []
    stations, items = lines[0]
    for station in stations:
        if slots[station] >= items:
            rest = [n - items * (s == station) for s, n in enumerate(slots)]
            try:
                return [station, *_stations_of(lines[1:], rest)]
            except LookupError:
                continue
    raise LookupError("no station for a line")
