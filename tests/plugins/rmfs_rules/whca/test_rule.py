"""PP rule `whca-n`: windows, waits, and its parameters."""

from __future__ import annotations

import math

import pytest

from reserving import hold_until
from rmfs_core.motion import Motion
from rmfs_core.traffic import Query, Reservations, roads_on
from rmfs_core.world import parse_map
from rmfs_core.world.travel import travel_on
from rmfs_rules.sipp import Sipp
from rmfs_rules.whca import WhcaN

CORRIDOR = parse_map("......\n@@@@@#\nqO....", "corridor")


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
