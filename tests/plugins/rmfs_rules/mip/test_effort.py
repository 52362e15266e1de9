"""Periods with a limited effort."""

import pytest
from attrs import evolve

from cases import cases
from mip_periods import brute_force, brute_force_from_stock, random_period, scarce_period, splitting_period
from rmfs_rules.mip.period.effort import EFFORT, EFFORT_HARD, EFFORT_LARGE, Effort
from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.solution import Model
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.steps import proof_of

SPLIT = (Model.SPLIT_AMONG_STATIONS, Model.SPLIT_OVER_TIME)
MANY = pytest.param(range(60, 160), marks=pytest.mark.slow, id="many")


def ended(period, model, steps, brute_force=None, splits=None, weight=2):
    """Return what a budget of steps comes to; it satisfies the constraints, and the optimum is in its bounds."""
    capacity = None if splits is None else period.split_open + splits
    solution = proof_of(period, model, weight, Limits(effort=Effort(steps)), capacity).run()
    assert violation(period, solution, model, weight, capacity) is None
    assert (solution.how == "effort") == (solution.bound < solution.objective)
    assert brute_force is None or solution.bound <= brute_force(period, model, weight, splits) <= solution.objective
    return solution


@pytest.mark.parametrize("steps", [0, 3000])
@pytest.mark.parametrize("model", Model)
def test_little_effort_leaves_a_bound_and_a_solution(small_periods, model, steps):
    """The bound is never above the optimum, nor the solution below it; a period without proof says so."""
    some = small_periods[:: 1 if steps == 0 else 3]
    found = [ended(period, model, steps, brute_force).how for period in some]
    assert "effort" in found or steps


SPLITS = [(model, splits, range(380, 700)) for model in SPLIT for splits in range(3)]


@cases(
    "model splits seeds",
    *((model, None, range(30)) for model in Model),
    *(pytest.param(model, None, range(60, 380), marks=pytest.mark.slow) for model in Model),
    *(pytest.param(*case, marks=pytest.mark.slow) for case in SPLITS),
)
def test_little_effort_with_few_items(model, splits, seeds):
    for seed in seeds:
        ended(scarce_period(seed), model, 0, brute_force_from_stock, splits)


@pytest.mark.parametrize("seeds", [pytest.param(range(4), id="some"), MANY])
@pytest.mark.parametrize("splits", [0, 1])
def test_little_effort_with_few_splits(splits, seeds):
    for seed in seeds:
        period = splitting_period(seed, orders=4, stations=2, skus=6)
        for model in SPLIT:
            for weight in (1.5, 2):
                ended(period, model, 0, brute_force, splits, weight)


@pytest.mark.parametrize("weight", [0.5, 1.0, 1.5])
def test_other_weights(small_periods, weight):
    """Bounds hold where a free slot may be better than a visit."""
    for period in small_periods[::5]:
        for model in Model:
            ended(period, model, 0, brute_force, weight=weight)


def test_effort_that_is_enough_or_the_same(small_periods):
    for period in small_periods[::7]:
        for model in Model:
            limited = Effort.for_period(period, None)
            solution = proof_of(period, model, 2, Limits(effort=limited)).run()
            assert solution == proof_of(period, model, 2, Limits()).run()
            assert solution.bound == solution.objective
            assert not limited.short
    for steps in (0, 500, 5000, 50_000):
        for seed in range(6):
            period = splitting_period(seed, orders=9, stations=3, skus=9)
            for model in Model:
                assert ended(period, model, steps) == ended(evolve(period), model, steps)


def test_large_periods_get_less():
    """By default a period with more pods or SKUs than the paper's gets less effort."""
    period = random_period(1)
    more = Period(Stock(tuple(range(101)), ((0,),) * 101, 1), (0,), (1,), ((),), (0,), [0], [0], [1])
    assert Effort.for_period(period, None).left == EFFORT
    assert Effort.for_period(more, None).left == EFFORT_LARGE
    assert Effort.for_period(more, 7).left == 7


@cases("weight capacity effort", (2, None, EFFORT), (1.5, None, EFFORT_HARD), (2, 3, EFFORT_HARD))
def test_periods_without_hope_of_a_proof_get_less(weight, capacity, effort):
    """By default fractional weights, and few splits between stations that are alike, get less effort."""
    period = random_period(1)
    alike = evolve(period, inbound=((),) * len(period.stations), capacities=(6,) * len(period.stations))
    proof = proof_of(alike, Model.SPLIT_AMONG_STATIONS, weight, Limits(), capacity)
    assert Effort.for_period(alike, None, hard=proof.hard).left == effort
