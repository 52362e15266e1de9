"""Counts by the hour, from hand-made events."""

from __future__ import annotations

from attrs import evolve

from rmfs_commands.details.hours import Hours
from rmfs_core.events import (
    Event,
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCompleted,
    RobotMoved,
    RobotsOnDuty,
    StationClosed,
    StationOpened,
    VisitStarted,
)
from rmfs_core.info import RunInfo
from rmfs_core.scenario.model import RobotsSection, StationsSection

H = 3_600_000
EVENTS: tuple[Event, ...] = (
    OrderArrived(0, 0),
    OrderArrived(H - 1, 1),
    OrderAssigned(H, 0, station=0, skus=(0,), items=1, period=1, complete=True),
    VisitStarted(H + 5, visit=1, robot=0, pod=0, station=0),
    RobotMoved(3 * H, 2 * H, robot=0, origin=0, to=1, heading=0, wait_ticks=0, turn_ticks=0, distance_m=12, pod=None),
    ItemPicked(3 * H + 7, 3 * H, 3 * H + 9, visit=1, station=0, pod=0, order=0, sku=0),
    OrderCompleted(3 * H + 7, 0),
)


def test_hours(tiny: RunInfo) -> None:
    """An event counts in the hour in which it is told, the backlog at the hour's end; an hour may be empty."""
    hours = Hours(tiny)
    for event in EVENTS:
        hours.handlers[type(event)](event)
    rows = hours.rows(3 * H + 7)
    assert [(row["hour"], row["start_s"]) for row in rows] == [(0, 0), (1, 3600), (2, 7200), (3, 10_800)]
    counted = ("orders_in", "orders_out", "picks", "visits", "distance_m", "backlog")
    assert [[row[name] for name in counted] for row in rows] == [
        [2, 0, 0, 0, 0, 2],
        [0, 0, 0, 1, 0, 1],
        [0, 0, 0, 0, 0, 1],
        [0, 1, 1, 0, 12, 1],
    ]


def test_a_run_that_ends_with_an_hour(tiny: RunInfo) -> None:
    """It has no further one."""
    assert len(Hours(tiny).rows(2 * H)) == 2


def test_who_is_there(tiny: RunInfo) -> None:
    """Means over the hour, and over what there is of the last one; no columns where nobody ever leaves."""
    spans = (("00:00", "01:00"),)
    scenario = evolve(
        tiny.scenario, stations=StationsSection(open=spans), robots=RobotsSection(count=2, available=spans)
    )
    hours = Hours(evolve(tiny, scenario=scenario))
    for event in (
        StationClosed(H // 4, 0),
        RobotsOnDuty(H + H // 2, number=1),
        StationOpened(2 * H + H // 4, 0),
    ):
        hours.handlers[type(event)](event)
    rows = hours.rows(2 * H + H // 2)
    assert [(row["stations_open"], row["robots_on_duty"]) for row in rows] == [(1.25, 2), (1, 1.5), (1.5, 1)]
    assert "stations_open" not in Hours(tiny).rows(H)[0]
