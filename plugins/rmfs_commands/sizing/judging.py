"""Whether a mean is at most a limit, as far as the seeds tell: a sequential test.

Each seed gives one value, and what is asked is whether their mean, over all seeds there could be, is at most a limit.
After the first few seeds, and again after twice as many, and so on, there is a Student t interval for it. A mean passes
as soon as the upper end is at most the limit, and fails as soon as the lower end is above it. K looks have K
chances to err, so that each of the two ends leaves out the K-th part of what the confidence leaves (Bonferroni): of a
mean that is above the limit, the chance that it passes at any look is at most 1 - confidence, and likewise for one
below it that fails; as far as the values are normally distributed, as for any t interval.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import Enum
from statistics import fmean, stdev

from attrs import frozen

FIRST_LOOK = 4
"""Seeds before the first look."""


class Verdict(Enum):
    """A mean with its interval."""

    PASSES = "passes"
    FAILS = "fails"
    UNDECIDED = "undecided"


@frozen
class Estimate:
    """A mean with the ends of its interval, both of which hold at all looks, each with the confidence."""

    mean: float
    low: float
    high: float

    def verdict(self, most: float) -> Verdict:
        """Say whether the mean is at most a limit."""
        if self.high <= most:
            return Verdict.PASSES
        return Verdict.FAILS if self.low > most else Verdict.UNDECIDED


def looks(most_seeds: int) -> tuple[int, ...]:
    """Return after how many seeds to look: `FIRST_LOOK`, twice as many, and so on; last after all."""
    found = [min(FIRST_LOOK, most_seeds)]
    while found[-1] < most_seeds:
        found.append(min(2 * found[-1], most_seeds))
    return tuple(found)


def estimate(values: Sequence[float], confidence: float, n_looks: int) -> Estimate:
    """Return the mean of at least two values with its interval.

    Parameters
    ----------
    values
        One a seed.
    confidence
        With which each end of the interval holds at all looks.
    n_looks
        How often one looks at most.
    """
    from scipy.stats import t  # imported here: it takes a while

    mean = fmean(values)
    quantile = float(t.ppf(1 - (1 - confidence) / n_looks, len(values) - 1))
    half = quantile * stdev(values) / math.sqrt(len(values))
    return Estimate(mean, mean - half, mean + half)
