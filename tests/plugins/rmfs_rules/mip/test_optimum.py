"""The optimum: both formulations and all steps of the proof against trying everything, and against each other."""

from itertools import product

import numpy as np
import pytest
from attrs import evolve

from mip_periods import (
    brute_force,
    brute_force_from_stock,
    putwall_period,
    random_period,
    scarce_period,
    splitting_period,
)
from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model, Solution, newly_split
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.models import solve_printed
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.parts import with_joining_lines
from rmfs_rules.mip.proof.steps import by_nothing, by_solver, proof_of

LIMITS = Limits()
SPLIT = (Model.SPLIT_AMONG_STATIONS, Model.SPLIT_OVER_TIME)
BY_PROGRAM = (by_nothing, by_solver)
"""The aggregated form by itself, without any step before it."""


def optimum(period: Period, model: Model, capacity: int | None = None, weight: float = 2, steps=None) -> Solution:
    """Return the proven solution of the aggregated form, which satisfies the printed constraints."""
    solution = proof_of(period, model, weight, LIMITS, capacity, steps=steps).run()
    assert solution.bound == pytest.approx(solution.objective)
    assert violation(period, solution, model, weight, capacity) is None
    return solution


@pytest.mark.parametrize("capacity", [None, 0, 1, 2], ids=lambda room: f"packing capacity {room}")
@pytest.mark.parametrize("model", Model)
def test_all_ways_agree(periods, model, capacity):
    """Printed and aggregated form have one objective, that of the brute force where there are few decisions."""
    tried = 0
    for number, period in enumerate(periods if capacity is None else periods[capacity::5]):
        printed = solve_printed(period, model, 2, LIMITS, capacity)
        assert printed.objective == printed.bound == optimum(period, model, capacity).objective, number
        assert violation(period, printed, model, 2, capacity) is None, number
        if capacity is not None or number % 5 == 0:
            assert optimum(period, model, capacity, steps=BY_PROGRAM).objective == printed.objective, number
        if (len(period.stations) + 1) ** len(period.line_sku) <= 3000:
            splits = None if capacity is None or model is Model.INTEGRATED else max(capacity - period.split_open, 0)
            assert printed.objective == brute_force(period, model, 2, splits), number
            tried += 1
    assert tried > 10


@pytest.mark.parametrize("many", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["some", "many"])
@pytest.mark.parametrize(("model", "room"), [*product(Model, [None]), *product(SPLIT, [0, 1, 2])])
@pytest.mark.parametrize("make", [scarce_period, putwall_period])
def test_all_ways_agree_on_other_periods(make, model, room, many):
    """Where pods run out, or stations count orders; with room for so many new splits."""
    scarce = at_once = 0
    first = 60 if many else 40 * (room is not None and make is scarce_period)
    seeds = range(first, first + (100 if room is not None else 320)) if many else range(first, first + 16)
    for seed in seeds:
        period = make(seed)
        capacity = None if room is None else period.split_open + room
        best = brute_force_from_stock(period, model, 2, room)
        printed = solve_printed(period, model, 2, LIMITS, capacity)
        found = optimum(period, model, capacity)
        for solution in (printed, found, optimum(period, model, capacity, steps=BY_PROGRAM)):
            joined = with_joining_lines(period, solution, model)
            assert solution.objective == solution.bound == joined.objective == best, seed
            assert violation(period, solution, model, 2, capacity) is None, seed
            assert violation(period, joined, model, 2, capacity) is None, seed
        scarce += len(Reduced(period, model).scarce) > 0
        at_once += found.how == "bounds"
    assert scarce > len(seeds) / 6
    assert at_once < len(seeds)


@pytest.mark.parametrize("weight", [0.5, 1.0, 1.5, 4.0])
def test_all_ways_agree_on_other_weights(periods, scarce_periods, weight):
    """W_u may be anything: below 1 a free slot may be cheaper than a pod, fractions leave the whole numbers."""
    for model in Model:
        for period in periods[::10]:
            printed = solve_printed(period, model, weight, LIMITS).objective
            assert optimum(period, model, weight=weight).objective == pytest.approx(printed)
        for period in scarce_periods[::8]:
            best = brute_force_from_stock(period, model, weight)
            assert optimum(period, model, weight=weight).objective == pytest.approx(best)


@pytest.mark.parametrize("splits", [0, *(pytest.param(splits, marks=pytest.mark.slow) for splits in (1, 2))])
def test_few_splits(splits):
    """It has the objective of the printed model, with and without begun orders and pods at the stations."""
    among, limited = Model.SPLIT_AMONG_STATIONS, 0
    for seed in range(12):
        period = splitting_period(seed, orders=7, stations=3, skus=9)
        capacity = splits + period.split_open
        solution = optimum(period, among, capacity)
        assert solution.objective == solve_printed(period, among, 2, LIMITS, capacity).objective, seed
        assert len(newly_split(period, solution.parts)) <= splits
        limited += solution.objective > optimum(period, among).objective
    assert limited > 0


@pytest.mark.parametrize("model", Model)
def test_plentiful_stock_is_unlimited_stock(periods, model):
    """Where each pod has as much as the period can take from it, the solution is the same to the last visit."""
    for period in periods[::3]:
        most = sum(period.capacities)
        stock = Stock.counted([dict.fromkeys(skus, most) for skus in period.stock.contents], period.stock.n_skus)
        plentiful = evolve(period, stock=stock)
        assert not len(Reduced(plentiful, model).scarce)
        assert optimum(plentiful, model) == optimum(period, model)


def test_pods_share_lines_and_items():
    """Three items of a line come from two pods; a pod at two stations has an item for two orders, wherever they go."""
    line, lines = np.array([[0, 0, 3]]).T, np.array([[order, 0, 1] for order in range(3)]).T
    large = Period(Stock.counted([{0: 2}, {0: 1}, {0: 1}], 1), (0,), (3,), ((),), (0,), *line)
    shared = Period(Stock.counted([{0: 2}], 1), (0, 1), (2, 2), ((0,), (0,)), (0, 1, 2), *lines)
    for model in Model:
        solution = optimum(large, model)
        assert (solution.objective, len(solution.visits)) == (2, 2)
        assert (0, 0) in solution.visits
        solution = optimum(shared, model)
        assert (solution.objective, len(solution.parts)) == (6, 2)


def test_solvers_agree_and_repeat(periods):
    """HiGHS and CBC find the same objective, and the same solution again."""
    for period in periods[::20]:
        for model in Model:
            found = optimum(period, model)
            assert found == optimum(evolve(period), model)
            assert proof_of(period, model, 2, Limits("cbc")).run().objective == found.objective


def test_a_time_limit_is_told():
    """A solve that a limit ends says so, and its bound lies below its objective."""
    stopped = 0
    for seed in range(2, 300, 3):
        period = random_period(seed)
        solution = proof_of(period, Model.SPLIT_OVER_TIME, 2, Limits(max_seconds=1e-9), 1).run()
        assert violation(period, solution, Model.SPLIT_OVER_TIME, 2, 1) is None
        assert solution.stopped_early == (solution.bound < solution.objective)
        stopped += solution.stopped_early
    assert stopped
