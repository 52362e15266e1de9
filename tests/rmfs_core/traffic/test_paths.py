"""Paths with their times, and the cells that they occupy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.layouts import parse_map
from rmfs_core.decisions import Leg, Path
from rmfs_core.motion import Motion
from rmfs_core.traffic import FOREVER, Query, Roads, drive, occupancy, timed_path
from rmfs_core.traffic.paths import Stop, run_between
from rmfs_core.world import EAST, NORTH, WEST
from rmfs_core.world.travel import Travel

OPEN = Roads(Travel(parse_map("#....\n.....\n.qO..\n.....", "open"), Motion()))


def test_a_path_occupies_its_cells() -> None:
    """Two runs with a wait and a turn in between: the corner is held from leaving the cell before to the one after."""
    path = timed_path(OPEN, Query(0, 5, EAST, 1000, 2), (Leg(7), Leg(2, wait_ticks=500)))
    assert (path.end, path.end_heading, path.end_tick) == (2, NORTH, 1000 + 2828 + 500 + 625 + 2000)
    taken = occupancy(OPEN, path, since=-50)
    assert taken.cells.tolist() == [5, 6, 7, 2]
    assert taken.since.tolist() == [-50, 1000, 2414, 4953]
    assert taken.until.tolist() == [2415, 3829, 6953, FOREVER]


def test_who_waits_only_holds_its_cell() -> None:
    """A path that goes nowhere occupies the cell it begins in, without end."""
    path = timed_path(OPEN, Query(0, 5, EAST, 1000, 2), (Leg(5, wait_ticks=2000),))
    assert (path.end, path.end_tick) == (5, 3000)
    taken = occupancy(OPEN, path)
    assert (taken.cells.tolist(), taken.since.tolist(), taken.until.tolist()) == ([5], [1000], [FOREVER])


def test_the_decision_is_what_is_driven() -> None:
    """A planner's answer as the hook returns it."""
    legs = (Leg(7), Leg(2))
    assert timed_path(OPEN, Query(0, 5, EAST, 0, 2), legs).path == Path(legs)
    still = timed_path(OPEN, Query(0, 5, WEST, 70, 5), ())
    assert (still.end, still.end_heading, still.end_tick) == (5, WEST, 70)


def test_a_turn_is_as_long_either_way_round() -> None:
    """A quarter takes 0.625 s, half a turn twice that, to the left as to the right."""
    run = Motion().run_ticks(1)
    ends = [timed_path(OPEN, Query(0, 6, heading, 0, 7), (Leg(7),)).end_tick - run for heading in range(4)]
    assert ends == [0, 625, 1250, 625]


def test_what_is_no_straight_run_is_refused() -> None:
    """Both cells are named; a knight's move is none."""
    with pytest.raises(ValueError, match=r"^row 2, column 1 to row 1, column 3 is no straight run$"):
        timed_path(OPEN, Query(0, 5, EAST, 0, 2), (Leg(2),))
    assert run_between(OPEN, 5, 9) == (EAST, 4)
    assert run_between(OPEN, 17, 2) == (NORTH, 3)


@given(wait=st.integers(0, 5000), other=st.integers(0, 5000), stops=st.lists(st.integers(5, 9), max_size=4))
def test_a_path_always_has_a_cell(wait: int, other: int, stops: list[int]) -> None:
    """Back and forth along a row: each cell is occupied until the next one is, and the last one for ever."""
    legs = tuple(Leg(cell, wait + i * other) for i, cell in enumerate(stops))
    path = timed_path(OPEN, Query(0, 5, EAST, 300, 9), legs)
    taken = occupancy(OPEN, path)
    assert taken.since[0] == 300
    assert (taken.since < taken.until).all()
    assert (taken.since[1:] <= taken.until[:-1]).all()
    assert (abs(np.diff(taken.cells)) == 1).all()
    again, end = drive(OPEN, Stop(5, EAST, 300), legs)
    assert (again.cells.tolist(), again.until.tolist()) == (taken.cells.tolist(), taken.until.tolist())
    assert end == (path.end, path.end_heading, path.end_tick)
    assert (taken.cells[-1], taken.until[-1]) == (path.end, FOREVER)
    assert taken.since[-1] <= path.end_tick
