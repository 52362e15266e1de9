"""How much may be done to prove a period: a budget in steps, which is used up alike on every machine."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import inf

from attrs import define

from rmfs_rules.mip.period.period import Period

PAPER_PODS, PAPER_SKUS = 100, 100
"""Pods and SKUs of the paper's largest instances."""
EFFORT = 1_200_000_000
"""Effort of a period up to that size by default: more than any of the paper's evaluation takes."""
EFFORT_HARD = 180_000_000
"""The same where more of it hardly ever ends in a proof."""
EFFORT_LARGE = 2_000_000
"""Effort of a larger one: a second or two of a usual core."""
NODES = 16
"""Nodes of branch and bound that take a solver about as much as the root."""


def is_large(period: Period) -> bool:
    """Whether a period has more pods or SKUs than the paper's largest."""
    return len(period.stock.pods) > PAPER_PODS or period.stock.n_skus > PAPER_SKUS


@define
class Effort:
    """Rest of the budget of a period.

    A step is about as much as a core does in a microsecond: one of a compiled search with a hundred pods. A solver
    takes about the square of the entries of a program, as much again for every `NODES` nodes.

    Parameters
    ----------
    left
        Steps left; infinite for no limit.
    short
        Whether something was left undone for want of steps.
    """

    left: float = inf
    short: bool = False

    @classmethod
    def for_period(cls, period: Period, steps: int | None, *, hard: bool = False) -> Effort:
        """Return the budget of a period.

        Parameters
        ----------
        period
            The period.
        steps
            How much; None for what its size allows.
        hard
            Whether it is of a kind that searches do not prove.
        """
        if steps is None:
            small = EFFORT_HARD if hard else EFFORT
            steps = EFFORT_LARGE if is_large(period) else small
        return cls(float(steps))

    @contextmanager
    def share(self, most: float) -> Iterator[Effort]:
        """Yield a budget of its own for a step that shall not take more than ``most``; what it uses is taken."""
        part = Effort(min(self.left, most))
        before = part.left
        yield part
        if self.left < inf:
            self.take(before - part.left)
        self.short |= part.short

    def take(self, steps: float) -> None:
        """Take steps that were done."""
        self.left = max(self.left - steps, 0.0)

    def allows(self, steps: float) -> bool:
        """Whether so many steps are left; if not, take note of it."""
        self.short |= steps > self.left
        return steps <= self.left

    def most(self, limit: int, price: float = 1.0) -> int:
        """Return how many steps of a search, at most a limit, can be done at a price each."""
        return limit if self.left == inf else min(limit, int(self.left / price))
