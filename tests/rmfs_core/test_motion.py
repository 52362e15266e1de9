"""The closed formulas of motion."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rmfs_core.motion import Motion


@pytest.mark.parametrize(
    ("metres", "seconds"),
    [
        (1, 2.0),  # triangular: 2 sqrt(1)
        (2, 2 * math.sqrt(2)),
        (2.25, 3.0),  # reaches 1.5 m/s for an instant
        (9, 3 + (9 - 2.25) / 1.5),
    ],
)
def test_run_times_of_the_paper(metres: float, seconds: float) -> None:
    """With 1 m/s^2 and 1.5 m/s a run takes 3 + (D - 2.25)/1.5 s from 2.25 m on, and 2 sqrt(D) s below."""
    assert Motion().run_s(metres) == pytest.approx(seconds)


def test_turns_go_the_shorter_way() -> None:
    """A quarter turn takes a quarter of the full turn's 2.5 s, in either direction; half a turn twice that."""
    motion = Motion()
    assert [motion.turn_ticks(0, heading) for heading in range(4)] == [0, 625, 1250, 625]
    assert motion.turn_ticks(3, 0) == 625


@given(
    acceleration=st.floats(0.1, 5),
    speed=st.floats(0.1, 5),
    metres=st.integers(1, 100),
    parts=st.integers(2, 40),
)
def test_positions_follow_the_speed_profile(acceleration: float, speed: float, metres: int, parts: int) -> None:
    """A run starts at 0, ends at its length, never goes back, and is never faster than the top speed."""
    motion = Motion(acceleration_m_per_s2=acceleration, top_speed_m_per_s=speed)
    total = motion.run_s(metres)
    times = [total * i / parts for i in range(parts + 1)]
    positions = [motion.position_m(metres, time) for time in times]
    assert positions[0] == 0
    assert positions[-1] == pytest.approx(metres)
    for before, after in pairwise(positions):
        assert -1e-9 <= after - before <= speed * total / parts + 1e-9
