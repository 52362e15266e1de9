"""Tie-breaks reach the best second objective among all optima, and never give up the first."""

from __future__ import annotations

import numpy as np
import pytest
from attrs import evolve
from rmfs_mip.check import violation
from rmfs_mip.period import Period, Stock
from rmfs_mip.search import search_for
from rmfs_mip.solution import Model
from rmfs_mip.solver import Limits
from rmfs_mip.ties import break_ties, demand_covered, seniority


@pytest.mark.parametrize("packing_capacity", [None, 1])
@pytest.mark.parametrize("model", Model)
def test_first_objective_is_kept_and_second_not_worse(periods, model, packing_capacity):
    """Each tie-break is an optimum of (1), and no other tie-break's solution is better at its own objective."""
    for period in periods[::3]:
        found = {}
        for tie_break in ("solver", "oldest", "demand"):
            search = search_for(period, model, 2, Limits(), packing_capacity)
            first = search.run()
            found[tie_break] = break_ties(search, tie_break)
            assert found[tie_break].objective == first.objective
            assert violation(period, found[tie_break], model, 2, packing_capacity) is None
        for other in found.values():
            assert seniority(period, found["oldest"].parts) >= seniority(period, other.parts)
            assert demand_covered(period, found["demand"].visits) >= demand_covered(period, other.visits)


@pytest.mark.parametrize("model", Model)
def test_preferred_pods_cost_nothing(periods, model):
    """Whatever pods are preferred, the objective is the optimum."""
    rng = np.random.default_rng(1)
    for period in periods[::3]:
        optimum = search_for(period, model, 2, Limits(), None).run().objective
        n = len(period.stock.pods)
        for preference in (np.ones(n), 1 - period.idle, rng.random(n)):
            preferring = evolve(period, preference=preference)
            solution = search_for(preferring, model, 2, Limits(), None).run()
            assert solution.objective == optimum
            assert violation(preferring, solution, model, 2, None) is None


@pytest.mark.parametrize("model", Model)
@pytest.mark.parametrize("preferred", range(3))
def test_of_pods_alike_the_preferred_one_is_sent(model, preferred):
    """Three pods have the one SKU that is wanted; the preferred one serves the order."""
    period = Period(
        stock=Stock(pods=(0, 1, 2), contents=((0,), (0,), (0,)), n_skus=1),
        stations=(0,),
        capacities=(1,),
        inbound=((),),
        orders=(0,),
        line_order=[0],
        line_sku=[0],
        line_quantity=[1],
        preference=np.eye(3)[preferred],
    )
    assert search_for(period, model, 2, Limits(), None).run().visits == ((preferred, 0),)
