"""Spans of time and percentiles."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_commands.details.spans import Count, length, merged, overlap, percentile, within


def test_spans() -> None:
    """Spans that overlap or touch are one; what two lists have in common is their overlap."""
    assert merged([(5, 9), (0, 2), (2, 4), (8, 12), (3, 3)]) == [(0, 4), (5, 12)]
    assert within([(0, 4), (5, 12)], 3, 7) == [(3, 4), (5, 7)]
    assert length([(0, 4), (5, 12)]) == 11
    assert overlap([(0, 4), (5, 12)], [(3, 6), (10, 20)]) == 1 + 1 + 2


def test_a_count_over_time() -> None:
    """Two from 10 on, one from 20 on, none from 25 on: a mean of 25 in 40 ticks."""
    count = Count()
    for tick, change in ((10, 1), (10, 1), (20, -1), (25, -1)):
        count.add(tick, change)
    assert count.above_zero(0, 40) == [(10, 25)]
    assert count.mean(0, 40) == 25 / 40
    assert (count.largest(0, 40), count.largest(22, 40), count.largest(30, 40)) == (2, 1, 0)


@pytest.mark.parametrize("share", [0.5, 0.95])
def test_percentiles_are_those_of_numpy(share: float) -> None:
    """Between two values it is interpolated; of nothing there is none."""
    values = [7000, 1000, 4500, 12000, 3000]
    assert percentile(values, share) == pytest.approx(np.percentile(values, 100 * share) / 1000)
    assert percentile([], share) is None
