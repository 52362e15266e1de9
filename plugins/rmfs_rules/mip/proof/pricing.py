"""Pricing for column generation: the patterns of least value at the prices of a relaxation, and a bound on all.

It is exact: a search for sets of pods of one size after another (`rmfs_rules.mip.compiled.pod_sets.best_sets`), which
ends because a pattern with k pods is worth at least k; where it takes too long, the aggregated model of one station.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from attrs import define, evolve, frozen
from numpy.typing import NDArray

from rmfs_rules.mip.compiled.arrays import arrays_of, price_of
from rmfs_rules.mip.compiled.pod_sets import best_sets
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.aggregated import Builder

MOST_WORK = 2_000_000
"""Steps of the search for sets of pods before the aggregated model prices."""
KEPT = 60
"""Sets of pods of each size that become patterns in one round."""
QUICK_WORK = 20_000
"""Steps of the search after which, where there are few orders, only patterns that are better yet are looked for."""
FEW = 2
"""There are few orders if their items are less than so many times the free slots.

Then most sets of pods complete enough, and what tells them apart is which orders they are for. So a search for sets of
a given worth leaves out the orders that no station with that worth can have.
"""
CLOSE = 1e-6
"""Values that differ by less are the same."""
SAFE = 1e-4
"""Most that rounding may add to a bound; far more than it does."""


@frozen
class Pattern:
    """Pods (positions) and orders (type to number) of one station, and what they cost."""

    pods: tuple[int, ...]
    orders: tuple[tuple[int, int], ...]
    cost: float


class CloseSet(NamedTuple):
    """A set of pods (positions), and what its best pattern is worth."""

    worth: float
    pods: tuple[int, ...]


@define
class Priced:
    """Good patterns at the current prices, and a bound on the value of any pattern (None: not known)."""

    patterns: list[tuple[float, Pattern]]
    bound: float | None


class Pricing:
    """Finds the patterns of least value ``c_k - sum_T price_T a_Tk``.

    Parameters
    ----------
    reduced
        The period; its stations are alike.
    weight
        W_u.
    limits
        Solver and limits.

    Attributes
    ----------
    room
        C: free slots of each station.
    sizes, counts
        Slots of an order of each type, and how many orders the type has.
    missing
        SKUs of each type that no pod at the stations has.
    work
        Steps of the searches so far.
    few_orders
        Whether there are few orders: see `FEW`.
    pods, brings
        A pod (position) for each class of pods, and the SKUs that it may bring.
    """

    def __init__(self, reduced: Reduced, weight: float, limits: Limits) -> None:
        self.reduced, self.weight, self.limits = reduced, weight, limits
        period, types = reduced.period, reduced.types
        covered = period.covered[0]
        self.room = reduced.capacities[0]
        self.sizes = np.array([kind.size for kind in types], dtype=np.int64)
        self.counts = np.array([len(kind.orders) for kind in types], dtype=np.int64)
        self.missing = [[sku for sku, _ in kind.lines if not covered[sku]] for kind in types]
        items, slots = int((self.sizes * self.counts).sum()), sum(reduced.capacities)
        self.few_orders = items < FEW * slots
        self.arrays, self.pods = arrays_of(reduced, sharp=self.few_orders)
        self.work = 0
        skus = np.split(self.arrays.pod_sku, self.arrays.pod_start[1:-1])
        self.brings = [held.tolist() for held in skus] if self.pods else []
        type_of = {order: t for t, kind in enumerate(types) for order in kind.orders}
        self.type_of = np.array([type_of[order] for order in reduced.orders], dtype=np.int64)

    def by_sets(self, prices: NDArray[np.float64], limit: float) -> Priced:
        """Return the best patterns; without a bound where not all sets of pods could be tried.

        Parameters
        ----------
        prices
            Of each type of orders.
        limit
            Upper limit of the patterns' worth, itself excluded.
        """
        values = self.weight * self.sizes + prices
        most = float(self.weight * self.room)
        found: list[tuple[float, Pattern]] = []
        least = limit = min(most, limit)
        before = self.work
        for number in range(len(self.pods) + 1):
            if number >= least - CLOSE:  # a pattern with so many pods is worth at least as much
                return Priced(found, least)
            if self.few_orders and self.work - before > QUICK_WORK:
                limit = least  # there are good patterns already, and a better one is what is left to know
            sets = self.sets(number, values, number + most - limit, KEPT)
            if sets is None:
                return Priced(found, None)
            for worth, chosen in sets:
                least = min(least, number + most - worth)
                found.append((number + most - worth, self._pattern(chosen, values)))
        return Priced(found, least)

    def close_sets(self, prices: NDArray[np.float64], limit: float, kept: int) -> tuple[list[CloseSet], bool]:
        """Return the sets of pods that have a pattern worth at most a limit.

        Parameters
        ----------
        prices
            Of each type of orders.
        limit
            Upper limit of their worth.
        kept
            How many sets are returned at most.

        Returns
        -------
        sets, complete
            The sets, best first, and whether these are all.
        """
        values = self.weight * self.sizes + prices
        most = self.weight * self.room
        close: list[CloseSet] = []
        complete = True
        for number in range(min(len(self.pods), int(limit + SAFE)) + 1):
            sets = self.sets(number, values, number + most - limit - SAFE, kept)
            complete = complete and sets is not None and len(sets) < kept
            for worth, chosen in sets or []:
                close.append(CloseSet(number + most - worth, tuple(self.pods[place] for place in chosen)))
        close.sort()
        return close[:kept], complete and len(close) <= kept

    def sets(
        self, number: int, values: NDArray[np.float64], least: float, kept: int
    ) -> list[tuple[float, list[int]]] | None:
        """Return the best sets of pods, each with its worth, or None when they are too many to search.

        Parameters
        ----------
        number
            Number of pods in a set.
        values
            Weight of an order of each type.
        least
            Least worth of a set.
        kept
            How many sets are returned at most.
        """
        work = np.zeros(1, dtype=np.int64)
        values = values[self.type_of]
        if self.few_orders:
            values = np.where(self._most_with(values) >= least - SAFE, values, 0.0)
        price = price_of(self.reduced, len(self.pods), number)
        most_work = self.limits.effort.most(MOST_WORK, price)
        worths, sets = best_sets(self.arrays, number, values, least, kept, work, most_work)
        self.limits.effort.take(price * float(work[0]))
        self.work += int(work[0])
        if work[0] > most_work:
            self.limits.effort.short |= most_work < MOST_WORK
            return None
        return sorted((worth, chosen) for worth, chosen in zip(worths.tolist(), sets.tolist(), strict=True))

    def _most_with(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return what a station is worth at most with each of the orders, had it all SKUs: by a knapsack."""
        sizes, slots, n = self.sizes[self.type_of], self.room + 1, len(values)
        before, after = np.zeros((n + 1, slots)), np.zeros((n + 1, slots))  # by the slots that may be taken
        for table, orders in ((before, range(n)), (after, range(n - 1, -1, -1))):
            for row, order in enumerate(orders):
                size = int(sizes[order])
                table[row + 1] = table[row]
                if size < slots and values[order] > 0:
                    with_it = table[row, : slots - size] + values[order]
                    table[row + 1, size:] = np.maximum(table[row, size:], with_it)
        most = np.zeros(n)
        for order in range(n):
            left = slots - int(sizes[order])
            if left > 0:
                most[order] = values[order] + (before[order, :left] + after[n - 1 - order, :left][::-1]).max()
        return most

    def _pattern(self, chosen: Sequence[int], values: NDArray[np.float64]) -> Pattern:
        """Return the best pattern of a set of pods (numbers of classes)."""
        at_hand = {sku for number in chosen for sku in self.brings[number]}
        able = [t for t, missing in enumerate(self.missing) if values[t] > 0 and at_hand.issuperset(missing)]
        items = [t for t in able for _ in range(min(int(self.counts[t]), self.room // int(self.sizes[t])))]
        table = np.zeros((len(items) + 1, self.room + 1))
        for row, number in enumerate(items):
            size = int(self.sizes[number])
            table[row + 1] = table[row]
            table[row + 1, size:] = np.maximum(table[row, size:], table[row, : self.room + 1 - size] + values[number])
        orders: dict[int, int] = {}
        place = self.room
        for row in range(len(items), 0, -1):
            if table[row, place] > table[row - 1, place]:
                orders[items[row - 1]] = orders.get(items[row - 1], 0) + 1
                place -= int(self.sizes[items[row - 1]])
        return self._costed(tuple(self.pods[number] for number in chosen), orders)

    def _costed(self, pods: tuple[int, ...], orders: dict[int, int]) -> Pattern:
        taken = sum(int(self.sizes[number]) * n for number, n in orders.items())
        return Pattern(pods, tuple(sorted(orders.items())), len(pods) + self.weight * (self.room - taken))

    def by_model(self, prices: NDArray[np.float64], seconds: float | None) -> Priced | None:
        """Return the best pattern, whatever the number of its pods; None when the time is up before it is proven.

        Parameters
        ----------
        prices
            Of each type of orders.
        seconds
            Seconds left of the time limit; None for none.
        """
        period = self.reduced.period
        one = evolve(
            period,
            stations=period.stations[:1],
            capacities=period.capacities[:1],
            inbound=period.inbound[:1],
            counting_orders=period.counting_orders & {0},
        )
        model = Builder(Reduced(one, Model.INTEGRATED), self.weight).build()
        for column in model.x.values():
            model.program.cost[column] = 1.0
        for (number, _), column in model.y.items():
            model.program.cost[column] = -self.weight * float(self.sizes[number]) - float(prices[number])
        model.program.constant = self.weight * self.room
        outcome = model.program.solve(self.limits, absolute_gap=CLOSE, seconds=seconds)
        if outcome.values is None or not outcome.optimal:
            return None
        pods = tuple(pod for (pod, _), column in model.x.items() if outcome.values[column] > 0.5)
        orders = {t: round(outcome.values[c]) for (t, _), c in model.y.items() if outcome.values[c] > 0.5}
        return Priced([(outcome.objective, self._costed(pods, orders))], min(outcome.bound, outcome.objective))
