"""All steps together find the optimum of the printed models, and every solution satisfies their constraints."""

from __future__ import annotations

import pytest

from rmfs_rules.mip.period.solution import Model, newly_split
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.models import solve_printed
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.steps import proof_of

LIMITS = Limits()
SPLIT = (Model.SPLIT_AMONG_STATIONS, Model.SPLIT_OVER_TIME)


@pytest.mark.parametrize("model", Model)
def test_both_formulations_agree(periods, model):
    """The aggregated form has the objective of the printed form on 300 random periods."""
    for seed, period in enumerate(periods):
        printed = solve_printed(period, model, 2, LIMITS)
        aggregated = proof_of(period, model, 2, LIMITS).run()
        assert aggregated.objective == printed.objective, seed
        assert aggregated.bound == aggregated.objective
        for solution in (printed, aggregated):
            assert violation(period, solution, model, 2) is None, seed


@pytest.mark.parametrize("packing_capacity", [0, 1, 2])
@pytest.mark.parametrize("model", SPLIT)
def test_both_formulations_agree_on_packing_capacity(periods, model, packing_capacity):
    """So they do where the packing stations limit the split orders (60 of them)."""
    for seed, period in enumerate(periods[packing_capacity::5]):
        printed = solve_printed(period, model, 2, LIMITS, packing_capacity)
        aggregated = proof_of(period, model, 2, LIMITS, packing_capacity).run()
        assert aggregated.objective == printed.objective, seed
        for solution in (printed, aggregated):
            assert violation(period, solution, model, 2, packing_capacity) is None, seed


@pytest.mark.parametrize("weight", [0.5, 1.0, 1.5, 4.0])
def test_both_formulations_agree_on_other_weights(periods, weight):
    """W_u may be anything: below 1 a free place may be cheaper than a pod, fractions leave the whole numbers."""
    for seed, period in enumerate(periods[::10]):
        for model in Model:
            printed = solve_printed(period, model, weight, LIMITS)
            aggregated = proof_of(period, model, weight, LIMITS).run()
            assert aggregated.objective == pytest.approx(printed.objective), (seed, model)


@pytest.mark.parametrize("model", Model)
def test_brute_force_finds_nothing_better(periods, brute_force, model):
    """On the periods with few decisions, the optimum is that over all assignments."""
    few = [period for period in periods if (len(period.stations) + 1) ** len(period.line_sku) <= 3000]
    assert len(few) > 50
    for period in few:
        solution = proof_of(period, model, 2, LIMITS).run()
        assert solution.objective == brute_force(period, model, 2)


@pytest.mark.parametrize("solver", ["highs", "cbc"])
def test_solvers_agree(periods, solver):
    """HiGHS and CBC find the same objective."""
    for period in periods[::20]:
        for model in Model:
            reference = proof_of(period, model, 2, LIMITS).run().objective
            assert proof_of(period, model, 2, Limits(solver)).run().objective == reference


@pytest.mark.parametrize(
    "splits", [0, pytest.param(1, marks=pytest.mark.slow), pytest.param(2, marks=pytest.mark.slow)]
)
def test_few_splits(splitting_period, splits):
    """It has the objective of the printed model, with and without begun orders and pods at the stations."""
    among, limited = Model.SPLIT_AMONG_STATIONS, 0
    for seed in range(12):
        period = splitting_period(seed, orders=7, stations=3, skus=9)
        capacity = splits + period.split_open
        solution = proof_of(period, among, 2, LIMITS, capacity).run()
        assert solution.objective == solve_printed(period, among, 2, LIMITS, capacity).objective, seed
        assert solution.bound == solution.objective
        assert violation(period, solution, among, 2, capacity) is None
        assert len(newly_split(period, solution.parts)) <= splits
        limited += solution.objective > proof_of(period, among, 2, LIMITS).run().objective
    assert limited > 0


def test_propositions(periods):
    """Always feasible; splitting among stations never costs more, splitting over time never more than that."""
    for period in periods:
        values = [proof_of(period, model, 2, LIMITS).run().objective for model in Model]
        assert values == sorted(values, reverse=True)


def test_same_period_same_solution(random_period):
    """A solve is repeatable."""
    for seed in range(20):
        for model in Model:
            first, second = (proof_of(random_period(seed), model, 2, LIMITS).run() for _ in range(2))
            assert first == second


def test_a_time_limit_is_told(random_period):
    """A solve that a limit ends says so, and its bound lies below its objective."""
    stopped = 0
    for seed in range(2, 300, 3):
        period = random_period(seed)
        solution = proof_of(period, Model.SPLIT_OVER_TIME, 2, Limits(max_seconds=1e-9), 1).run()
        assert violation(period, solution, Model.SPLIT_OVER_TIME, 2, 1) is None
        assert solution.stopped_early == (solution.bound < solution.objective)
        stopped += solution.stopped_early
    assert stopped
