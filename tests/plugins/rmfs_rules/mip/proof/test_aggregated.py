"""The aggregated form by itself, without any step before it."""

from __future__ import annotations

import pytest

from rmfs_rules.mip.period.decoding import parts_of
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model, Solution, newly_split, objective_of
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.models import solve_printed
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.aggregated import Builder


@pytest.mark.parametrize("splits", [None, 0, 1])
@pytest.mark.parametrize("model", Model)
def test_it_has_the_optimum_of_the_printed_form(periods, model, splits):
    """What its counts are decoded to satisfies the printed constraints and costs as much (60 periods)."""
    for seed, period in enumerate(periods[::5]):
        reduced = Reduced(period, model)
        if not reduced.candidates.any():
            continue
        aggregated = Builder(reduced, 2, splits).build()
        values = aggregated.program.solve(Limits(), absolute_gap=1e-6).values
        counts = aggregated.counts(values)
        parts = parts_of(reduced, counts)
        visits = {*counts.visits, *((pod, s) for s, pods in enumerate(period.inbound) for pod in pods)}
        value = objective_of(period, parts, len(visits), 2)
        room = None if splits is None else splits + period.split_open
        assert value == solve_printed(period, model, 2, Limits(), room).objective, seed
        found = Solution(parts, tuple(sorted(visits)), value, value, "solver")
        assert violation(period, found, model, 2, room) is None, seed
        assert splits is None or model is Model.INTEGRATED or len(newly_split(period, parts)) <= splits


@pytest.mark.parametrize("model", Model)
def test_nothing_is_better_than_the_optimum(periods, model):
    """Asked for a solution that costs less, it has none; asked for one that costs as much, it has."""
    for period in periods[::20]:
        reduced = Reduced(period, model)
        if not reduced.candidates.any():
            continue
        optimum = solve_printed(period, model, 2, Limits()).objective
        for most in (optimum - 1, optimum):
            builder = Builder(reduced, 2)
            aggregated = builder.build()
            builder.limit_objective(float("-inf"), most)
            assert (aggregated.program.solve(Limits()).values is not None) == (most == optimum)
