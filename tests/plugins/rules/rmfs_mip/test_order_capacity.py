"""Stations that count orders: both formulations have the optimum that trying everything finds, and runs end."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rmfs_mip.period.period import Period
from rmfs_mip.period.solution import Model
from rmfs_mip.printed.constraints import violation
from rmfs_mip.printed.models import solve_printed
from rmfs_mip.printed.solver import Limits
from rmfs_mip.proof.parts import with_joining_lines
from rmfs_mip.proof.steps import by_nothing, by_solver, proof_of

LIMITS = Limits()
ROOMS = pytest.mark.parametrize("room", [None, 0, 1], ids=lambda room: f"packing capacity {room}")


def agree(period: Period, model: Model, brute_force: Callable[..., float], room: int | None) -> bool:
    """Hold both formulations against trying everything; return whether no solver was needed."""
    capacity = None if room is None else period.split_open + room
    best = brute_force(period, model, 2, None if model is Model.INTEGRATED else room)
    printed = solve_printed(period, model, 2, LIMITS, capacity)
    aggregated = proof_of(period, model, 2, LIMITS, capacity).run()
    by_program = proof_of(period, model, 2, LIMITS, capacity, steps=(by_nothing, by_solver)).run()
    for solution in (printed, aggregated, by_program):
        assert solution.objective == solution.bound == best
        assert violation(period, solution, model, 2, capacity) is None
        joined = with_joining_lines(period, solution, model)
        assert joined.objective == best
        assert violation(period, joined, model, 2, capacity) is None
    return aggregated.how == "bounds"


@ROOMS
@pytest.mark.parametrize("model", Model)
def test_both_formulations_have_the_optimum(putwall_period, brute_force_from_stock, model, room):
    """With and without a limit on split orders, orders that have a place already, stations of both kinds: a sample."""
    if model is not Model.INTEGRATED or room is None:
        proven = [agree(putwall_period(seed), model, brute_force_from_stock, room) for seed in range(16)]
        assert 0 < sum(proven) < len(proven)


@pytest.mark.slow
@ROOMS
@pytest.mark.parametrize("model", Model)
def test_both_formulations_have_the_optimum_on_many_periods(putwall_period, brute_force_from_stock, model, room):
    """On 320 periods without that limit, on 100 with."""
    if model is not Model.INTEGRATED or room is None:
        for seed in range(20, 340) if room is None else range(340, 440):
            agree(putwall_period(seed), model, brute_force_from_stock, room)
