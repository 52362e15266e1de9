"""The compiled search of `sipp` against the plain one, and both against trying everything."""

from __future__ import annotations

import heapq

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import plain_sipp as plain
from crowds import crowd, newcomer, paper_roads, two_way
from reserving import hold_until, stay
from rmfs_commands.testing import small_layout
from rmfs_core.motion import Motion
from rmfs_core.traffic import FOREVER, Query, Reservations, Roads, TimedPath, occupancy, roads_on
from rmfs_core.world import parse_map
from rmfs_core.world.travel import travel_on
from rmfs_rules.sipp import Sipp

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
