"""Programs in plain lists."""

from __future__ import annotations

import pytest

from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.program import Program


@pytest.mark.parametrize("solver", ["highs", "cbc"])
def test_a_knapsack(solver):
    """Of items worth 5, 4 and 3 with sizes 4, 3 and 2, room 5 takes the last two."""
    program = Program(constant=10.0)
    columns = [program.column(cost=-worth) for worth in (5.0, 4.0, 3.0)]
    program.row(columns, [4.0, 3.0, 2.0], "<", 5.0)
    outcome = program.solve(Limits(solver))
    assert outcome.optimal
    assert outcome.objective == pytest.approx(outcome.bound) == pytest.approx(3.0)
    assert [round(value) for value in outcome.values] == [0, 1, 1]


def test_a_column_may_take_fractions():
    """Half a unit where whole numbers are not asked for."""
    program = Program()
    column = program.column(cost=-1.0, whole=False)
    program.row([column], [2.0], "<", 1.0)
    assert program.solve(Limits()).values == [pytest.approx(0.5)]


def test_what_is_infeasible_has_no_values():
    """Its bound says that nothing is small enough."""
    program = Program()
    column = program.column()
    program.row([column], [1.0], ">", 2.0)
    outcome = program.solve(Limits())
    assert outcome.values is None
    assert outcome.bound == float("inf")
