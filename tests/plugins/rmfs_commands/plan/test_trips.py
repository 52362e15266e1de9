"""Random trips: starts and goals all different, each goal in reach."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.plan import random_trips, roads_of_map
from rmfs_commands.testing import small_layout
from rmfs_core.clock import UNREACHABLE
from rmfs_core.errors import InputError
from rmfs_core.world import CellKind, parse_map

HALL = roads_of_map(small_layout(stations=2))
HALVES = roads_of_map(parse_map("..@..\n..@..", "halves"))


@given(robots=st.integers(1, len(HALL.layout.storage_locations) // 2), seed=st.integers(0, 10_000))
def test_trips_join_storage_locations(robots: int, seed: int) -> None:
    """While there are enough of them; no two robots share a place."""
    trips = random_trips(HALL, robots, seed, "hall")
    places = [place for trip in trips for place in (trip.start, trip.goal)]
    assert len(trips) == robots
    assert len(set(places)) == 2 * robots
    assert {int(HALL.layout.kind[place]) for place in places} == {CellKind.STORAGE}
    assert trips == random_trips(HALL, robots, seed, "elsewhere")


def test_floor_is_used_where_storage_locations_are_too_few() -> None:
    """One robot more than there is room for in them."""
    robots = len(HALL.layout.storage_locations) // 2 + 1
    trips = random_trips(HALL, robots, 1, "hall")
    kinds = {int(HALL.layout.kind[place]) for trip in trips for place in (trip.start, trip.goal)}
    assert kinds == {CellKind.STORAGE, CellKind.FLOOR}


@given(st.integers(0, 10_000))
def test_a_goal_is_in_reach(seed: int) -> None:
    """On a map in two halves, a robot stays in its own."""
    for trip in random_trips(HALVES, 4, seed, "halves"):
        assert HALVES.travel.ticks(trip.start, 1, trip.goal, False) < UNREACHABLE
        assert (trip.start % 5 < 2) == (trip.goal % 5 < 2)


def test_seeds_differ() -> None:
    """Another seed has other trips."""
    assert len({random_trips(HALL, 5, seed, "hall") for seed in range(5)}) == 5


@pytest.mark.parametrize(("text", "found"), [("..@..\n..@..", 4), (".@.\n", 0)])
def test_a_map_that_is_too_small_is_refused(text: str, found: int) -> None:
    """With the place, and how many robots it has room for."""
    with pytest.raises(InputError) as caught:
        random_trips(roads_of_map(parse_map(text, "map")), 5, 1, "my.map")
    room = f"{found} robots with start and goal"
    assert str(caught.value) == f"my.map: found room for {room}; expected 5"
