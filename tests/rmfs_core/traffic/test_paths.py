"""Passing times of runs, paths with their times and cells, and what planning needs to know of a layout."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases import cases
from rmfs_commands.layouts import parse_map
from rmfs_core.clock import UNREACHABLE, far, to_seconds
from rmfs_core.decisions import Leg, Path
from rmfs_core.motion import Motion
from rmfs_core.traffic import FOREVER, PassingTimes, Query, Roads, drive, occupancy, passing_s, roads_on, timed_path
from rmfs_core.traffic.paths import Stop, run_between
from rmfs_core.world import EAST, NORTH, WEST, CellKind
from rmfs_core.world.travel import Travel, travel_on

MOTIONS = st.builds(
    Motion, acceleration_m_per_s2=st.floats(0.1, 5), top_speed_m_per_s=st.floats(0.3, 5), full_turn_s=st.floats(0.4, 8)
)


def test_runs_and_turns() -> None:
    passing = PassingTimes(Motion(), 5)
    assert Motion().run_ticks(3) == 3500
    assert passing.leave[3, 0] == 1415
    assert list(passing.enter[3, :4]) == [0, 0, 1414, 2085]
    assert list(passing.leave[3, :3]) == [1415, 2086, 3500]
    run = Motion().run_ticks(1)
    ends = [timed_path(OPEN, Query(0, 6, heading, 0, 7), (Leg(7),)).end_tick - run for heading in range(4)]
    assert ends == [0, 625, 1250, 625]


@given(motion=MOTIONS, cells=st.integers(1, 30))
@settings(deadline=None)
def test_passing_times_invert_the_position(motion: Motion, cells: int) -> None:
    for cell, seconds in enumerate(passing_s(motion, cells)):
        assert motion.position_m(cells, float(seconds)) == pytest.approx(cell, abs=1e-6)


@given(motion=MOTIONS, cells=st.integers(1, 30))
@settings(deadline=None)
def test_rounding_goes_outward(motion: Motion, cells: int) -> None:
    passing = PassingTimes(motion, 30)
    exact = passing_s(motion, cells)
    for cell in range(cells):
        assert to_seconds(int(passing.leave[cells, cell])) >= exact[cell + 1] - 1e-8
        assert to_seconds(int(passing.leave[cells, cell])) <= exact[cell + 1] + 2e-3
    for cell in range(1, cells + 1):
        assert to_seconds(int(passing.enter[cells, cell])) <= exact[cell - 1] + 1e-8
        assert to_seconds(int(passing.enter[cells, cell])) >= exact[cell - 1] - 1e-3
    assert passing.common[cells] <= cells


OPEN = Roads(Travel(parse_map("#....\n.....\n.qO..\n.....", "open"), Motion()))


def test_a_path_occupies_its_cells() -> None:
    path = timed_path(OPEN, Query(0, 5, EAST, 1000, 2), (Leg(7), Leg(2, wait_ticks=500)))
    assert (path.end, path.end_heading, path.end_tick) == (2, NORTH, 1000 + 2828 + 500 + 625 + 2000)
    taken = occupancy(OPEN, path, since=-50)
    assert taken.cells.tolist() == [5, 6, 7, 2]
    assert taken.since.tolist() == [-50, 1000, 2414, 4953]
    assert taken.until.tolist() == [2415, 3829, 6953, FOREVER]
    legs = (Leg(7), Leg(2))
    assert timed_path(OPEN, Query(0, 5, EAST, 0, 2), legs).path == Path(legs)
    still = timed_path(OPEN, Query(0, 5, WEST, 70, 5), ())
    assert (still.end, still.end_heading, still.end_tick) == (5, WEST, 70)


def test_what_is_no_straight_run_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^row 2, column 1 to row 1, column 3 is no straight run$"):
        timed_path(OPEN, Query(0, 5, EAST, 0, 2), (Leg(2),))
    assert run_between(OPEN, 5, 9) == (EAST, 4)
    assert run_between(OPEN, 17, 2) == (NORTH, 3)


@given(wait=st.integers(0, 5000), other=st.integers(0, 5000), stops=st.lists(st.integers(5, 9), max_size=4))
def test_a_path_always_has_a_cell(wait: int, other: int, stops: list[int]) -> None:
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


LAYOUT = parse_map("#.#...\n......\n.qqO..\n......", "row")
ROADS = roads_on(travel_on(LAYOUT, Motion()))


def test_a_run_has_one_object_and_passing_times_reach_across_the_grid() -> None:
    travel = travel_on(LAYOUT, Motion())
    assert roads_on(travel) is roads_on(travel)
    assert roads_on(travel_on(LAYOUT, Motion())) is not roads_on(travel)
    assert (ROADS.cells, len(ROADS.passing.common)) == (24, 7)
    tall = parse_map("#\n.\n" + ".\n" * 7, "tall")
    assert len(Roads(travel_on(tall, Motion())).passing.common) == 10
    assert ROADS.turns == (0, 625, 1250, 625)


@cases(
    "goal loaded storage queue",
    (2, False, True, False),  # without a pod under stored ones; no queue on the way to storage
    (2, True, False, False),
    (15, True, False, True),  # the station: its queue may be crossed
    (13, False, True, True),  # a place in it
)
def test_tracks_say_what_may_be_crossed(goal: int, loaded: bool, storage: bool, queue: bool) -> None:
    tracks = ROADS.tracks(goal, loaded)
    kind = LAYOUT.kind
    assert set(tracks.passable[kind == CellKind.STORAGE].tolist()) == {storage}
    assert set(tracks.passable[kind == CellKind.QUEUE].tolist()) == {queue}
    assert set(tracks.passable[kind == CellKind.STATION].tolist()) == {False}
    assert tracks.passable[kind == CellKind.FLOOR].all()


def test_tracks_have_the_times_of_their_goal() -> None:
    tracks = ROADS.tracks(2, True)
    times = ROADS.travel.times_to(2, True)
    np.testing.assert_array_equal(tracks.times, np.where(times < UNREACHABLE, times, far(tracks.times)))
    assert tracks.times[2].tolist() == [0] * 4
    assert tracks.times[1, 0] == tracks.runs[1] < ROADS.tracks(0, True).times[1, 0]
    assert (tracks.moves is LAYOUT.moves, tracks.offsets.tolist()) == (True, [1, -6, -1, 6])
    for array in (tracks.passable, tracks.times, tracks.runs, tracks.enter):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
