"""The optimum by one value of the objective after another, against trying everything."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.models import solve_printed
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.fewest import FewestVisits
from rmfs_rules.mip.proof.steps import proof_of

AMONG = Model.SPLIT_AMONG_STATIONS
WHOLE = (Model.INTEGRATED, AMONG)
ENDLESS = 10**9


@pytest.mark.parametrize("model", WHOLE)
def test_it_finds_the_optimum_by_itself(all_periods, brute_force, model):
    """Without any bound to start from, its value is the optimum of the brute force."""
    tried = 0
    for period in all_periods:
        reduced = Reduced(period, model)
        if (len(period.stations) + 1) ** len(period.line_sku) > 3000 or not reduced.candidates.any():
            continue
        least = period.visits_before + 2 * (sum(period.capacities) - reduced.reachable_sum)
        nothing = 2 * reduced.reachable_sum
        value, _ = FewestVisits(reduced, 2, ENDLESS).run(0, nothing)
        assert least + value == brute_force(period, model, 2)
        tried += 1
    assert tried > 50


@pytest.mark.parametrize("splits", [0, 1])
def test_it_finds_the_optimum_with_few_splits(small_periods, brute_force, splits):
    """Without any bound to start from, its value is the optimum of the brute force."""
    mattered = 0
    for period in small_periods:
        reduced = Reduced(period, AMONG)
        least = period.visits_before + 2 * (sum(period.capacities) - reduced.reachable_sum)
        value, found = FewestVisits(reduced, 2, ENDLESS, splits).run(0, 2 * reduced.reachable_sum)
        assert least + value == brute_force(period, AMONG, 2, splits)
        mattered += value > FewestVisits(reduced, 2, ENDLESS).run(0, 2 * reduced.reachable_sum)[0]
        if found is not None:
            proof = proof_of(period, AMONG, 2, Limits(), splits + period.split_open)
            proof.offer((), (), "bounds")
            proof.offer(*found, "search")
            assert proof.incumbent.objective == least + value
            assert violation(period, proof.incumbent, AMONG, 2, splits + period.split_open) is None
    assert mattered > 5


def test_giving_up_proves_nothing_false(all_periods, brute_force):
    """With few steps, what it returns is still a lower bound, and it says so by returning no solution."""
    gave_up = 0
    for period in all_periods:
        reduced = Reduced(period, AMONG)
        if (len(period.stations) + 1) ** len(period.line_sku) > 3000 or not reduced.candidates.any():
            continue
        least = period.visits_before + 2 * (sum(period.capacities) - reduced.reachable_sum)
        for most_work in (0, 5, 15, 40):
            value, found = FewestVisits(reduced, 2, most_work).run(0, 2 * reduced.reachable_sum)
            optimum = brute_force(period, AMONG, 2)
            assert least + value <= optimum
            gave_up += found is None and least + value < optimum
    assert gave_up > 20


@pytest.mark.parametrize("stations", [6, 7, 8])
def test_many_stations(stations):
    """Up to seven stations fit the packed vectors; with more, the search stays out and the optimum is found as well."""
    rng = np.random.default_rng(stations)
    lines = [(order, int(sku), 1) for order in range(9) for sku in rng.choice(8, 2, replace=False)]
    period = Period(
        Stock(tuple(range(6)), tuple((sku, (sku + 3) % 8) for sku in range(6)), 8),
        tuple(range(stations)),
        (2, *[1] * (stations - 1)),
        tuple((int(pod),) for pod in rng.integers(0, 6, stations)),
        tuple(range(9)),
        *np.array(lines).T,
    )
    search = FewestVisits(Reduced(period, AMONG), 2, ENDLESS)
    assert search.possible == (stations <= 7)
    optimum = solve_printed(period, AMONG, 2, Limits()).objective
    assert proof_of(period, AMONG, 2, Limits()).run().objective == optimum
    if search.possible:
        least = period.visits_before + 2 * (sum(period.capacities) - search.reduced.reachable_sum)
        assert least + search.run(0, 100)[0] == optimum


@pytest.mark.parametrize("seed", [13, 19, 27])
def test_pods_are_exchanged_until_no_fewer_do(seed):
    """Seven visits are found of up to 31, and the orders are served as the model says."""
    rng = np.random.default_rng(seed)
    contents = tuple(tuple(sorted(rng.choice(150, 6, replace=False).tolist())) for _ in range(80))
    lines = [(o, int(i), 1) for o in range(80) for i in sorted(rng.choice(150, rng.integers(1, 5), replace=False))]
    period = Period(
        Stock(tuple(range(80)), contents, 150),
        (0, 1, 2),
        (12, 12, 12),
        ((), (), ()),
        tuple(range(80)),
        *np.array(lines).T,
    )
    found = FewestVisits(Reduced(period, AMONG), 2, 0).quickly(1, 32)
    proof = proof_of(period, AMONG, 2, Limits())
    proof.offer(*found, "greedy")
    assert violation(period, proof.incumbent, AMONG, 2) is None
    assert len(found[0]) == 7
