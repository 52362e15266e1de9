"""PP rule `whca-n`: its search."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crowds import crowd, newcomer, paper_roads
from reserving import hold_until
from rmfs_core.motion import Motion
from rmfs_core.traffic import Query, Reservations, occupancy, roads_on
from rmfs_core.world import parse_map
from rmfs_core.world.travel import travel_on
from rmfs_sipp import Sipp
from rmfs_testing import small_layout
from rmfs_whca import WhcaN

CORRIDOR = parse_map("......\n@@@@@#\nqO....", "corridor")


@pytest.mark.parametrize(("robots", "seed"), [(8, 0), (16, 1), (32, 2), (48, 3)])
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


def test_waits_are_of_two_seconds() -> None:
    """Where `sipp` leaves as soon as the way is free, `whca-n` leaves with the next full wait."""
    roads = roads_on(travel_on(CORRIDOR, Motion()))
    table = Reservations(roads.cells)
    hold_until(table, 1, 1, 0, 3100)
    first = Sipp().search(roads, table, Query(0, 0, 0, 0, 4))
    other = WhcaN(window_s=math.inf).search(roads, table, Query(0, 0, 0, 0, 4))
    assert first is not None
    assert other is not None
    assert (first.legs[0].wait_ticks, other.legs[0].wait_ticks) == (3100, 4000)


def test_a_way_that_stays_blocked_is_waited_for_within_the_window_only() -> None:
    """With another robot in the way for ever, the window's path goes as far as it can; the unlimited one is none."""
    roads = roads_on(travel_on(CORRIDOR, Motion()))
    table = Reservations(roads.cells)
    table.hold(1, 3, 0)
    path = WhcaN().search(roads, table, Query(0, 0, 0, 0, 4))
    assert path is not None
    assert path.end == 2
    assert path.end_tick >= 20_000
    assert WhcaN(window_s=math.inf).search(roads, table, Query(0, 0, 0, 0, 4)) is None


def test_a_search_gives_up() -> None:
    """After ``max_nodes`` there is no path."""
    roads = roads_on(travel_on(CORRIDOR, Motion()))
    assert WhcaN(max_nodes=1).search(roads, Reservations(roads.cells), Query(0, 0, 0, 0, 4)) is None


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ({"window_s": 0.0}, "expected a number > 0"),
        ({"window_s": math.nan}, "expected a number > 0"),
        ({"wait_s": 0.0}, r"expected a number >= 0\.001"),
        ({"wait_s": math.inf}, r"expected a number >= 0\.001"),
        ({"max_nodes": 0}, "must be >= 1"),
    ],
)
def test_impossible_parameters_are_refused(values: dict[str, float], problem: str) -> None:
    """Windows and waits must pass, searches must begin."""
    with pytest.raises(ValueError, match=problem):
        WhcaN(**values)  # type: ignore[arg-type]
