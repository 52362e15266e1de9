"""The sequential test: when it looks, its interval by hand, and how often it errs."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_commands.sizing.judging import Estimate, Verdict, estimate, looks


@pytest.mark.parametrize(
    ("seeds", "expected"), [(2, (2,)), (4, (4,)), (5, (4, 5)), (16, (4, 8, 16)), (20, (4, 8, 16, 20))]
)
def test_looks_come_after_twice_as_many_seeds(seeds: int, expected: tuple[int, ...]) -> None:
    """From four on, and at the end."""
    assert looks(seeds) == expected


def test_the_interval_by_hand() -> None:
    """Mean 10, standard deviation 2, four seeds: the 95 % quantile of Student's t with 3 degrees is 2.353.

    With two looks each has half of the 5 %, and the quantile is 3.182.
    """
    values = [8.0, 8.0, 12.0, 12.0]
    once, twice = estimate(values, 0.95, 1), estimate(values, 0.95, 2)
    error = (16 / 3) ** 0.5 / 2
    assert (once.mean, once.low, once.high) == pytest.approx((10, 10 - 2.3534 * error, 10 + 2.3534 * error), abs=1e-3)
    assert twice.high == pytest.approx(10 + 3.1824 * error, abs=1e-3)


@pytest.mark.parametrize(
    ("most", "verdict"),
    [(12, Verdict.PASSES), (11, Verdict.PASSES), (10, Verdict.UNDECIDED), (9, Verdict.UNDECIDED), (8.9, Verdict.FAILS)],
)
def test_a_verdict_needs_a_whole_interval(most: float, verdict: Verdict) -> None:
    """Passes when all of it is at most the limit, fails when all of it is above."""
    assert Estimate(10, 9, 11).verdict(most) is verdict


def test_it_errs_no_more_often_than_it_says() -> None:
    """Of means a trifle above the limit at most 5 % pass at any of three looks; and not all of that is given away."""
    random = np.random.default_rng(1)
    passed = 0
    for _ in range(400):
        values = random.normal(100.001, 15, 16).tolist()
        verdicts = [estimate(values[:n], 0.95, 3).verdict(100) for n in looks(16)]
        passed += next((one for one in verdicts if one is not Verdict.UNDECIDED), None) is Verdict.PASSES
    assert 0.015 * 400 < passed < 0.06 * 400
