"""Column generation finds the optimum of the printed form where the stations are alike."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model, Solution
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.models import solve_printed
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof import pricing, steps
from rmfs_rules.mip.proof.patterns import ColumnGeneration, alike

LIMITS = Limits()


def by_patterns(period: Period, model: Model, limits: Limits = LIMITS) -> Solution:
    """Prove a period without what would prove small ones before the patterns are needed."""
    left_out = (steps.by_bounds, steps.by_fewest_visits, steps.by_greedy)
    chosen = [step for step in steps.STEPS if step not in left_out]
    return steps.proof_of(period, model, 2, limits, steps=chosen).run()


@pytest.mark.parametrize("quick_work", [pricing.QUICK_WORK, -1], ids=["all-sets", "better-sets"])
@pytest.mark.parametrize("model", [Model.INTEGRATED, Model.SPLIT_OVER_TIME])
def test_the_optimum_is_that_of_the_printed_form(equal_stations, monkeypatch, model, quick_work):
    """Whatever the patterns prove is true, and what they choose satisfies the printed constraints: 120 periods."""
    monkeypatch.setattr(pricing, "QUICK_WORK", quick_work)
    proven = 0
    for number, period in enumerate(equal_stations):
        found = by_patterns(period, model)
        assert found.objective == found.bound == solve_printed(period, model, 2, LIMITS).objective, number
        assert violation(period, found, model, 2) is None, number
        proven += found.how == "patterns"
    assert proven > 10


@pytest.mark.parametrize("most_work", [0, 20])
def test_pricing_by_the_model_is_as_good(equal_stations, monkeypatch, most_work):
    """Where the search for sets of pods takes too long, a single station's model prices; the optimum stays the same."""
    monkeypatch.setattr(pricing, "MOST_WORK", most_work)
    for period in equal_stations[:40]:
        found = by_patterns(period, Model.INTEGRATED)
        assert found.objective == solve_printed(period, Model.INTEGRATED, 2, LIMITS).objective


@pytest.mark.parametrize("sets", [(1,), (1, 2), (2, 8)])
def test_few_close_sets_prove_nothing_false(equal_stations, monkeypatch, sets):
    """However few sets of pods a better solution is put together from, the optimum stays the same."""
    monkeypatch.setattr(steps, "CLOSE_SETS", sets)
    for period in equal_stations[:60]:
        found = by_patterns(period, Model.INTEGRATED)
        assert found.objective == found.bound == solve_printed(period, Model.INTEGRATED, 2, LIMITS).objective


def test_the_relaxation_is_a_bound(equal_stations):
    """The bound of the relaxation never exceeds the optimum (without the pods that are there)."""
    for period in equal_stations[:60]:
        reduced = Reduced(period, Model.INTEGRATED)
        if reduced.candidates.any():
            generation = ColumnGeneration(reduced, 2, LIMITS, lambda: None)
            generation.run()
            optimum = solve_printed(period, Model.INTEGRATED, 2, LIMITS).objective - period.visits_before
            assert generation.bound <= optimum + 1e-6


def test_it_is_used_for_equal_stations_only(periods):
    """Other models, a single station, or stations with other room or pods are left to the solver."""
    for period in periods[:50]:
        equal = (
            len(set(period.capacities)) == 1 and len({frozenset(np.flatnonzero(row)) for row in period.covered}) == 1
        )
        assert alike(Reduced(period, Model.INTEGRATED)) == (equal and len(period.stations) > 1)
        assert not alike(Reduced(period, Model.SPLIT_OVER_TIME))


def test_a_time_limit_ends_it_in_order(equal_stations):
    """With no time at all there is a solution all the same, marked as stopped unless it happens to be proven."""
    for period in equal_stations[:40]:
        found = by_patterns(period, Model.INTEGRATED, Limits(max_seconds=1e-9))
        optimum = solve_printed(period, Model.INTEGRATED, 2, LIMITS).objective
        assert found.bound <= optimum <= found.objective
        assert found.stopped_early or found.objective == optimum
