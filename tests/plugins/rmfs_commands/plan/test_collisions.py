"""Whether two paths meet, found out from positions alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rmfs_commands.plan import collisions, find_planner, plan_trips, roads_of_map
from rmfs_commands.plan.movingai import Trip
from rmfs_commands.testing import small_layout
from rmfs_core.decisions import Leg
from rmfs_core.motion import Motion
from rmfs_core.traffic import Query, Reservations, ReservedError, TimedPath, occupancy, roads_on, timed_path
from rmfs_core.world import EAST, NORTH, SOUTH, WEST, parse_map
from rmfs_core.world.travel import travel_on

HALL = roads_of_map(parse_map("......\n......", "hall"))
EVEN = roads_on(
    travel_on(parse_map("......\n......", "hall"), Motion(acceleration_m_per_s2=1e12, top_speed_m_per_s=1.0))
)
"""A robot has the cell it leaves until a second after, when it stands in the next one."""


def drive(cell: int, *legs: Leg, heading: int = EAST) -> TimedPath:
    """Return a path in the hall."""
    return timed_path(HALL, Query(0, cell, heading, 0, legs[-1].to), legs)


def even(cell: int, *legs: Leg, heading: int = EAST) -> TimedPath:
    """Return a path of a metre a second."""
    return timed_path(EVEN, Query(0, cell, heading, 0, legs[-1].to), legs)


def test_collisions_are_found() -> None:
    """Following too closely, meeting head on, and driving into who stays: each is one overlap or more."""
    first = drive(0, Leg(5))
    assert collisions(HALL, [first, drive(6, Leg(11))]) == ()
    assert {hit.cell for hit in collisions(HALL, [first, drive(5, Leg(0), heading=WEST)])} == {2, 3}
    assert [hit.cell for hit in collisions(HALL, [first, drive(5, Leg(5, 1000))])] == [5]
    assert collisions(HALL, [drive(1, Leg(5)), drive(0, Leg(4, 500))])
    assert collisions(HALL, [drive(1, Leg(5)), drive(0, Leg(4, 2100))]) == ()


def test_who_and_when() -> None:
    """The numbers of the paths, the lower first, and when both have the cell: for ever where one stays."""
    (hit,) = collisions(EVEN, [even(5, Leg(5)), even(0, Leg(5))])
    assert (hit.cell, hit.first, hit.second) == (5, 0, 1)
    assert hit.since_s == pytest.approx(4)
    assert hit.until_s == math.inf
    (hit,) = collisions(EVEN, [even(0, Leg(5)), even(9, Leg(3, 2500), Leg(9), heading=NORTH)])
    assert (hit.cell, hit.first, hit.second) == (3, 0, 1)
    assert (hit.since_s, hit.until_s) == (pytest.approx(2.5), pytest.approx(4))


def test_a_cell_may_be_entered_when_the_next_one_is_reached() -> None:
    """Two metres apart there is no collision, a tenth of a second less is one."""
    ahead = even(2, Leg(5))
    assert collisions(EVEN, [ahead, even(0, Leg(3))]) == ()
    late = even(2, Leg(5, 100))
    assert {hit.cell for hit in collisions(EVEN, [late, even(0, Leg(3))])} == {2, 3}


def test_the_earliest_is_first() -> None:
    """Wherever it is, and whoever has it."""
    hits = collisions(
        EVEN, [even(0, Leg(5)), even(5, Leg(5)), even(7, Leg(1), heading=NORTH), even(9, Leg(3), heading=NORTH)]
    )
    assert [hit.since_s for hit in hits] == sorted(hit.since_s for hit in hits)
    assert {hit.second for hit in hits if hit.first == 0} == {1, 2, 3}


@pytest.mark.parametrize("seed", range(6))
def test_they_agree_with_the_reservation_table(seed: int) -> None:
    """Where the table refuses a path there is a collision, and where it takes it there is none."""
    roads = roads_of_map(small_layout())
    rng = np.random.default_rng(seed)
    cells = roads.layout.storage_locations
    planner = find_planner("free-flow", {}, rng)
    starts = rng.permutation(cells)[:3]
    goals = rng.permutation([cell for cell in cells if cell not in starts])[:3]
    trips = [Trip(int(a), int(b)) for a, b in zip(starts, goals, strict=True)]
    paths = [plan.path for plan in plan_trips(roads, planner, trips, exclusive=False)]
    table, refused = Reservations(roads.cells), False
    for robot, path in enumerate(paths):
        try:
            table.commit(robot, occupancy(roads, path))
        except ReservedError:
            refused = True
    assert bool(collisions(roads, paths)) == refused


def test_no_collision_in_a_crowd() -> None:
    """Paths committed one after another never meet: the two ways to find out agree."""
    roads = roads_of_map(small_layout(stations=2))
    planner = find_planner("sipp", {}, np.random.default_rng(1))
    cells = roads.layout.storage_locations
    trips = [Trip(cells[i], cells[-1 - i]) for i in range(len(cells) // 2)]
    plans = plan_trips(roads, planner, trips)
    assert all(plan.arrived for plan in plans)
    assert collisions(roads, [plan.path for plan in plans]) == ()


def test_turning_takes_time() -> None:
    """A cell in which a robot turns is its own until it has left it."""
    south = even(0, Leg(2), Leg(8))
    after = even(3, Leg(2, 2000), heading=WEST)
    assert [hit.cell for hit in collisions(EVEN, [south, after])] == [2]
    assert south.end_heading == SOUTH
