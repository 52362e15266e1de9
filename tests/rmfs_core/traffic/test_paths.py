"""Paths with their times, and the cells that they occupy."""

from __future__ import annotations

from rmfs_core.decisions import Leg
from rmfs_core.motion import Motion
from rmfs_core.traffic import FOREVER, Query, Roads, occupancy, timed_path
from rmfs_core.world import EAST, NORTH, parse_map
from rmfs_core.world.travel import Travel


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
