"""Proves a period's optimum, step by step: first by bounds that need no solver, with the solver as the last resort.

Each step may offer a solution and raise the bound; the first after which they meet is the last (`STEPS`). What steps
do is taken from the period's effort (`rmfs_rules.mip.period.effort`); one that finds too little left does nothing.

1. `by_what_is_there`: the pods at the stations already fill all slots, and nothing can be better. (Nearly always so
   for split-over-time.)
2. `by_nothing`: the solution that assigns nothing, where nothing can be assigned.
3. `by_bounds`, the sandwich. From below: whatever the model, its solution is one of split-over-time (propositions 2 and
   3), so with W_u > 1 the fewest new visits that let demand flow into all slots bound it (`proof.flow`). From
   above: what `proof.feasible` assigns to the visits that fill most.
   For other weights, or many stations, `by_stations` bounds each station alone.
4. `by_fewest_visits`: where orders are assigned completely, sets of pods for one value of the objective after another
   (`rmfs_rules.mip.proof.fewest`). This alone proves split-among-stations at t = 1.
5. `by_greedy`: a good solution to fall back on, of whole orders (`rmfs_rules.mip.proof.greedy`).
6. `by_patterns`: where the stations are alike, as at t = 1, column generation (`rmfs_rules.mip.proof.patterns`), which
   bounds far better than the relaxation of the model itself.
7. `by_few_splits`: where few orders may be split over time and the stations are alike, pods are exchanged
   (`rmfs_rules.mip.proof.splitting`).
8. `by_solver`: the aggregated model (`rmfs_rules.mip.proof.aggregated`) is asked for a solution at least as good as the
   bound and better than the one at hand. There is none: the one at hand is optimal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from attrs import evolve

from rmfs_rules.mip.period.decoding import parts_of
from rmfs_rules.mip.period.effort import Effort, is_large
from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Assigned, Model, Visits
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.aggregated import assigned_with
from rmfs_rules.mip.proof.feasible import fill
from rmfs_rules.mip.proof.fewest import FewestVisits
from rmfs_rules.mip.proof.flow import MOST_STATIONS, Network, fewest_visits, greedy_visits
from rmfs_rules.mip.proof.greedy import station_by_station
from rmfs_rules.mip.proof.parts import builder_of, by_slots
from rmfs_rules.mip.proof.patterns import (
    ColumnGeneration,
    alike,
    choose_among,
    lines_as_orders,
    orders_of_lines,
)
from rmfs_rules.mip.proof.pricing import SAFE
from rmfs_rules.mip.proof.proof import SHARE_OF_SOLVER, Proof
from rmfs_rules.mip.proof.splitting import visits_for_few_splits
from rmfs_rules.mip.proof.stocked import fill_from_stock, lines_from_stock, one_line_orders

Step = Callable[[Proof], None]

WORK_PER_SECOND = 1_000_000
"""Steps of the search for visits (`proof.fewest`) in a second, roughly."""
MOST_WORK = {Model.INTEGRATED: 20_000, Model.SPLIT_AMONG_STATIONS: 300_000}
"""Steps of it before the solver takes over: about as many as the solver needs the time of."""
MOST_WORK_ALIKE = 100_000_000
"""The same for split-among-stations where the stations are alike, as at t = 1: the solver may need hours."""
WORK_ALIKE_SCARCE = 20_000
"""And with scarce SKUs, for each pod and station: there the solver, too, has bounds that are close."""
SHARE_OF_SEARCH = 2
"""The part of the effort that the search for visits may take where little is proven; `by_greedy` needs the rest."""
GREEDY_PER_PLACE = 1000
"""Steps that improving a greedy solution may take for each free slot, where a period is not large."""
STEPS_PER_LINE = 100
"""Effort of building the program, for each line and station, where a period is large."""
CLOSE_SETS = (100, 500, 2000)
"""Sets of pods from which a better solution, if there is one, is put together: first the best few, then more."""
FEW_MORE = 3
"""All sets are not many more than the best few if they are no more than so many times these."""


def proof_of(
    period: Period,
    model: Model,
    weight: float,
    limits: Limits,
    packing_capacity: int | None = None,
    steps: Sequence[Step] | None = None,
) -> Proof:
    """Return the proof, yet to be run, of a period's optimum.

    Where no order may be split and none is split already, split-among-stations is the integrated model.

    Parameters
    ----------
    period
        The period.
    model
        Which of the three models.
    weight
        W_u.
    limits
        Solver and limits.
    packing_capacity
        C of (18); None for no limit on split orders.
    steps
        Steps to try; all of `STEPS` when None, or of `STEPS_BY_ORDERS` where stations count orders.
    """
    if steps is None:
        steps = STEPS_BY_ORDERS if period.counting_orders else STEPS
    splits = None
    if packing_capacity is not None and model is not Model.INTEGRATED:
        splits = max(packing_capacity - period.split_open, 0)
    if splits == 0 and model is Model.SPLIT_AMONG_STATIONS and not any(period.begun):
        return Proof(Reduced(period, Model.INTEGRATED), weight, limits, steps=steps)
    return Proof(Reduced(period, model), weight, limits, splits, steps)


def by_what_is_there(proof: Proof) -> None:
    """Fill the slots by a maximum flow from what is at the stations: with single lines, that is optimal if it does."""
    if proof.reduced.model is Model.SPLIT_OVER_TIME:
        _fill_by(proof, (), "flow")
        if not proof.proven:
            proof.best = None  # "flow" is for what the flow proves


def by_nothing(proof: Proof) -> None:
    """Assign nothing; where no line can be assigned, that is optimal."""
    proof.offer((), (), "bounds")
    if not proof.reduced.candidates.any():
        proof.bound = proof.incumbent.objective


def by_bounds(proof: Proof) -> None:
    """Bound by the fewest visits that let demand flow into all slots; fill what the best visits, one by one, cover.

    With W_u of at most 1 a free slot may be better than a visit, and with many stations there are too many cuts.
    """
    reduced = proof.reduced
    if proof.weight <= 1 or len(reduced.capacities) > MOST_STATIONS:
        return
    network = Network.of(reduced)
    base = reduced.period.visits_before + proof.weight * (sum(reduced.capacities) - network.target)
    visits: Visits = ()
    if network.flow() >= network.target:
        proof.bound = base
    else:
        proof.bound = base + max(1, fewest_visits(network))
        visits, _ = greedy_visits(network, reduced.period.preferred)
    _fill_by(proof, visits, "bounds" if visits else "flow")
    if len(reduced.scarce) and not proof.proven and reduced.model is not Model.SPLIT_OVER_TIME:
        lines = one_line_orders(reduced)
        visits, _ = greedy_visits(network.with_demand_of(reduced, lines), reduced.period.preferred)
        proof.offer(visits, lines_from_stock(reduced, visits, lines), "bounds" if visits else "flow")


def _fill_by(proof: Proof, visits: Visits, how: str) -> None:
    """Offer what can be assigned with these new visits."""
    reduced = proof.reduced
    if not (reduced.period.single_items or reduced.model is Model.INTEGRATED):
        return
    if len(reduced.scarce):
        proof.offer(visits, fill_from_stock(reduced, visits), how)
    else:
        proof.offer(visits, fill(reduced, reduced.period.covered_with(visits)), how)


def by_stations(proof: Proof) -> None:
    """Bound what each station costs alone: as `by_bounds`, for any weight and any number of stations.

    For each number of new pods, a station has at least the slots free that these and what is there cannot fill.
    """
    reduced, period = proof.reduced, proof.reduced.period
    if proof.weight > 1 and len(reduced.capacities) <= MOST_STATIONS:
        return  # `by_bounds` is stronger
    least = sum(_least_of_station(reduced, station, proof.weight) for station in range(len(reduced.capacities)))
    proof.bound = max(proof.bound, period.visits_before + least)


def _least_of_station(reduced: Reduced, station: int, weight: float) -> float:
    period, room = reduced.period, reduced.capacities[station]
    there = period.covered[station]
    covered = reduced.demand[there].sum()
    brings = np.minimum(period.stock.sums(np.where(there & ~reduced.is_scarce, 0.0, reduced.demand)), room)
    filled = covered + np.concatenate(([0.0], np.cumsum(np.sort(brings)[::-1][:room])))
    return float((np.arange(len(filled)) + weight * np.maximum(room - filled, 0.0)).min())


def by_fewest_visits(proof: Proof) -> None:
    """Try one value of the objective after another, from the bound upwards."""
    reduced = proof.reduced
    if not proof.whole or reduced.model not in MOST_WORK:
        return
    if is_large(reduced.period) and alike(reduced):
        return  # `by_patterns` is quicker there
    among = reduced.model is Model.SPLIT_AMONG_STATIONS
    most_work = MOST_WORK_ALIKE if among and reduced.interchangeable else MOST_WORK[reduced.model]
    if len(reduced.scarce):
        most_work = min(most_work, WORK_ALIKE_SCARCE * len(reduced.period.stock.pods) * len(reduced.capacities))
    left = proof.seconds_left
    if left is not None:
        most_work = min(most_work, int(max(left, 0) * WORK_PER_SECOND))
    effort, least = proof.limits.effort, reduced.least(proof.weight)
    lower = max(math.ceil(proof.bound - least), 0)
    hopeless = is_large(reduced.period) or proof.hard
    with effort.share(effort.left / (SHARE_OF_SEARCH if hopeless else 1)) as part:
        limits = evolve(proof.limits, effort=part)
        search = FewestVisits(reduced, int(proof.weight), most_work, proof.splits, limits)
        if not search.possible:
            return
        value, found = search.run(lower, round(proof.incumbent.objective - least))
    proof.bound = max(proof.bound, least + value)
    if found is not None:
        proof.offer(*found, "search")


def by_greedy(proof: Proof) -> None:
    """Have a good solution: whole orders, which all three models allow, or fewer visits for orders that are split."""
    reduced = proof.reduced
    whole = _as_whole(reduced) if proof.splits is None else Reduced(reduced.period, Model.INTEGRATED)
    if whole.candidates.any():
        effort = proof.limits.effort
        most = float("inf") if is_large(reduced.period) else GREEDY_PER_PLACE * sum(reduced.capacities)
        part = Effort(min(effort.left, most))
        visits, parts = station_by_station(whole, proof.weight, part)
        effort.take(min(effort.left, most) - part.left if part.left < float("inf") else 0)
        effort.short |= part.short and effort.left < most
        _offer_whole(proof, whole, (visits, parts), "greedy")
        _fill_by(proof, visits, "greedy")
        if len(whole.scarce):  # where stations together take more than the pods have, what these pods can serve
            _offer_whole(proof, whole, (visits, fill_from_stock(whole, visits)), "greedy")
    if reduced.model is Model.SPLIT_AMONG_STATIONS or proof.splits is not None:
        among = Reduced(reduced.period, Model.SPLIT_AMONG_STATIONS)
        search = FewestVisits(among, int(proof.weight), 0, proof.splits, proof.limits)
        if search.possible:
            least = among.least(proof.weight)
            found = search.quickly(max(math.ceil(proof.bound - least), 0), math.ceil(proof.incumbent.objective - least))
            if found is not None:
                proof.offer(*found, "greedy")


def by_patterns(proof: Proof) -> None:
    """Bound by the relaxation over patterns, and try the best choice of the patterns that it needed."""
    period, reduced = proof.reduced.period, _as_whole(proof.reduced)
    same = reduced is proof.reduced or reduced.period is not period
    if not same or not proof.whole or not alike(reduced):
        return
    worth = proof.weight * period.factors[0]
    generation = ColumnGeneration(reduced, worth, proof.limits, lambda: proof.seconds_left)
    generation.run()
    if len(generation.prices):  # else the time was up before anything was known
        proof.bound = max(proof.bound, period.visits_before + math.ceil(generation.bound - SAFE))
    if proof.proven:
        return
    chosen = generation.whole()
    if chosen is not None:
        _offer_whole(proof, reduced, chosen, "patterns")
    while len(generation.prices) and not proof.proven and _try_bound(proof, generation):
        pass


def _try_bound(proof: Proof, generation: ColumnGeneration) -> bool:
    """Look for a solution with the value of the bound, or raise the bound; return whether that is settled.

    Such a solution consists of patterns whose values exceed the least one by no more than this value exceeds the bound
    of the relaxation, in all.
    """
    value = proof.bound - proof.reduced.period.visits_before
    limit = generation.least + value - generation.bound
    sets, complete = generation.pricing.close_sets(generation.prices, limit, CLOSE_SETS[-1])
    # Where SKUs are scarce, more sets are close; if some are left out, the largest program would prove nothing.
    numbers = CLOSE_SETS if complete or not len(generation.reduced.scarce) else CLOSE_SETS[:-1]
    for number in numbers:
        if complete and number < len(sets) <= FEW_MORE * number:
            continue  # all of them at once: that none is good enough is shown quickest with all
        left = proof.seconds_left
        if left is not None and left <= 0:
            return False
        found, exact = choose_among(generation, sets[:number], value, left)
        if found is not None:
            _offer_whole(proof, generation.reduced, found, "patterns")
            return proof.proven
        if len(sets) <= number:
            if exact and complete:
                proof.bound += 1
            return exact and complete
    return False


def _as_whole(reduced: Reduced) -> Reduced:
    """Return the period with whole orders alone; single lines that are split over time are such orders each.

    That is the same model then, except for a limit on splits.
    """
    period = reduced.period
    if reduced.model is Model.INTEGRATED:
        return reduced
    if reduced.model is Model.SPLIT_OVER_TIME and period.single_items and not period.counting_orders:
        period = lines_as_orders(period)
    return Reduced(period, Model.INTEGRATED)


def _offer_whole(proof: Proof, whole: Reduced, found: Assigned, how: str) -> None:
    visits, parts = found
    if len(whole.period.orders) != len(proof.reduced.period.orders):
        parts = orders_of_lines(proof.reduced.period, parts)
    proof.offer(visits, parts, how)


def by_few_splits(proof: Proof) -> None:
    """Where few orders may be split over time and the stations are alike, look for visits that fill all slots.

    First as many as the bound says, which would be proven, then one more after the other.
    """
    reduced = proof.reduced
    limited = proof.splits is not None and reduced.model is Model.SPLIT_OVER_TIME
    if not limited or not proof.whole or proof.weight <= 1 or not reduced.interchangeable:
        return
    assert proof.splits is not None
    effort, least = proof.limits.effort, reduced.least(proof.weight)
    for number in range(max(math.ceil(proof.bound - least), 1), math.ceil(proof.incumbent.objective - least)):
        visits = visits_for_few_splits(reduced, number, proof.splits, effort)
        if visits is None:
            continue
        with effort.share(effort.left / SHARE_OF_SOLVER) as part:
            limits = evolve(proof.limits, effort=part)
            _, parts = assigned_with(reduced, visits, proof.weight, proof.splits, limits, reduced.reachable_sum)
        if parts is not None:
            proof.offer(visits, parts, "search")
            return


def by_solver(proof: Proof) -> None:
    """Ask for a better solution than the one at hand, where there is effort left for a program of that size."""
    lines = int(proof.reduced.candidates.sum()) * len(proof.reduced.capacities)
    if is_large(proof.reduced.period) and not proof.limits.effort.allows(STEPS_PER_LINE * lines):
        return
    builder = builder_of(proof.reduced, proof.weight, proof.splits)
    model = builder.build()
    ceiling = proof.incumbent.objective - (1 if proof.whole else 0)
    if not builder.objective:  # nothing can be assigned
        proof.bound = proof.incumbent.objective
        return
    builder.limit_objective(proof.bound, ceiling)
    gap = 0.9 if proof.whole else 1e-6  # below 1 by as much as `MOST_PREFERENCE`
    outcome = proof.solve(model.program, gap)
    if outcome.values is not None:
        counts = model.counts(outcome.values)
        proof.offer(counts.visits, parts_of(proof.reduced, counts), "solver")
    elif outcome.bound == float("inf"):
        outcome = evolve(outcome, bound=proof.incumbent.objective, optimal=True)
    exact = outcome.optimal and proof.limits.gap == 0
    proof.bound = proof.incumbent.objective if exact else max(proof.bound, outcome.bound - 0.1)


STEPS: tuple[Step, ...] = (
    by_what_is_there,
    by_nothing,
    by_bounds,
    by_stations,
    by_fewest_visits,
    by_greedy,
    by_patterns,
    by_few_splits,
    by_solver,
)
"""Steps, in the order in which they are tried until the best solution is proven."""

STEPS_BY_ORDERS: tuple[Step, ...] = (by_nothing, by_slots, by_patterns, by_solver)
"""The same where stations count orders; see `proof.parts`."""
