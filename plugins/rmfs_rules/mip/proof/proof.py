"""State of a proof of a period: the best solution so far and a bound, until they meet."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from attrs import define, evolve

from rmfs_rules.mip.period.placing import short_of
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Part, Solution, Visits, is_useful, is_whole, newly_split, unused
from rmfs_rules.mip.printed.solver import Limits, Outcome
from rmfs_rules.mip.proof.program import Program

SHARE_OF_SOLVER = 20
"""The part of what is left of the effort that a program of the whole period may take, the last resort."""
SHARE_ALIKE = 160
"""The same where the stations are alike, and no other step proves much: branch and bound drowns in symmetry there."""


@define
class Proof:
    """The state of a proof; `proof.steps` has what changes it.

    Parameters
    ----------
    reduced
        The period.
    weight
        W_u.
    limits
        Solver and limits.
    splits
        How many orders may newly be split; None for any number.
    steps
        Steps, tried in this order: each may offer solutions and raise the bound.
    bound
        No solution has a smaller objective (1).
    best
        The best solution so far; None before the first.
    deadline
        When to stop, by the monotonic clock; None for never.
    """

    reduced: Reduced
    weight: float
    limits: Limits
    splits: int | None = None
    steps: Sequence[Callable[[Proof], None]] = ()
    bound: float = float("-inf")
    best: Solution | None = None
    deadline: float | None = None

    def run(self) -> Solution:
        """Return an optimal solution (or, where a limit comes first, the best found, marked so)."""
        if self.limits.max_seconds is not None:
            self.deadline = time.monotonic() + self.limits.max_seconds
        self.bound = float(self.reduced.period.visits_before)
        for step in self.steps:
            step(self)
            if self.proven:
                break
        bound = self.incumbent.objective if self.proven else min(self.bound, self.incumbent.objective)
        if self.incumbent.bound != bound:
            self.best = evolve(self.incumbent, bound=bound)
        if not self.proven:
            self.best = evolve(self.incumbent, how=self.unproven)
        return self.incumbent

    @property
    def unproven(self) -> str:
        """Value of `Solution.how` without a proof."""
        return "effort" if self.limits.effort.short else "stopped"

    @property
    def incumbent(self) -> Solution:
        """The best solution so far."""
        assert self.best is not None
        return self.best

    @property
    def proven(self) -> bool:
        """Whether there is a solution, and nothing can be better."""
        if self.best is None:
            return False
        step = 1 - 1e-6 if self.whole else 1e-6
        return self.best.objective - self.bound < step

    @property
    def whole(self) -> bool:
        """Whether the objective is always a whole number."""
        return is_whole(self.weight)

    @property
    def hard(self) -> bool:
        """Whether searches prove little: for fractional weights, and limited splits between stations that are alike."""
        return not self.whole or (self.splits is not None and self.reduced.interchangeable)

    @property
    def seconds_left(self) -> float | None:
        """Rest of the time limit."""
        return None if self.deadline is None else self.deadline - time.monotonic()

    def solve(self, program: Program, absolute_gap: float) -> Outcome:
        """Hand a program of the whole period to the solver, with a share of the effort.

        Parameters
        ----------
        program
            The program.
        absolute_gap
            Distance between objective and bound that counts as proven.
        """
        hopeless = self.hard and self.reduced.interchangeable and len(self.reduced.capacities) > 1
        effort = self.limits.effort
        with effort.share(effort.left / (SHARE_ALIKE if hopeless else SHARE_OF_SOLVER)) as part:
            limits = evolve(self.limits, effort=part)
            return program.solve(limits, absolute_gap=absolute_gap, seconds=self.seconds_left)

    def offer(self, visits: Visits, parts: tuple[Part, ...], how: str) -> None:
        """Keep a solution if it is better, splits no more orders than allowed, and the pods have enough for it.

        Parameters
        ----------
        visits
            New visits; those of pods that are there, or of no use for the parts, are left out.
        parts
            Assigned lines.
        how
            Step that found it; see `Solution.how`.
        """
        period = self.reduced.period
        before = {(pod, s) for s, pods in enumerate(period.inbound) for pod in pods}
        used = {(pod, s) for pod, s in visits if is_useful(period, pod, s, parts)} - before
        value = period.visits_before + len(used) + self.weight * unused(period, parts)
        if self.best is not None and value >= self.best.objective:
            return
        if self.splits is not None and len(newly_split(period, parts)) > self.splits:
            return
        if not len(self.reduced.scarce) or short_of(period, visits, parts) is None:
            self.best = Solution(parts, tuple(sorted(before | used)), value, self.bound, how)
