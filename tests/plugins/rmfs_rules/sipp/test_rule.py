"""PP rule `sipp`: what its path is, alone and among robots that wait, stay or have reserved the way."""

from __future__ import annotations

import numpy as np
import pytest

import plain_sipp as plain
from crowds import crowd, newcomer, paper_roads
from reserving import hold_until
from rmfs_core.clock import UNREACHABLE
from rmfs_core.motion import Motion
from rmfs_core.traffic import Query, Reservations, Roads, Traffic, occupancy, roads_on
from rmfs_core.world import Layout, parse_map
from rmfs_core.world.travel import Travel, travel_on
from rmfs_rules.sipp import Sipp

EVEN = Motion(acceleration_m_per_s2=1e12, top_speed_m_per_s=1.0, full_turn_s=4.0)
"""A second for each cell and each quarter turn: all that happens, happens on whole seconds."""


def test_without_traffic_it_is_the_fastest_path() -> None:
    """Alone in the warehouse a robot arrives after exactly the travel time, from anywhere."""
    roads = paper_roads()
    table = Reservations(roads.cells)
    rng = np.random.default_rng(3)
    for _ in range(50):
        query = newcomer(roads, table, 0, 777, rng)
        path = Sipp().search(roads, table, query)
        expected = roads.travel.ticks(query.cell, query.heading, query.goal, query.loaded)
        assert path is not None
        assert path.end_tick == 777 + expected < UNREACHABLE


def test_many_robots_commit_one_after_another() -> None:
    """Sixty robots' paths on the paper's layout never overlap: the table refuses none."""
    table, queries = crowd(paper_roads(), Sipp(), 60, 1, warm_up=3)
    assert sum(len(table.reserved(cell)) for cell in range(paper_roads().cells)) > 60
    assert any(query.start_tick for query in queries)


@pytest.mark.parametrize("spare_ticks", [(), (0,), (0, 1_000, 10_000), (5_000,)])
def test_paths_are_the_same_with_times_of_what_is_near(
    spare_ticks: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a crowd, the hook's paths, for which only a part of the table of times is searched, are those of the whole."""
    monkeypatch.setattr("rmfs_rules.sipp.rule.LATER_TICKS", spare_ticks)
    roads = paper_roads()
    table, queries = crowd(roads, Sipp(), 60, 2)
    now, rng = min(query.start_tick for query in queries), np.random.default_rng(2)
    for _ in range(30):
        query = newcomer(roads, table, 1000, now, rng)
        path = Sipp().search(roads, table, query)
        assert path is not None
        fresh = Roads(Travel(roads.layout, roads.travel.motion))
        assert Sipp().plan_path(Traffic(fresh, table, query)) == path.path


def _corridor() -> tuple[Roads, Layout]:
    layout = parse_map("......\n@@@@@#\nqO....", "corridor")
    return roads_on(travel_on(layout, EVEN)), layout


def test_it_waits_until_the_goal_is_free_for_good() -> None:
    """The goal is entered once the last reservation there has ended, however early the robot could be there."""
    roads, _ = _corridor()
    table = Reservations(roads.cells)
    hold_until(table, 1, 4, 30_000, 50_000)
    path = Sipp().search(roads, table, Query(0, 0, 0, 0, 4))
    assert path is not None
    assert path.end_tick == 51_000
    table.hold(1, 4, 60_000)
    assert Sipp().search(roads, table, Query(0, 0, 0, 0, 4)) is None
    assert plain.search(roads, table, Query(0, 0, 0, 0, 4)) is None


@pytest.mark.parametrize(("speed", "width"), [(1.0, 4), (1e-6, 8)])
def test_no_path_is_no_path_however_long_ways_take(speed: float, width: int) -> None:
    """Another robot has a cell in between for good: the search ends, whatever the bytes of the times."""
    _, layout = _corridor()
    roads, query = Roads(Travel(layout, Motion(top_speed_m_per_s=speed))), Query(0, 0, 0, 5, 4)
    assert roads.tracks(4, False).times.itemsize == width
    table = Reservations(roads.cells)
    table.hold(1, 2, 0)
    assert Sipp().plan_path(Traffic(roads, table, query)) is None
    assert Sipp().search(roads, table, query) is None


def test_it_waits_for_weeks() -> None:
    """A number of four bytes would not hold it."""
    roads, _ = _corridor()
    table, query = Reservations(roads.cells), Query(0, 0, 0, 1, 4)
    hold_until(table, 1, 1, 0, 30 * 86_400_000)
    path, expected = Sipp().search(roads, table, query), plain.search(roads, table, query)
    assert path is not None
    assert expected is not None
    assert path.end_tick == expected.end_tick > 1 << 31


def test_ones_own_reservations_are_no_obstacle() -> None:
    """A robot that holds the cell it stands in, and a path it gives up, plans as if it had neither."""
    roads, _ = _corridor()
    table = Reservations(roads.cells)
    table.hold(0, 0, 0)
    hold_until(table, 0, 3, 0, 9000)
    path = Sipp().search(roads, table, Query(0, 0, 0, 0, 4))
    assert path is not None
    assert path.end_tick == 4000
    table.commit(0, occupancy(roads, path))
    assert table.blocker(3, 0) == 0


def test_who_is_there_already_stays() -> None:
    """A robot at its goal has an empty path, unless someone else has reserved the cell for later."""
    roads, _ = _corridor()
    table = Reservations(roads.cells)
    path = Sipp().search(roads, table, Query(0, 3, 0, 500, 3))
    assert path is not None
    assert (path.legs, path.end_tick) == ((), 500)
    hold_until(table, 1, 3, 20_000, 21_000)
    path = Sipp().search(roads, table, Query(0, 3, 0, 500, 3))
    assert path is not None
    assert path.end_tick == 22_000


@pytest.mark.parametrize("reserved", [0, 2])
def test_there_is_no_path_through_who_stays(reserved: int) -> None:
    """Neither from a cell that another has, nor along a corridor in which another stays."""
    roads, _ = _corridor()
    table = Reservations(roads.cells)
    table.hold(1, reserved, 0)
    assert Sipp().search(roads, table, Query(0, 0, 0, 0, 4)) is None
