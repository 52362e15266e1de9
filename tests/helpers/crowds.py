"""Random robots with committed paths: traffic for tests and benchmarks of planners."""

import numpy as np

from rmfs_commands.layouts import block_map, parse_map
from rmfs_commands.plan.movingai import open_layout
from rmfs_commands.plan.planning import Planner, roads_of_map
from rmfs_core.motion import Motion
from rmfs_core.scenario.model import LayoutSection
from rmfs_core.world import Layout
from rmfs_core.world.travel import travel_on
from rmfs_traffic import Query, Reservations, Roads, occupancy, roads_on

_LAYOUTS: dict[str, Layout] = {}


def paper_roads() -> Roads:
    """Return the paper's layout: 504 storage locations, four stations with queues of twelve."""
    if "paper" not in _LAYOUTS:
        _LAYOUTS["paper"] = parse_map(block_map(LayoutSection(), 12), "layout")
    return roads_on(travel_on(_LAYOUTS["paper"], Motion()))


def two_way(roads: Roads) -> Roads:
    """Return the roads of the same free cells without one-way aisles: what a plain grid search knows of a layout."""
    layout = roads.layout
    free = roads.travel.passable(layout.storage_locations[0], False).reshape(layout.height, layout.width)
    return roads_of_map(open_layout(free))


def ends(roads: Roads) -> tuple[int, ...]:
    """Cells that trips begin and end in: the storage locations, or every free cell where there are none."""
    return roads.layout.storage_locations or tuple(map(int, np.flatnonzero(roads.layout.kind)))


def crowd(roads: Roads, planner: Planner, robots: int, seed: int, warm_up: int = 2) -> tuple[Reservations, list[Query]]:
    """Let robots drive between random places; return the table and the query that each one asks next.

    Each robot has a path committed all the time. Its next query is planned from the end of the one before, ``warm_up``
    times over, in the order in which robots arrive.
    """
    rng = np.random.default_rng(seed)
    places = rng.permutation(np.array(ends(roads)))
    table = Reservations(roads.cells)
    queries = []
    for robot in range(robots):
        table.hold(robot, int(places[robot]), 0)
        queries.append(Query(robot, int(places[robot]), int(rng.integers(4)), 0, 0))
    free = [int(place) for place in places[robots:]]
    for _ in range(warm_up * robots):
        robot = min(range(robots), key=lambda i: (queries[i].start_tick, i))
        query = with_goal(queries[robot], free.pop(int(rng.integers(len(free)))), bool(rng.integers(2)))
        table.forget_before(query.start_tick)
        path = planner.search(roads, table, query)
        if path is None:
            free.append(query.goal)
            queries[robot] = Query(robot, query.cell, query.heading, query.start_tick + 2000, 0)
            continue
        table.commit(robot, occupancy(roads, path))
        free.append(query.cell)
        queries[robot] = Query(robot, path.end, path.end_heading, path.end_tick, 0)
    return table, queries


def with_goal(query: Query, goal: int, loaded: bool) -> Query:
    return Query(query.robot, query.cell, query.heading, query.start_tick, goal, loaded)


def newcomer(roads: Roads, table: Reservations, robot: int, now: int, rng: np.random.Generator) -> Query:
    """Return a query of one more robot, between two places that it can stay at."""
    while True:
        start, goal = (int(rng.choice(ends(roads))) for _ in range(2))
        if start != goal and table.blocker(start, now) is None and table.blocker(goal, now + 3_600_000) is None:
            return Query(robot, start, int(rng.integers(4)), now, goal, bool(rng.integers(2)))
