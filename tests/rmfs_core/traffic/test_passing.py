"""Passing times of runs, and the cells a path occupies."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_core.clock import to_seconds
from rmfs_core.decisions import Leg
from rmfs_core.motion import Motion
from rmfs_core.traffic import FOREVER, PassingTimes, Query, Roads, occupancy, passing_s, timed_path
from rmfs_core.world import EAST, NORTH, parse_map
from rmfs_core.world.travel import Travel

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


def test_a_path_occupies_its_cells() -> None:
    """Two runs with a wait and a turn in between: the corner is held from leaving the cell before to the one after."""
    roads = Roads(Travel(parse_map("#....\n.....\n.qO..\n.....", "open"), Motion()))
    path = timed_path(roads, Query(0, 5, EAST, 1000, 2), (Leg(7), Leg(2, wait_ticks=500)))
    assert (path.end, path.end_heading, path.end_tick) == (2, NORTH, 1000 + 2828 + 500 + 625 + 2000)
    taken = occupancy(roads, path, since=-50)
    assert taken.cells.tolist() == [5, 6, 7, 2]
    assert taken.since.tolist() == [-50, 1000, 2414, 4953]
    assert taken.until.tolist() == [2415, 3829, 6953, FOREVER]


def test_who_waits_only_holds_its_cell() -> None:
    """A path that goes nowhere occupies the cell it begins in, without end."""
    roads = Roads(Travel(parse_map("#....\n.....\n.qO..\n.....", "open"), Motion()))
    path = timed_path(roads, Query(0, 5, EAST, 1000, 2), (Leg(5, wait_ticks=2000),))
    assert (path.end, path.end_tick) == (5, 3000)
    taken = occupancy(roads, path)
    assert (taken.cells.tolist(), taken.since.tolist(), taken.until.tolist()) == ([5], [1000], [FOREVER])
