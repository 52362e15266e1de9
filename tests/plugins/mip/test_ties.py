"""Tie-breaks reach the best second objective among all optima, and never give up the first."""

from __future__ import annotations

import pytest
from rmfs_mip.check import violation
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
