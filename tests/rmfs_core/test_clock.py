"""Ticks and seconds."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rmfs_core.clock import to_seconds, to_ticks


@pytest.mark.parametrize(("seconds", "ticks"), [(0.0, 0), (2.2, 2200), (0.0004, 0), (0.0006, 1), (1.4142, 1414)])
def test_seconds_are_rounded_to_the_nearest_tick(seconds: float, ticks: int) -> None:
    """A tick is a millisecond."""
    assert to_ticks(seconds) == ticks


@given(st.integers(0, 100 * 365 * 24 * 3600 * 1000))
def test_no_tick_is_lost_on_the_way_to_seconds_and_back(ticks: int) -> None:
    """Files have seconds, the kernel ticks: what is written and read back is the same tick, for a hundred years."""
    assert to_ticks(to_seconds(ticks)) == ticks
