"""Verdicts on our figures."""

import pytest

from rmfs_commands.reproduction.estimates import Estimate
from rmfs_commands.reproduction.paper import Range
from rmfs_commands.reproduction.tables import NO_NUMBER, NO_RUN, as_factor, in_range


def ours(mean: float) -> Estimate:
    """Return an estimate with this mean."""
    return Estimate(mean, 0.1, 10, 10)


@pytest.mark.parametrize(
    ("mean", "verdict"), [(0.69, "below"), (0.70, "in range"), (0.75, "in range"), (0.80, "in range"), (0.81, "above")]
)
def test_where_our_mean_lies(mean: float, verdict: str) -> None:
    """Both ends of the paper's range belong to it."""
    assert in_range(("a",), Range(0.70, 0.80), ours(mean)).verdict == verdict


@pytest.mark.parametrize(
    ("seconds", "verdict"),
    [(0.02, "50 times faster"), (1.0, "1.0 times faster"), (0.4, "2.5 times faster"), (3.0, "3.0 times slower")],
)
def test_how_many_times_faster(seconds: float, verdict: str) -> None:
    """Computing times are compared by their factor, whatever the rounding of the paper's."""
    line = as_factor(("a",), Range(0.995, 1.005, 1.0), ours(seconds))
    assert line.verdict == verdict
    assert line.speedup == pytest.approx(1 / seconds)


@pytest.mark.parametrize("compare", [in_range, as_factor])
def test_nothing_to_compare(compare) -> None:
    """A picture without numbers and a figure that no run gave say so."""
    assert compare(("a",), None, ours(1.0)).verdict == NO_NUMBER
    assert compare(("a",), Range(1.0, 2.0), None).verdict == NO_RUN
    assert compare(("a",), None, None).verdict == NO_RUN
