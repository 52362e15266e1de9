"""Prioritised planning of all robots' trips, one after another, over one reservation table.

Each robot holds the cell it stands in without end until its path is planned. Whoever finds no path asks again when the
others have planned theirs; a planner that looks ahead only so far is asked again where its path ends. A robot at its
goal stays there.

Source: M. Cap, P. Novak, A. Kleiner, M. Selecky, Prioritized planning algorithms for trajectory coordination of
multiple mobile robots, IEEE Transactions on Automation Science and Engineering 12(3), 2015,
https://doi.org/10.1109/TASE.2015.2445780
"""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heappop, heappush
from typing import Protocol

import numpy as np
from attrs import define, evolve, field, frozen

from rmfs_commands.plan.movingai import Trip
from rmfs_core.decisions import Leg
from rmfs_core.motion import Motion
from rmfs_core.world import NORTH, Layout
from rmfs_core.world.travel import Travel
from rmfs_traffic import Query, Reservations, Roads, TimedPath, occupancy, timed_path

RETRY_TICKS = 2000
PATIENCE_TICKS = 120_000
"""Simulated time after which planning ends when no robot came nearer to its goal than ever before."""


class Planner(Protocol):
    """Plans one robot's path among the reservations of the others. Changes nothing."""

    def search(self, roads: Roads, table: Reservations, query: Query) -> TimedPath | None:
        """Return a path whose `occupancy` hits no reservation, its end held forever; None when there is none."""


@frozen
class Plan:
    """Result of a trip.

    Parameters
    ----------
    trip
        From where to where.
    path
        All that the robot drives, from tick 0 on.
    arrived
        Whether that ends at the goal.
    fastest_ticks
        Ticks that the trip would take without any other robot.
    queries
        How often the planner was asked.
    """

    trip: Trip
    path: TimedPath
    arrived: bool
    fastest_ticks: int
    queries: int

    @property
    def delay_ticks(self) -> int:
        """Ticks lost to the other robots."""
        return self.path.end_tick - self.fastest_ticks


@define
class _Robot:
    """A robot while planning goes on."""

    number: int
    trip: Trip
    query: Query
    nearest: int
    legs: list[Leg] = field(factory=list)
    queries: int = 0
    arrived: bool = False


def roads_of_map(layout: Layout) -> Roads:
    """Return the roads of a map, for robots that move as in the paper."""
    return Roads(Travel(layout, Motion()))


def plan_trips(roads: Roads, planner: Planner, trips: Sequence[Trip], exclusive: bool = True) -> tuple[Plan, ...]:
    """Plan every trip, in the order given; all robots face north at first and set out at tick 0.

    Parameters
    ----------
    roads
        The layout.
    planner
        Finds each path.
    trips
        One for each robot.
    exclusive
        Whether paths keep clear of each other. If not, nothing is reserved: robots drive through each other.
    """
    table = Reservations(roads.cells)
    robots = []
    for number, trip in enumerate(trips):
        query = Query(number, trip.start, NORTH, 0, trip.goal)
        robots.append(_Robot(number, trip, query, roads.travel.ticks(trip.start, NORTH, trip.goal, False)))
        if exclusive:
            table.hold(number, trip.start, 0)
    waiting = [(0, 0, robot.number) for robot in robots]
    failed = progress = 0
    while waiting:
        tick, attempt, number = heappop(waiting)
        if tick > progress + PATIENCE_TICKS:
            break
        robot = robots[number]
        table.forget_before(tick)
        path = _next_path(roads, planner, table, robot)
        if path is None:
            failed += 1
            # Once more when all who are due now have had their turn; if none of them moved, two seconds later.
            due = sum(entry[0] == tick for entry in waiting)
            later = failed > due
            heappush(waiting, (tick + RETRY_TICKS, 0, number) if later else (tick, attempt + 1, number))
            if later:
                _wait(robot, RETRY_TICKS)
            continue
        failed = 0
        if exclusive:
            table.commit(number, occupancy(roads, path, since=tick))
        robot.legs += path.legs
        robot.query = evolve(robot.query, cell=path.end, heading=path.end_heading, start_tick=path.end_tick)
        robot.arrived = path.end == robot.trip.goal
        if not robot.arrived:
            heappush(waiting, (path.end_tick, 0, number))
        left = roads.travel.ticks(path.end, path.end_heading, robot.trip.goal, False)
        if robot.arrived or left < robot.nearest:
            robot.nearest, progress = left, max(progress, path.end_tick)
    return tuple(_plan(roads, robot) for robot in robots)


def plan_in_orders(
    roads: Roads, planner: Planner, trips: Sequence[Trip], effort: int, rng: np.random.Generator
) -> tuple[Plan, ...]:
    """Plan every trip, in the order given, and in random orders as long as robots are left without a path.

    Parameters
    ----------
    roads, planner, trips
        As for `plan_trips`; the planner reserves.
    effort
        No other order is tried once there were so many queries for each robot, on average.
    rng
        Draws the orders.

    Returns
    -------
    tuple[Plan, ...]
        Those in which the most robots arrive, and of these the ones with the least sum of costs.
    """
    best = plan_trips(roads, planner, trips)
    queries = sum(plan.queries for plan in best)
    while not all(plan.arrived for plan in best) and queries < effort * len(trips):
        order = rng.permutation(len(trips)).tolist()
        plans = plan_trips(roads, planner, [trips[robot] for robot in order])
        queries += sum(plan.queries for plan in plans)
        best = min(best, tuple(plans[order.index(robot)] for robot in range(len(trips))), key=_badness)
    return best


def _badness(plans: Sequence[Plan]) -> tuple[int, int]:
    return sum(not plan.arrived for plan in plans), sum(plan.path.end_tick for plan in plans if plan.arrived)


def _next_path(roads: Roads, planner: Planner, table: Reservations, robot: _Robot) -> TimedPath | None:
    robot.queries += 1
    path = planner.search(roads, table, robot.query)
    stays = path is not None and path.end_tick <= robot.query.start_tick and path.end != robot.trip.goal
    return None if stays else path


def _wait(robot: _Robot, ticks: int) -> None:
    robot.legs.append(Leg(robot.query.cell, ticks))
    robot.query = evolve(robot.query, start_tick=robot.query.start_tick + ticks)


def _plan(roads: Roads, robot: _Robot) -> Plan:
    start = Query(robot.number, robot.trip.start, NORTH, 0, robot.trip.goal)
    path = timed_path(roads, start, tuple(robot.legs))
    fastest = roads.travel.ticks(robot.trip.start, NORTH, robot.trip.goal, False)
    return Plan(robot.trip, path, robot.arrived, fastest, robot.queries)
