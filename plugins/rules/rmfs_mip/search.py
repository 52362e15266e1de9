"""Solves one period exactly: first by bounds that need no solver, then by the aggregated model.

0. What is at the stations already fills all places: nothing can be better. (Nearly always so for split-over-time.)
1. A lower bound on objective (1). Whatever the model, its solution is one of split-over-time (propositions 2 and 3), so
   with W_u > 1 the fewest new visits that let demand flow into all places bound it (`rmfs_mip.flow`).
2. A solution: the visits that fill most (or those that whole orders need, `rmfs_mip.construct`), and what
   `rmfs_mip.filling` assigns to them. It is optimal where it meets the bound.
3. Where few orders may be split, all of this and 4 and 5 without that limit, which bounds it. For split-over-time with
   stations that are alike also split-among-stations, whose solutions are some of it.
4. Where orders are assigned completely, trying sets of pods for one value of the objective after another
   (`rmfs_mip.fewest`). This alone solves split-among-stations at t = 1.
5. Where the stations are alike, as at t = 1, column generation (`rmfs_mip.patterns`): a far better bound and solution.
6. Else the solver, asked for a solution that is at least as good as the bound and better than the one at hand. There is
   none: the one at hand is optimal.
"""

from __future__ import annotations

import math
import time

from attrs import define, evolve

from rmfs_mip.aggregated import Builder, is_whole
from rmfs_mip.check import newly_split
from rmfs_mip.construct import whole_order_visits
from rmfs_mip.decoding import covered_with, parts_of, visits_of
from rmfs_mip.fewest import FewestVisits
from rmfs_mip.filling import fill, fill_with_orders
from rmfs_mip.flow import MOST_STATIONS, Network, fewest_visits, greedy_visits
from rmfs_mip.patterns import (
    CLOSE_SETS,
    SAFE,
    ColumnGeneration,
    alike,
    choose_among,
    lines_as_orders,
    orders_of_lines,
)
from rmfs_mip.period import Period
from rmfs_mip.reduction import Reduced, masks_of
from rmfs_mip.solution import Model, Part, Solution, is_useful, items_of
from rmfs_mip.solver import Limits

Visits = tuple[tuple[int, int], ...]

WORK_PER_SECOND = 1_000_000
"""Steps of the search for visits (`rmfs_mip.fewest`) in a second, roughly."""
MOST_WORK = {Model.INTEGRATED: 20_000, Model.SPLIT_AMONG_STATIONS: 300_000}
"""Steps of it before the solver takes over.

The solver needs about 10 ms for the integrated model, several 100 ms for split-among-stations.
"""
MOST_WORK_ALIKE = 100_000_000
"""The same for split-among-stations where the stations are alike, as at t = 1: the solver may need hours."""


