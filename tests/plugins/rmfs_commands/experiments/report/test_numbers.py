"""Figures of a comparison as people read them."""

from __future__ import annotations

import pytest

from rmfs_commands.experiments.compare import Interval
from rmfs_commands.experiments.report.numbers import MINUS, difference, probability, relative, times, title, value
from rmfs_core.results.catalogue import Metric

MAKESPAN = Metric("makespan_s", "Makespan", "s", 1, "Time of the last order.")
PLAIN = Metric("picks", "Picks", "", 0, "Items picked.")
PART = Metric("loaded_distance_m", "  with a pod", "m", 0, "Part of the distance driven with a pod.")


def found(mean: float | None, low: float | None = None, high: float | None = None) -> Interval:
    """Return an interval."""
    return Interval(mean, None, None, None, low, high)


@pytest.mark.parametrize(
    ("metric", "text"),
    [
        (MAKESPAN, "Makespan (s)"),
        (PLAIN, "Picks"),
        (PART, "Part of the distance driven with a pod (m)"),  # by itself its label says nothing
    ],
)
def test_a_title_stands_by_itself(metric: Metric, text: str) -> None:
    """The label with its unit; of a part of another figure what it means."""
    assert title(metric) == text


def test_a_mean_has_a_digit_more_than_a_run() -> None:
    """Also where runs are counted in whole numbers."""
    assert value(MAKESPAN, 12.34) == "12.34"
    assert value(PLAIN, 12.34) == "12.3"
    assert value(PLAIN, None) == "-"


@pytest.mark.parametrize(
    ("interval", "text"),
    [
        (found(0.5, -0.25, 1.25), f"+0.50 [{MINUS}0.25, +1.25]"),
        (found(-0.5), f"{MINUS}0.50 (no interval)"),
        (found(0.001, -0.001, 0.001), "0.00 [0.00, 0.00]"),  # no sign for what is rounded to zero
        (found(None), "-"),
    ],
)
def test_a_difference_has_its_sign_and_interval(interval: Interval, text: str) -> None:
    """With a proper minus; without an interval that is said."""
    assert difference(MAKESPAN, interval) == text


def test_multiples_of_a_bound_have_two_digits() -> None:
    """Thousands apart; a dash where there are none."""
    assert (times(1.484), times(1234.5), times(None)) == ("1.48", "1,234.50", "-")


def test_relative_differences_are_in_percent() -> None:
    """With one digit, thousands apart."""
    assert relative(found(-0.1234, -0.2, 12.0)) == f"{MINUS}12.3 % [{MINUS}20.0, +1,200.0]"
    assert relative(found(0.5)) == "+50.0 % (no interval)"
    assert relative(found(None)) == "-"


@pytest.mark.parametrize(
    ("p", "text"), [(None, "-"), (0.00099, "< 0.001"), (0.001, "0.001"), (0.04999, "0.050"), (1.0, "1.000")]
)
def test_p_values_have_three_digits(p: float | None, text: str) -> None:
    """What is smaller is only said to be."""
    assert probability(p) == text
