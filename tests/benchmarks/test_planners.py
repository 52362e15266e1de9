"""How long a path query takes. `make bench` measures; the bars are asserted there only, as ratios taken in one run.

The peer is w9-pathfinding, a C++ library: space-time A* on the same grid, among the same robots. Its time is in steps
of a second, its robots have no kinematics and no heading, so its problem is the simpler one. As it knows no one-way
aisles either, both drive over the cells of the paper's layout in all four directions. Our travel times to the goals
are computed before the clock starts, as they are at hand in a run.
"""

import statistics
import time
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from w9_pathfinding.envs import Grid
from w9_pathfinding.mapf import ReservationTable, SpaceTimeAStar

from crowds import crowd, newcomer, paper_roads, two_way, with_goal
from rmfs_rules.sipp import Sipp
from rmfs_traffic import FOREVER, Query, Reservations, Roads

QUERIES = 100


@lru_cache
def scene(robots: int) -> tuple[Roads, Reservations, list[Query]]:
    """Return robots with committed paths on the paper's layout, and the queries of one more."""
    roads = two_way(paper_roads())
    table, queries = crowd(roads, Sipp(), robots, 1, warm_up=3)
    now = min(query.start_tick for query in queries)
    table.forget_before(now)
    rng = np.random.default_rng(5)
    # Without a pod: the peer knows one kind of free cell.
    new = [newcomer(roads, table, 1000, now, rng) for _ in range(QUERIES)]
    asked = [with_goal(query, query.goal, False) for query in new]
    for query in asked:
        roads.travel.times_to(query.goal, False)
    return roads, table, asked


def median_s(ask: Callable[[Query], object], queries: list[Query]) -> float:
    """Median seconds of a query, the best of three turns each."""
    seconds = []
    for query in queries:
        turns = []
        for _ in range(3):
            started = time.perf_counter()
            ask(query)
            turns.append(time.perf_counter() - started)
        seconds.append(min(turns))
    return statistics.median(seconds)


def peer(roads: Roads, table: Reservations, start: int) -> tuple[Any, Any]:
    """Return the peer's grid and its table of the same reservations, in steps of a second from ``start``."""
    layout = roads.layout
    passable = roads.travel.passable(0, False).reshape(layout.height, layout.width)
    grid = Grid(weights=np.where(passable, 1, -1).tolist(), edge_collision=True)
    reserved = ReservationTable(grid)
    for cell in np.flatnonzero(passable.ravel()):
        place = (int(cell) % layout.width, int(cell) // layout.width)
        for _, since, until in table.reserved(int(cell)):
            first = max(0, (since - start) // 1000)
            if until >= FOREVER:
                reserved.add_vertex_constraint(first, place, permanent=True)
            else:
                for step in range(first, -(-(until - start) // 1000)):
                    reserved.add_vertex_constraint(step, place)
    return grid, reserved


@pytest.mark.parametrize("robots", [8, 32, 100])
def test_sipp_against_the_peer(benchmark: Any, robots: int) -> None:
    """Bar: the median query is not slower than the peer's."""
    roads, table, queries = scene(robots)
    planner = Sipp()
    grid, reserved = peer(roads, table, queries[0].start_tick)
    search = SpaceTimeAStar(grid)
    width = roads.layout.width

    def ask_peer(query: Query) -> Any:
        start, goal = ((cell % width, cell // width) for cell in (query.cell, query.goal))
        return search.find_path(start, goal, max_length=300, reservation_table=reserved)

    found = sum(bool(ask_peer(query)) for query in queries[: QUERIES if benchmark.enabled else 3])
    assert found
    benchmark.pedantic(lambda: [planner.search(roads, table, query) for query in queries], rounds=5, warmup_rounds=1)
    if benchmark.enabled:
        ours, theirs = median_s(lambda query: planner.search(roads, table, query), queries), median_s(ask_peer, queries)
        benchmark.extra_info["median_us"] = round(ours * 1e6, 1)
        benchmark.extra_info["peer_median_us"] = round(theirs * 1e6, 1)
        benchmark.extra_info["peer_found"] = found
        assert ours <= theirs
