"""The printed models against trying everything."""

from __future__ import annotations

import pytest

from rmfs_rules.mip.period.solution import Model
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.models import solve_printed
from rmfs_rules.mip.printed.solver import Limits


@pytest.mark.parametrize("room", [None, 0, 2], ids=lambda room: f"packing capacity {room}")
@pytest.mark.parametrize("model", Model)
def test_their_optimum_is_the_least_of_all_assignments(periods, brute_force, model, room):
    """With and without a limit on split orders, on periods with few decisions."""
    few = [period for period in periods[::2] if (len(period.stations) + 1) ** len(period.line_sku) <= 1000]
    assert len(few) > 20
    for period in few:
        splits = None if room is None or model is Model.INTEGRATED else max(room - period.split_open, 0)
        solution = solve_printed(period, model, 2, Limits(), room)
        assert solution.objective == solution.bound == brute_force(period, model, 2, splits)
        assert violation(period, solution, model, 2, room) is None


def test_a_limit_before_any_solution(random_period):
    """Then nothing is assigned, and the bound that is known lies below the objective."""
    for seed in range(10):
        period = random_period(seed)
        solution = solve_printed(period, Model.INTEGRATED, 2, Limits(max_seconds=1e-9))
        assert violation(period, solution, Model.INTEGRATED, 2) is None
        assert solution.bound <= solution.objective
