"""What is known about the optimum of a period: the best solution so far and a bound, until they meet."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from attrs import define, evolve

from rmfs_mip.period.reduction import Reduced
from rmfs_mip.period.serving import short_of
from rmfs_mip.period.solution import Part, Solution, Visits, is_useful, is_whole, newly_split, unused
from rmfs_mip.printed.solver import Limits


@define
class Proof:
    """The state of a proof; `rmfs_mip.proof.steps` has what changes it.

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
        What is tried, in this order: each may offer solutions and raise the bound.
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
        self.take_steps()
        bound = self.incumbent.objective if self.proven else self.bound
        if self.incumbent.bound != bound:
            self.best = evolve(self.incumbent, bound=bound)
        return self.incumbent

    def take_steps(self) -> None:
        """Take one step after the other, until the best solution is proven."""
        for step in self.steps:
            step(self)
            if self.proven:
                return

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
    def seconds_left(self) -> float | None:
        """What is left of the time limit."""
        return None if self.deadline is None else self.deadline - time.monotonic()

    def offer(self, visits: Visits, parts: tuple[Part, ...], how: str) -> None:
        """Keep a solution if it is better, splits no more orders than allowed, and the pods have enough for it.

        Parameters
        ----------
        visits
            New visits; those of no use for the parts are left out.
        parts
            Assigned lines.
        how
            What found it; see `Solution.how`.
        """
        period = self.reduced.period
        used = {(pod, s) for pod, s in visits if is_useful(period, pod, s, parts)}
        value = period.visits_before + len(used) + self.weight * unused(period, parts)
        if self.best is not None and value >= self.best.objective:
            return
        if self.splits is not None and len(newly_split(period, parts)) > self.splits:
            return
        if not len(self.reduced.scarce) or short_of(period, visits, parts) is None:
            before = {(pod, s) for s, pods in enumerate(period.inbound) for pod in pods}
            self.best = Solution(parts, tuple(sorted(before | used)), value, self.bound, how)
