"""Robots are shared out over stations, and the ones nearest by move."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.balanced.sharing import drive, middle_last, share_out

STATIONS = 3
"""Stations 0, 1 and 2 from north to south; all robots stand in the south-east, robot 0 nearest to every station."""


def world_with(robots: int = 4) -> Warehouse:
    """Return a world of three stations in which nothing is to be done."""
    return small_world({}, {"p": ["a"]}, capacities=[9] * STATIONS, robots=robots)


def shares(world: Warehouse, before: dict[int, int], stations: list[int]) -> list[int]:
    """Return how many robots each station gets."""
    after = share_out(WarehouseView(world), before, stations)
    return [sum(station == own for own in after.values()) for station in range(STATIONS)]


def test_stations_are_ranked_by_their_distance_from_the_middle() -> None:
    """Station 1 is in the middle row, 2 is farthest south."""
    view = WarehouseView(world_with())
    assert middle_last(view, {0, 1, 2}) == [2, 0, 1]


@pytest.mark.parametrize(
    ("robots", "stations", "expected"),
    [
        (4, [2, 0, 1], [1, 1, 2]),  # the remainder goes to the first of the ranking
        (5, [2, 0, 1], [2, 1, 2]),
        (4, [0, 1], [2, 2, 0]),  # only active stations get any
        (2, [2, 0, 1], [1, 0, 1]),  # fewer robots than stations
        (3, [1], [0, 3, 0]),
    ],
)
def test_robots_are_shared_out_evenly(robots: int, stations: list[int], expected: list[int]) -> None:
    """As evenly as possible, whatever the shares were before."""
    world = world_with(robots)
    assert shares(world, {}, stations) == expected
    assert shares(world, dict.fromkeys(range(robots), 0), stations) == expected
    assert shares(world, {robot: robot % STATIONS for robot in range(robots)}, stations) == expected


def test_only_robots_that_have_to_move_do() -> None:
    """Station 2 gets one of the three robots of station 1: the one with the shortest drive there. Robot 3 stays."""
    view = WarehouseView(world_with())
    assert share_out(view, {0: 1, 1: 1, 2: 1, 3: 2}, [2, 1]) == {0: 2, 1: 1, 2: 1, 3: 2}


@given(
    robots=st.integers(1, 6),
    stations=st.permutations(range(STATIONS)).flatmap(lambda order: st.integers(1, STATIONS).map(lambda n: order[:n])),
    before=st.dictionaries(st.integers(0, 5), st.integers(0, STATIONS - 1)),
)
def test_shares_differ_by_one_at_most(robots: int, stations: list[int], before: dict[int, int]) -> None:
    """The first of the ranking have the remainder, every robot belongs to one of them; sharing again moves nobody."""
    before = {robot: station for robot, station in before.items() if robot < robots}
    view = WarehouseView(world_with(robots))
    after = share_out(view, before, stations)
    each, more = divmod(robots, len(stations))
    assert sorted(after) == list(range(robots))
    assert [list(after.values()).count(station) for station in stations] == [
        each + (rank < more) for rank in range(len(stations))
    ]
    assert share_out(view, after, stations) == after


def test_a_drive_is_as_long_as_its_time_without_a_pod() -> None:
    """From where the robot stands and as it faces; the station's id breaks ties."""
    view = WarehouseView(world_with())
    robot = view.robots[0]
    for station in view.stations:
        expected = view.travel.ticks(robot.cell, robot.heading, station.cell, False)
        assert drive(view, robot, station.id) == (expected, station.id)
    assert min(range(STATIONS), key=lambda station: drive(view, robot, station)) == 2
