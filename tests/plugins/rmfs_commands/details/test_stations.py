"""Where stations' time goes, from hand-made events."""

from __future__ import annotations

import pytest
from attrs import evolve

from rmfs_commands.details.stations import Stations
from rmfs_core.events import (
    Event,
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    QueueJoined,
    StationClosed,
    StationOpened,
    VisitStarted,
)
from rmfs_core.info import RunInfo
from rmfs_core.scenario.model import StationsSection

EVENTS: tuple[Event, ...] = (
    OrderArrived(0, 0),
    OrderAssigned(0, 0, station=0, skus=(0, 1), items=2, period=1, complete=True),
    OrderArrived(5_000, 1),
    QueueJoined(10_000, robot=0, pod=0, station=0),
    VisitStarted(20_000, visit=1, robot=0, pod=0, station=0),
    ItemPicked(27_000, 20_000, 33_000, visit=1, station=0, pod=0, order=0, sku=0),
    ItemPicked(40_000, 33_000, 46_000, visit=1, station=0, pod=0, order=0, sku=1),
    OrderAssigned(50_000, 1, station=1, skus=(0,), items=2, period=2, complete=True),
)


@pytest.mark.parametrize(
    ("begin_s", "first", "second"),
    [
        # 26 s of work; items wanted from 0 to 40 s; an order in the backlog from 5 to 50 s
        (0, [2, 1, 26, 20, 14, 4, 0.166667, 1], [0, 0, 0, 10, 50, 45, 0, 0]),
        (30, [1, 0, 16, 0, 14, 4, 0, 0], [0, 0, 0, 10, 20, 20, 0, 0]),
    ],
)
def test_two_stations(tiny: RunInfo, begin_s: int, first: list[float], second: list[float]) -> None:
    """Work, waiting for pods and idle time add up; a station starves when it is idle and orders wait."""
    stations = Stations(tiny)
    for event in EVENTS:
        if type(event) in stations.handlers:
            stations.handlers[type(event)](event)
    rows = stations.rows(begin_s * 1000, 60_000)
    assert [list(row.values())[1:] for row in rows] == [first, second]
    assert all(row["busy_s"] + row["waiting_s"] + row["idle_s"] == 60 - begin_s for row in rows)


def test_a_station_that_is_closed_is_not_idle(tiny: RunInfo) -> None:
    """It is open until 10 s, and works until 46 s; from 55 s on it is open again. The other one is always open."""
    assert Stations(tiny).values(0, 60_000) == {}
    stations = Stations(
        evolve(tiny, scenario=evolve(tiny.scenario, stations=StationsSection(open=(("00:00", "01:00"),))))
    )
    for event in (*EVENTS, StationClosed(10_000, 0), StationOpened(55_000, 0)):
        if type(event) in stations.handlers:
            stations.handlers[type(event)](event)
    first, second = stations.rows(0, 60_000)
    columns = ("busy_s", "waiting_s", "idle_s", "starved_s", "open_s")
    assert [first[column] for column in columns] == [26, 20, 5, 0, 51]
    assert second["open_s"] == 60
    assert stations.values(0, 60_000) == {"station_open_h": 111 / 3600, "open_utilisation_percent": 100 * 26 / 111}
