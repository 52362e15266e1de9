"""The compiled search of `whca-n`: valid paths, never earlier than the first that there is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crowds import crowd, newcomer, paper_roads
from reserving import hold_until
from rmfs_commands.layouts import parse_map
from rmfs_commands.testing import small_layout
from rmfs_core.motion import Motion
from rmfs_core.traffic import FOREVER, Reservations, Roads, occupancy, roads_on
from rmfs_core.world import EAST
from rmfs_core.world.travel import travel_on
from rmfs_rules.helpers.searching import Asked
from rmfs_rules.sipp import Sipp
from rmfs_rules.whca import WhcaN
from rmfs_rules.whca.compiled import search

EVEN = Motion(acceleration_m_per_s2=1e12, top_speed_m_per_s=1.0, full_turn_s=4.0)
"""A second for each cell and each quarter turn."""
YARD = parse_map("......\n@@@..#\nqO....", "yard")


@pytest.mark.parametrize(
    ("robots", "seed"), [(8, 0), (16, 1), *(pytest.param(*one, marks=pytest.mark.slow) for one in ((32, 2), (48, 3)))]
)
def test_sipp_never_arrives_later(robots: int, seed: int) -> None:
    """With an unlimited window, 250 queries each among so many robots: `sipp` is never later, and often earlier."""
    roads, sipp, whca = paper_roads(), Sipp(), WhcaN(window_s=math.inf)
    table, _ = crowd(roads, sipp, robots, seed)
    rng = np.random.default_rng(seed)
    earlier = found = 0
    for _ in range(250):
        query = newcomer(roads, table, 1000, 0, rng)
        first, other = sipp.search(roads, table, query), whca.search(roads, table, query)
        if other is None:
            continue
        assert first is not None
        assert first.end_tick <= other.end_tick
        table.check(1000, occupancy(roads, other))
        earlier += first.end_tick < other.end_tick
        found += 1
    assert found > 150
    assert earlier > 0


@given(robots=st.integers(1, 15), seed=st.integers(0, 1000), window_s=st.floats(1, 60))
@settings(deadline=None, max_examples=60)
def test_windowed_paths_end_where_they_can_be_held(robots: int, seed: int, window_s: float) -> None:
    """A path ends at the goal or not before the window, and the table has room for it, hold and all."""
    roads = roads_on(travel_on(small_layout(stations=2), Motion()))
    table, _ = crowd(roads, Sipp(), robots, seed)
    query = newcomer(roads, table, 1000, 5000, np.random.default_rng(seed))
    table.hold(1000, query.cell, 5000)
    path = WhcaN(window_s=window_s).search(roads, table, query)
    assert path is not None
    assert path.end == query.goal or path.end_tick >= 5000 + 1000 * window_s - 1
    table.commit(1000, occupancy(roads, path))


def rows(
    table: Reservations, roads: Roads, goal: int, window_end: int, max_nodes: int = 1000
) -> list[list[int]] | None:
    """Return what the search finds for robot 0, at rest in cell 0 and facing east, with waits of 2 s."""
    found = search(Asked(0, 0, EAST, 0, goal), window_end, 2000, max_nodes, roads.tracks(goal, False), table.arrays)
    return None if found is None else found.tolist()


def test_rows_are_the_legs_of_the_path() -> None:
    """(end, wait) of each run; waits before it, which come before its turn, are one."""
    roads = roads_on(travel_on(YARD, EVEN))
    table = Reservations(roads.cells)
    assert rows(table, roads, 9, FOREVER) == [[3, 0], [9, 0]]  # east, a quarter turn, south
    hold_until(table, 1, 1, 0, 3000)
    assert rows(table, roads, 9, FOREVER) == [[3, 4000], [9, 0]]  # two waits make 4 s
    assert rows(table, roads, 0, FOREVER) == []


def test_a_window_ends_a_path_with_a_wait() -> None:
    """Where the window ends before the way is free, the last row is the wait, as long as whole waits take."""
    roads = roads_on(travel_on(parse_map("......\n@@@@@#\nqO....", "corridor"), EVEN))
    table = Reservations(roads.cells)
    hold_until(table, 1, 1, 0, 9000)
    assert rows(table, roads, 4, 5000) == [[0, 6000]]
    assert rows(table, roads, 4, FOREVER) == [[4, 10_000]]
    hold_until(table, 1, 0, 12_000, 20_000)
    hold_until(table, 1, 4, 0, 30_000)
    assert rows(table, roads, 4, 20_000) == [[3, 10_000], [3, 8000]]


def test_a_search_ends_with_its_nodes_or_without_a_way() -> None:
    """No path: too few nodes, a cell that another has, a goal that another keeps, no way at all."""
    roads = roads_on(travel_on(YARD, EVEN))
    table = Reservations(roads.cells)
    assert rows(table, roads, 9, FOREVER, max_nodes=1) is None
    table.hold(1, 9, 20_000)
    assert rows(table, roads, 9, FOREVER) is None
    assert rows(table, roads, 9, 5000) is not None  # the window ends before anybody comes
    hold_until(table, 1, 0, 0, 1000)
    assert rows(table, roads, 3, FOREVER) is None
    walled = roads_on(travel_on(parse_map("..@...\n..@...\nqO@...", "walled"), EVEN))
    assert rows(Reservations(walled.cells), walled, 4, FOREVER) is None
