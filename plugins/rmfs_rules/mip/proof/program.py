"""Mixed-integer programs as plain lists of columns and rows, which python-mip gets in one go.

An expression object for each row would take longer to build than many of the programs take to solve.
"""

from __future__ import annotations

from typing import Any

import mip
from attrs import define, field

from rmfs_rules.mip.period.effort import NODES
from rmfs_rules.mip.printed.solver import Limits, Outcome, new_model, optimise

ENTRIES = 4
"""The root counts the square of a program's entries by this of the effort."""
MOST_NODES = 1_000_000
"""More nodes than any solve takes."""


@define
class Program:
    """A program to be minimised; its columns are variables from 0 upwards.

    Parameters
    ----------
    upper, cost, whole
        Of each column: its upper bound, its factor in the objective, and whether it takes whole numbers only.
    rows
        Columns, their factors, ``"<"``, ``">"`` or ``"="``, and the right side.
    constant
        Constant part of the objective.
    """

    upper: list[float] = field(factory=list)
    cost: list[float] = field(factory=list)
    whole: list[bool] = field(factory=list)
    rows: list[tuple[list[int], list[float], str, float]] = field(factory=list)
    constant: float = 0.0

    def column(self, cost: float = 0.0, upper: float = 1.0, *, whole: bool = True) -> int:
        """Add a variable between 0 and ``upper``; return its number."""
        self.upper.append(upper)
        self.cost.append(cost)
        self.whole.append(whole)
        return len(self.cost) - 1

    def row(self, columns: list[int], factors: list[float], sense: str, right: float) -> None:
        """Add ``sum of factors * columns  sense  right`` with sense ``"<"``, ``">"`` or ``"="``."""
        self.rows.append((columns, factors, sense, right))

    @property
    def steps(self) -> int:
        """Effort of the root of branch and bound."""
        return sum(len(columns) for columns, _, _, _ in self.rows) ** 2 // ENTRIES

    def _nodes(self, limits: Limits) -> int | None:
        """Return how many nodes the effort allows; None for any number. The root is taken from it."""
        effort = limits.effort
        if effort.left == float("inf"):
            return None
        if not effort.allows(self.steps):
            return 0
        effort.take(self.steps)
        return min(int(effort.left * NODES / max(self.steps, 1)) + 1, MOST_NODES)

    def solve(self, limits: Limits, *, absolute_gap: float = 1e-6, seconds: float | None = None) -> Outcome:
        """Hand the program to the solver.

        Parameters
        ----------
        limits
            Which solver, and when it stops.
        absolute_gap
            Distance between objective and bound that counts as proven.
        seconds
            Seconds left of `Limits.max_seconds`.
        """
        nodes = self._nodes(limits)
        if nodes == 0:
            return Outcome(None, float("inf"), float("-inf"), optimal=False)
        model = new_model(limits)
        kinds = [mip.INTEGER if whole else mip.CONTINUOUS for whole in self.whole]
        variables: list[Any] = [
            model.add_var(lb=0.0, ub=upper, obj=cost, var_type=kind)
            for upper, cost, kind in zip(self.upper, self.cost, kinds, strict=True)
        ]
        for columns, factors, sense, right in self.rows:
            model.add_constr(mip.LinExpr([variables[c] for c in columns], factors, -right, sense))
        outcome = optimise(model, limits, absolute_gap=absolute_gap, seconds=seconds, nodes=nodes)
        if nodes is not None and not outcome.optimal and outcome.bound < float("inf"):
            limits.effort.take(nodes * self.steps / NODES)
            limits.effort.short = True
        return Outcome(
            outcome.values, outcome.objective + self.constant, outcome.bound + self.constant, outcome.optimal
        )
