"""How much robots without end of work lose to each other: the task of RHCR's fulfillment centre, in unit steps.

A robot drives to a random endpoint that no other stands in or drives to, and on from there to the next. The map is
made after J. Li, A. Tinka, S. Kiesel, J. W. Durham, T. K. S. Kumar, S. Koenig: Lifelong multi-agent
path finding in large-scale warehouses, AAAI 2021, https://doi.org/10.1609/aaai.v35i13.17344: 33 x 46 cells, a sixth of
them shelves, with endpoints above and below.

Robots drive a cell a second: no time is lost to speeding up, braking and turns. A robot has a cell from leaving the one
before to reaching the one after, so a follower stays a cell behind.
"""

from functools import lru_cache
from heapq import heappop, heappush
from typing import Any

import numpy as np
import pytest

from rmfs_commands.plan.movingai import open_layout
from rmfs_core.motion import Motion
from rmfs_core.world.travel import Travel
from rmfs_rules.sipp import Sipp
from rmfs_traffic import Query, Reservations, Roads, occupancy

STEP = 1_000
UNIT_STEPS = Motion(acceleration_m_per_s2=1e12, top_speed_m_per_s=1.0, full_turn_s=1e-9)
RATIOS = {20: 0.87, 60: 0.74, 100: 0.64}
"""Tasks done, to those without other robots in the way, at least."""


@lru_cache
def centre() -> tuple[Roads, tuple[int, ...]]:
    """Return the roads of the map, and its endpoints."""
    free, ends = np.ones((33, 46), dtype=bool), np.zeros((33, 46), dtype=bool)
    for row in range(2, 33, 4):
        for column in (7, 18, 29):
            shelf = slice(column, column + 10)
            free[row, shelf] = False
            ends[row - 1, shelf] = ends[row + 1, shelf] = True
    return Roads(Travel(open_layout(free), UNIT_STEPS)), tuple(map(int, np.flatnonzero(ends)))


def tasks_done(robots: int, steps: int, seed: int, planner: Sipp | None) -> int:
    """Return how many tasks are done in so many steps; without a planner robots drive through each other."""
    roads, ends = centre()
    rng, table, done = np.random.default_rng(seed), Reservations(roads.cells), 0
    waiting = [(0, robot, int(cell), 0) for robot, cell in enumerate(rng.permutation(ends)[:robots])]
    taken = {cell for _, _, cell, _ in waiting}
    for _, robot, cell, _ in waiting:
        table.hold(robot, cell, 0)
    while True:
        tick, robot, cell, heading = heappop(waiting)
        if tick > steps * STEP:
            return done
        done += tick > 0
        goal = int(rng.choice([end for end in ends if end not in taken]))
        taken ^= {cell, goal}
        if planner is None:
            heappush(waiting, (tick + roads.travel.ticks(cell, heading, goal, False), robot, goal, heading))
            continue
        table.forget_before(tick)
        path = planner.search(roads, table, Query(robot, cell, heading, tick, goal))
        assert path is not None
        table.commit(robot, occupancy(roads, path))
        heappush(waiting, (path.end_tick, robot, goal, path.end_heading))


@pytest.mark.parametrize("robots", [20, 60, 100])
def test_tasks_among_others(benchmark: Any, robots: int) -> None:
    """Bar: of the tasks that robots would do who drive through each other, `sipp` does so large a share.

    Where nothing is timed few steps will do: of these the last trips, which are not over, are a part.
    """
    steps = 2_000 if benchmark.enabled else 200
    done = benchmark.pedantic(lambda: tasks_done(robots, steps, 1, Sipp()), rounds=1)
    alone = tasks_done(robots, steps, 1, None)
    benchmark.extra_info["tasks_a_step"] = round(done / steps, 3)
    benchmark.extra_info["ratio"] = round(done / alone, 3)
    assert done >= (RATIOS[robots] if benchmark.enabled else 0.9 * RATIOS[robots]) * alone
