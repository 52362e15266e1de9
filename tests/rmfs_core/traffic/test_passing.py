"""Passing times of runs."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_core.clock import to_seconds
from rmfs_core.motion import Motion
from rmfs_core.traffic import PassingTimes, passing_s

MOTIONS = st.builds(
    Motion,
    acceleration_m_per_s2=st.floats(0.1, 5),
    top_speed_m_per_s=st.floats(0.3, 5),
    full_turn_s=st.floats(0.4, 8),
)


def test_a_run_of_three_cells() -> None:
    """With 1 m/s^2 and 1.5 m/s: 3.5 s; the second cell is passed after sqrt(2) s, the third as long before the end."""
    passing = PassingTimes(Motion(), 5)
    assert Motion().run_ticks(3) == 3500
    assert passing.leave[3, 0] == 1415
    assert list(passing.enter[3, :4]) == [0, 0, 1414, 2085]
    assert list(passing.leave[3, :3]) == [1415, 2086, 3500]


@given(motion=MOTIONS, cells=st.integers(1, 30))
@settings(deadline=None)
def test_passing_times_invert_the_position(motion: Motion, cells: int) -> None:
    """At the time it passes a cell, a robot is at that cell's centre."""
    for cell, seconds in enumerate(passing_s(motion, cells)):
        assert motion.position_m(cells, float(seconds)) == pytest.approx(cell, abs=1e-6)


@given(motion=MOTIONS, cells=st.integers(1, 30))
@settings(deadline=None)
def test_rounding_goes_outward(motion: Motion, cells: int) -> None:
    """No cell is reserved later than the one before is left, or let go before the next one is reached."""
    passing = PassingTimes(motion, 30)
    exact = passing_s(motion, cells)
    for cell in range(cells):
        assert to_seconds(int(passing.leave[cells, cell])) >= exact[cell + 1] - 1e-8
        assert to_seconds(int(passing.leave[cells, cell])) <= exact[cell + 1] + 2e-3
    for cell in range(1, cells + 1):
        assert to_seconds(int(passing.enter[cells, cell])) <= exact[cell - 1] + 1e-8
        assert to_seconds(int(passing.enter[cells, cell])) >= exact[cell - 1] - 1e-3
    assert passing.common[cells] <= cells
