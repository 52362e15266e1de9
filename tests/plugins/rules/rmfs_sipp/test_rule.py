"""PP rule `sipp`: its searches against each other, and against trying everything."""

from __future__ import annotations

import heapq

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import plain_sipp as plain
from crowds import crowd, newcomer, paper_roads, two_way
from reserving import hold_until, stay
from rmfs_core.motion import Motion
from rmfs_core.traffic import FOREVER, Query, Reservations, Roads, TimedPath, occupancy, roads_on
from rmfs_core.world import Layout, parse_map
from rmfs_core.world.travel import UNREACHABLE, travel_on
from rmfs_sipp import Sipp
from rmfs_testing import small_layout

EVEN = Motion(acceleration_m_per_s2=1e12, top_speed_m_per_s=1.0, full_turn_s=4.0)
"""A second for each cell and each quarter turn: all that happens, happens on whole seconds."""
OPEN = parse_map("#.....\n....#.\n.qO...\n.#....", "open")
AISLES = parse_map(".>>>.\nv###^\n.<<<.\nqO...", "aisles")


def everything(roads: Roads, table: Reservations, query: Query, end: int) -> int | None:
    """Try every wait of a second, turn and run until a time; return the arrival. Slow, simple, and on EVEN exact."""
    layout, travel, motion = roads.layout, roads.travel, roads.travel.motion

    def free(cell: int, since: int, until: int) -> bool:
        return all(who == query.robot or b <= since or a >= until for who, a, b in table.reserved(cell))

    seen = {(query.start_tick, query.cell, query.heading)}
    queue = [*seen]
    while queue:
        tick, cell, heading = heapq.heappop(queue)
        if cell == query.goal and free(cell, tick, FOREVER):
            return tick
        if tick > end:
            return None
        after = [(tick + 1000, cell, heading)] if free(cell, tick, tick + 1000) else []
        for towards in range(4):
            begin, at, k = tick + motion.turn_ticks(heading, towards), cell, 0
            if not free(cell, tick, begin + 1000):
                continue
            while layout.may_step(at, towards):
                at, k = at + int(roads.offsets[towards]), k + 1
                if travel.run_problem(query.cell, cell, at, query.goal, query.loaded) is not None:
                    break
                if free(at, begin + 1000 * (k - 1), begin + 1000 * k):
                    after.append((begin + 1000 * k, at, towards))
                if not free(at, begin + 1000 * (k - 1), begin + 1000 * (k + 1)):
                    break
        for state in after:
            if state not in seen:
                seen.add(state)
                heapq.heappush(queue, state)
    return None


def assert_valid(roads: Roads, table: Reservations, query: Query, path: TimedPath) -> None:
    """The path's legs are possible, and the table has room for what it occupies."""
    table.check(query.robot, occupancy(roads, path))
    cell = query.cell
    for leg in path.legs:
        assert leg.wait_ticks >= 0
        assert leg.to == cell or roads.travel.run_problem(query.cell, cell, leg.to, query.goal, query.loaded) is None
        cell = leg.to


@given(data=st.data())
@settings(deadline=None, max_examples=150)
def test_no_path_arrives_earlier(data: st.DataObject) -> None:
    """On whole seconds, both searches arrive exactly when the first of all possible paths does."""
    roads = roads_on(travel_on(data.draw(st.sampled_from([OPEN, AISLES])), EVEN))
    cells = [c for c in range(roads.cells) if roads.layout.kind[c] in {1, 2}]
    start, goal = data.draw(st.sampled_from(cells)), data.draw(st.sampled_from(cells))
    table = Reservations(roads.cells)
    for _ in range(data.draw(st.integers(0, 12))):
        cell = data.draw(st.sampled_from(cells))
        since = data.draw(st.integers(0, 15))
        until = since + data.draw(st.integers(1, 6))
        if table.is_free(1, stay(cell, since * 1000, until * 1000)) and cell != start:
            hold_until(table, 1, cell, since * 1000, until * 1000)
    query = Query(0, start, data.draw(st.integers(0, 3)), 0, goal, data.draw(st.booleans()))
    path, slow = Sipp().search(roads, table, query), plain.search(roads, table, query)
    assert (path is None) == (slow is None)
    if path is None or slow is None:
        assert everything(roads, table, query, 40_000) is None
        return
    assert_valid(roads, table, query, path)
    assert_valid(roads, table, query, slow)
    assert path.end_tick == slow.end_tick == everything(roads, table, query, 100_000)


@given(robots=st.integers(1, 12), seed=st.integers(0, 1000), motion=st.sampled_from([Motion(), Motion(0.5, 2.0, 3.3)]))
@settings(deadline=None, max_examples=40)
def test_compiled_and_plain_arrive_together(robots: int, seed: int, motion: Motion) -> None:
    """Among robots with committed paths, the compiled search arrives at the same tick as the plain one."""
    roads = roads_on(travel_on(small_layout(stations=2), motion))
    planner = Sipp()
    table, _ = crowd(roads, planner, robots, seed)
    rng = np.random.default_rng(seed)
    for _ in range(3):
        query = newcomer(roads, table, 1000, 0, rng)
        path, slow = planner.search(roads, table, query), plain.search(roads, table, query)
        assert (None if path is None else path.end_tick) == (None if slow is None else slow.end_tick)
        if path is not None:
            assert_valid(roads, table, query, path)


@pytest.mark.parametrize("roads", [paper_roads(), two_way(paper_roads())], ids=["one-way", "two-way"])
def test_compiled_and_plain_arrive_together_in_a_crowd(roads: Roads) -> None:
    """Among a hundred robots, where states are queued again and again, both searches arrive at the same tick.

    What a planner has searched before makes no difference to the path it finds.
    """
    used = Sipp()
    table, queries = crowd(roads, used, 100, 3)
    now = min(query.start_tick for query in queries)
    rng = np.random.default_rng(3)
    for _ in range(20):
        query = newcomer(roads, table, 1000, now, rng)
        path, slow = used.search(roads, table, query), plain.search(roads, table, query)
        assert (None if path is None else path.end_tick) == (None if slow is None else slow.end_tick)
        assert Sipp().search(roads, table, query) == path


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
    assert table.size > 60
    assert any(query.start_tick for query in queries)


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