@define
class Search:
    """What is known about the optimum of a period.

    Parameters
    ----------
    reduced
        The period.
    weight
        W_u.
    limits
        Solver and limits.
    splits
        How many orders may newly be split; None for any number.
    solver
        Whether to ask the solver for what the other steps leave open.
    """

    reduced: Reduced
    weight: float
    limits: Limits
    splits: int | None = None
    solver: bool = True
    bound: float = float("-inf")
    best: Solution | None = None
    deadline: float | None = None

    @property
    def whole(self) -> bool:
        """Whether the objective is always a whole number."""
        return is_whole(self.weight)

    def run(self) -> Solution:
        """Return an optimal solution (or, where a limit comes first, the best found, marked so)."""
        if self.limits.max_seconds is not None:
            self.deadline = time.monotonic() + self.limits.max_seconds
        self.bound = float(self.reduced.period.visits_before)
        if self.reduced.model is Model.SPLIT_OVER_TIME:
            self._try((), "flow")  # nearly every period ends here: what is at the stations fills them
        if self.best is None or not self.proven:
            self.best = None  # "flow" is for what the flow proves
            self._search()
        bound = self.incumbent.objective if self.proven else self.bound
        if self.incumbent.bound != bound:
            self.best = evolve(self.incumbent, bound=bound)
        return self.incumbent

    def _search(self) -> None:
        self.offer((), (), "bounds")
        if not self.reduced.candidates.any():
            self.bound = self.incumbent.objective
        elif self.weight > 1 and len(self.reduced.capacities) <= MOST_STATIONS:
            self._by_bounds()
        if not self.proven and self.splits is not None:
            self._by_relaxation()
            if not self.proven and self.reduced.model is Model.SPLIT_OVER_TIME and self.reduced.interchangeable:
                self._by_restriction()
        if not self.proven and self.whole and self.reduced.model in MOST_WORK:
            self._by_fewest_visits()
        if not self.proven:
            self._by_whole_orders()
        if not self.proven and self.whole:
            self._by_patterns()
        if not self.proven and self.solver:
            self._by_solver()

    def _by_relaxation(self) -> None:
        """Solve the period without a limit on newly split orders, as far as that goes without the solver."""
        relaxed = Search(self.reduced, self.weight, self.limits, bound=self.bound, deadline=self.deadline, solver=False)
        relaxed._search()
        self.bound = relaxed.incumbent.objective if relaxed.proven else relaxed.bound
        self._offer_visits(relaxed.incumbent)

    def _by_restriction(self) -> None:
        """Take the solution of split-among-stations for split-over-time, as far as that goes without the solver."""
        among = Reduced(self.reduced.period, Model.SPLIT_AMONG_STATIONS)
        start = float(self.reduced.period.visits_before)
        search = Search(among, self.weight, self.limits, self.splits, False, bound=start, deadline=self.deadline)
        search._search()
        self._offer_visits(search.incumbent)

    def _offer_visits(self, found: Solution) -> None:
        before = self.reduced.period.inbound
        self.offer(tuple((p, s) for p, s in found.visits if p not in before[s]), found.parts, found.how)

    @property
    def incumbent(self) -> Solution:
        """The best solution so far."""
        assert self.best is not None
        return self.best

    @property
    def seconds_left(self) -> float | None:
        """What is left of the time limit."""
        return None if self.deadline is None else self.deadline - time.monotonic()

    @property
    def proven(self) -> bool:
        """Whether nothing can be better than the best solution so far."""
        step = 1 - 1e-6 if self.whole else 1e-6
        return self.incumbent.objective - self.bound < step

    def offer(self, visits: Visits, parts: tuple[Part, ...], how: str) -> None:
        """Keep a solution if it is better and splits no more orders than allowed."""
        period = self.reduced.period
        used = {(pod, s) for pod, s in visits if is_useful(period, pod, s, parts)}
        taken = sum(items_of(period, part) for part in parts) if not period.single_items else _lines(parts)
        value = period.visits_before + len(used) + self.weight * (sum(period.capacities) - taken)
        if self.best is not None and value >= self.best.objective:
            return
        before = {(pod, s) for s, pods in enumerate(period.inbound) for pod in pods}
        found = Solution(parts, tuple(sorted(before | used)), value, self.bound, how)
        if self.splits is None or len(newly_split(period, found)) <= self.splits:
            self.best = found

    def _by_bounds(self) -> None:
        reduced = self.reduced
        network = network_of(reduced)
        flow = network.flow()
        base = reduced.period.visits_before + self.weight * (sum(reduced.capacities) - network.target)
        visits: Visits = ()
        if flow >= network.target:
            self.bound = base
        else:
            self.bound = base + max(1, fewest_visits(network))
            visits, _ = greedy_visits(network, reduced.period.preferred)
        self._try(visits, "bounds" if visits else "flow")

    def _try(self, visits: Visits, how: str) -> None:
        covered = covered_with(self.reduced, visits)
        if self.reduced.period.single_items or self.reduced.model is Model.INTEGRATED:
            self.offer(visits, fill(self.reduced, covered), how)

    def _by_fewest_visits(self) -> None:
        """Try one value of the objective after another, from the bound upwards."""
        reduced = self.reduced
        among = reduced.model is Model.SPLIT_AMONG_STATIONS
        most_work = MOST_WORK_ALIKE if among and reduced.interchangeable else MOST_WORK[reduced.model]
        left = self.seconds_left
        if left is not None:
            most_work = min(most_work, int(max(left, 0) * WORK_PER_SECOND))
        search = FewestVisits(reduced, int(self.weight), most_work, self.splits)
        if not search.possible:
            return
        least = reduced.period.visits_before + self.weight * (sum(reduced.capacities) - reduced.reachable_sum)
        lower = max(math.ceil(self.bound - least), 0)
        value, found = search.run(lower, round(self.incumbent.objective - least))
        self.bound = max(self.bound, least + value)
        if found is not None:
            self.offer(*found, "search")

    def _by_whole_orders(self) -> None:
        """Make sure that there is a solution to fall back on: one of the integrated model is one of all three."""
        whole = Reduced(self.reduced.period, Model.INTEGRATED)
        if whole.candidates.any():
            visits = whole_order_visits(whole, self.weight)
            self.offer(visits, fill_with_orders(whole, covered_with(whole, visits)), "search")
            self._try(visits, "search")

    def _by_patterns(self) -> None:
        """Bound by the relaxation over patterns, and try the best choice of the patterns that it needed."""
        reduced, period = self.reduced, self.reduced.period
        if reduced.model is Model.SPLIT_OVER_TIME and self.splits is None and period.single_items:
            reduced = Reduced(lines_as_orders(period), Model.INTEGRATED)  # each line goes where it likes
        if not alike(reduced):
            return
        generation = ColumnGeneration(reduced, self.weight, self.limits, lambda: self.seconds_left)
        generation.run()
        if len(generation.prices):  # else the time was up before anything was known
            self.bound = max(self.bound, period.visits_before + math.ceil(generation.bound - SAFE))
        chosen = generation.whole()
        if chosen is not None:
            self._offer_patterns(reduced, *chosen)
        while len(generation.prices) and not self.proven and self._try_bound(generation):
            pass

    def _try_bound(self, generation: ColumnGeneration) -> bool:
        """Look for a solution with the value of the bound, or raise the bound; return whether that is settled.

        Such a solution consists of patterns whose values exceed the least one by no more than this value exceeds the
        bound of the relaxation, in all.
        """
        value = self.bound - self.reduced.period.visits_before
        sets, complete = generation.pricing.close_sets(generation.prices, generation.least + value - generation.bound)
        for number in CLOSE_SETS:
            left = self.seconds_left
            if left is not None and left <= 0:
                return False
            found, exact = choose_among(generation.reduced, sets[:number], self.weight, self.limits, left, value)
            if found is not None:
                self._offer_patterns(generation.reduced, *found)
                return self.proven
            if len(sets) <= number:
                if exact and complete:
                    self.bound += 1
                return exact and complete
        return False

    def _offer_patterns(self, reduced: Reduced, visits: Visits, parts: tuple[Part, ...]) -> None:
        if reduced is not self.reduced:
            parts = orders_of_lines(self.reduced.period, parts)
        self.offer(visits, parts, "patterns")

    def _by_solver(self) -> None:
        builder = Builder(self.reduced, self.weight, self.splits)
        model = builder.build()
        ceiling = self.incumbent.objective - (1 if self.whole else 0)
        if not builder.objective:  # nothing can be assigned
            self.bound = self.incumbent.objective
            return
        builder.limit_objective(self.bound, ceiling)
        gap = 0.9 if self.whole else 1e-6  # below 1 by as much as `MOST_PREFERENCE`
        outcome = model.program.solve(self.limits, absolute_gap=gap, seconds=self.seconds_left)
        if outcome.values is not None:
            self.offer(visits_of(model, outcome.values), parts_of(self.reduced, model, outcome.values), "solver")
        elif outcome.bound == float("inf"):
            outcome = evolve(outcome, bound=self.incumbent.objective, optimal=True)
        exact = outcome.optimal and self.limits.gap == 0
        self.bound = self.incumbent.objective if exact else max(self.bound, outcome.bound - 0.1)
        if not self.proven:
            self.best = evolve(self.incumbent, how="stopped")


def network_of(reduced: Reduced) -> Network:
    """Return demand and stations of a period for `rmfs_mip.flow`."""
    return Network(
        reduced.reachable,
        reduced.demand,
        reduced.period.stock.holds,
        masks_of(reduced.period.covered),
        min(reduced.reachable_sum, int(reduced.demand.sum())),
    )


def search_for(
    period: Period, kind: Model, weight: float, limits: Limits, packing_capacity: int | None = None
) -> Search:
    """Return the search that solves a period by its aggregated form.

    Where no order may be split and none is split already, split-among-stations is the integrated model.
    """
    splits = None
    if packing_capacity is not None and kind is not Model.INTEGRATED:
        splits = max(packing_capacity - period.split_open, 0)
    if splits == 0 and kind is Model.SPLIT_AMONG_STATIONS and not any(period.begun):
        return Search(Reduced(period, Model.INTEGRATED), weight, limits)
    return Search(Reduced(period, kind), weight, limits, splits)


def _lines(parts: tuple[Part, ...]) -> int:
    return sum(len(part.skus) for part in parts)
