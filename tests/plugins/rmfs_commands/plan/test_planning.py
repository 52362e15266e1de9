"""Prioritised planning: all robots' trips, one after another, over one reservation table."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from attrs import define, field

from rmfs_commands.plan import collisions, plan_in_orders, plan_trips
from rmfs_commands.plan.movingai import Trip
from rmfs_commands.plan.planning import PATIENCE_TICKS, RETRY_TICKS
from rmfs_core.decisions import Leg
from rmfs_core.motion import Motion
from rmfs_core.traffic import Query, Reservations, Roads, TimedPath, roads_on, timed_path
from rmfs_core.world import NORTH, parse_map
from rmfs_core.world.travel import travel_on
from rmfs_rules.sipp import Sipp

EVEN = Motion(acceleration_m_per_s2=1e12, top_speed_m_per_s=1.0, full_turn_s=4.0)
"""A second for each cell and each quarter turn."""
CORRIDOR = roads_on(travel_on(parse_map("....", "corridor"), EVEN))
HALL = roads_on(travel_on(parse_map("....\n....", "hall"), EVEN))


@define
class Scripted:
    """A planner that answers as told, and notes what it was asked."""

    answer: Callable[[Query], TimedPath | None]
    queries: list[Query] = field(factory=list)

    def search(self, roads: Roads, table: Reservations, query: Query) -> TimedPath | None:
        """Return the answer."""
        self.queries.append(query)
        return self.answer(query)


def straight(roads: Roads, query: Query, to: int) -> TimedPath:
    """Return the path of one leg."""
    return timed_path(roads, query, (Leg(to),))


def test_alone_a_trip_takes_what_it_takes() -> None:
    """Robots face north at first and set out at once; a trip to where one is takes nothing."""
    plan, still = plan_trips(HALL, Sipp(), [Trip(0, 3), Trip(4, 4)])
    assert (plan.path.start_tick, plan.path.heading, plan.path.end, plan.path.end_tick) == (0, NORTH, 3, 4000)
    assert (plan.arrived, plan.fastest_ticks, plan.delay_ticks, plan.queries) == (True, 4000, 0, 1)
    assert (still.arrived, still.path.legs, still.fastest_ticks) == (True, (), 0)


def test_the_order_given_is_the_order_of_planning() -> None:
    """The first robot drives as if alone, the second one around it; delays are what that costs."""
    first, second = plan_trips(HALL, Sipp(), [Trip(0, 3), Trip(5, 1)])
    assert first.delay_ticks == 0
    assert second.delay_ticks > 0
    assert second.path.end_tick == second.fastest_ticks + second.delay_ticks
    assert collisions(HALL, [first.path, second.path]) == ()


def test_who_finds_no_path_asks_again_when_others_have_moved() -> None:
    """The robot that drives first frees the way for the one that was asked before it."""
    behind, ahead = plan_trips(CORRIDOR, Sipp(), [Trip(0, 1), Trip(1, 3)])
    assert behind.arrived
    assert ahead.arrived
    assert (behind.queries, ahead.queries) == (2, 1)


def test_who_cannot_pass_gives_up() -> None:
    """Two robots face each other in a corridor: both wait until patience ends, and stay where they are."""
    plans = plan_trips(CORRIDOR, Sipp(), [Trip(0, 3), Trip(3, 0)])
    assert [(plan.arrived, plan.path.end) for plan in plans] == [(False, 0), (False, 3)]
    assert all(PATIENCE_TICKS <= plan.path.end_tick <= PATIENCE_TICKS + 2 * RETRY_TICKS for plan in plans)


def test_a_planner_that_looks_ahead_so_far_is_asked_again_where_its_path_ends() -> None:
    """From there, with the heading and the time of the end; the legs of all its paths make the trip."""
    planner = Scripted(lambda query: straight(CORRIDOR, query, query.cell + 1))
    (plan,) = plan_trips(CORRIDOR, planner, [Trip(0, 3)])
    assert [(query.cell, query.heading, query.start_tick) for query in planner.queries] == [
        (0, NORTH, 0),
        (1, 0, 2000),
        (2, 0, 3000),
    ]
    assert (plan.arrived, plan.queries, [leg.to for leg in plan.path.legs]) == (True, 3, [1, 2, 3])


def test_a_path_that_stays_is_no_path() -> None:
    """A planner whose answer leads nowhere, in no time, is asked again two seconds later."""
    planner = Scripted(
        lambda query: straight(CORRIDOR, query, 3) if query.start_tick else timed_path(CORRIDOR, query, ())
    )
    (plan,) = plan_trips(CORRIDOR, planner, [Trip(0, 3)])
    assert plan.arrived
    assert plan.path.legs[0] == Leg(0, RETRY_TICKS)
    assert plan.path.end_tick == RETRY_TICKS + 4000


@pytest.mark.parametrize(("effort", "arrived"), [(0, [False, False]), (1000, [True, True])])
def test_other_orders_are_tried_while_robots_are_lost(effort: int, arrived: list[bool]) -> None:
    """The order does not matter to what a trip's plan is; without effort there is one order alone."""
    orders: list[bool] = []  # whether the robot from cell 3 was asked first

    def answer(query: Query) -> TimedPath | None:
        if query.start_tick == 0 and query.robot == 0:
            orders.append(query.cell == 3)
        return straight(CORRIDOR, query, query.goal) if orders[-1] else None

    plans = plan_in_orders(CORRIDOR, Scripted(answer), [Trip(0, 1), Trip(3, 2)], effort, np.random.default_rng(1))
    assert [plan.arrived for plan in plans] == arrived
    assert [plan.trip for plan in plans] == [Trip(0, 1), Trip(3, 2)]


@pytest.mark.parametrize("exclusive", [True, False])
def test_robots_hold_where_they_stand_unless_nothing_is_reserved(exclusive: bool) -> None:
    """Every start is in the table before anybody plans."""
    seen: list[int] = []

    class Looks:
        def search(self, roads: Roads, table: Reservations, query: Query) -> TimedPath | None:
            seen.append(sum(len(table.reserved(cell)) for cell in range(roads.cells)))
            return straight(roads, query, query.goal)

    plan_trips(HALL, Looks(), [Trip(0, 1), Trip(6, 7)], exclusive)
    assert seen[0] == (2 if exclusive else 0)
    assert (seen[1] > 2) is exclusive
