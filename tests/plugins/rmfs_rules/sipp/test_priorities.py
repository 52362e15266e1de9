"""The search of `pbs`: nodes, and which of two robots goes first."""

from __future__ import annotations

import pytest

from rmfs_core.motion import Motion
from rmfs_core.traffic import FleetTraffic, Query, Reservations, occupancy, roads_on, timed_path
from rmfs_core.world import EAST, NORTH, WEST, parse_map
from rmfs_core.world.travel import travel_on
from rmfs_rules.sipp import Sipp
from rmfs_rules.sipp.priorities import Node, Search

EVEN = Motion(acceleration_m_per_s2=1e12, top_speed_m_per_s=1.0, full_turn_s=4.0)
"""A second for each cell and each quarter turn."""
BAY = roads_on(travel_on(parse_map("........\n@@@.@@@@", "bay"), EVEN))


def test_who_goes_first_is_handed_on() -> None:
    """Whoever goes before one that goes before a third goes before the third; those behind come in order."""
    node = Node({}, frozenset({(1, 2), (2, 3), (5, 3)}))
    assert node.ahead(3) == {1, 2, 5}
    assert node.ahead(1) == set()
    assert node.behind(1) == [1, 2, 3]
    assert node.behind(3) == [3]


def test_who_cannot_pass_gets_no_path() -> None:
    """A robot that stays where another would have to drive: there is no answer for that one."""
    table = Reservations(BAY.cells)
    coming, new = Query(0, 7, WEST, 0, 2), Query(1, 1, EAST, 0, 7)
    table.hold(1, 1, 0)
    path = Sipp().search(BAY, table, coming)
    assert path is not None
    table.commit(0, occupancy(BAY, path))
    traffic = FleetTraffic(BAY, table, {}, {0: occupancy(BAY, path)}, {0: path.end_tick})
    assert Search(Sipp(), [new, coming], traffic).best(20) == {}


@pytest.mark.parametrize("most", [0, 20])
def test_with_room_both_arrive(most: int) -> None:
    """Robots that cross in a hall: paths keep clear of each other, and the search costs no time in sum."""
    hall = roads_on(travel_on(parse_map("........\n........", "hall"), EVEN))
    table = Reservations(hall.cells)
    coming, new = Query(0, 7, WEST, 0, 0), Query(1, 8, NORTH, 0, 15)
    table.hold(1, 8, 0)
    path = Sipp().search(hall, table, coming)
    assert path is not None
    table.commit(0, occupancy(hall, path))
    traffic = FleetTraffic(hall, table, {}, {0: occupancy(hall, path)}, {0: path.end_tick})
    found = Search(Sipp(), [new, coming], traffic).best(most)
    assert found.keys() == {1}
    assert timed_path(hall, new, found[1].legs).end_tick == hall.travel.ticks(8, NORTH, 15, False)
