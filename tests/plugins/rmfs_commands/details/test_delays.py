"""What an order's time went to, from hand-made events."""

from __future__ import annotations

import pytest

from rmfs_commands.details.delays import COLUMNS, Delays
from rmfs_core.events import (
    Event,
    ItemPicked,
    OrderAssigned,
    OrderCompleted,
    PodLifted,
    QueueJoined,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.info import RunInfo

WAY = (
    PodLifted(15_000, 13_000, robot=0, pod=0, cell=3),
    QueueJoined(30_000, robot=0, pod=0, station=0),
    VisitStarted(42_000, visit=1, robot=0, pod=0, station=0),
    ItemPicked(49_000, 42_000, 55_000, visit=1, station=0, pod=0, order=0, sku=0),
    OrderCompleted(49_000, 0),
)


def part(tick_s: int, *, complete: bool) -> OrderAssigned:
    """Return the assignment of a line of the first order."""
    return OrderAssigned(tick_s * 1000, 0, 0, skus=(0,), items=1, period=1, complete=complete)


def row_of(run: RunInfo, *events: Event) -> list[float | None]:
    """Return what the first order's time went to."""
    delays = Delays(run, 0)
    for event in sorted(events, key=lambda event: event.tick):
        if type(event) in delays.handlers:
            delays.handlers[type(event)](event)
    row, other = delays.rows()
    assert set(other.values()) == {"second", None}
    assert row["turnover_s"] is None or sum(row[column] for column in COLUMNS) == row["turnover_s"]
    return [row[column] for column in COLUMNS]


@pytest.mark.parametrize(
    ("last_part_s", "expected"),
    [
        (10, [2, 8, 5, 15, 12, 7]),  # before the pod is fetched
        (20, [2, 18, 0, 10, 12, 7]),  # while it drives
        (35, [2, 33, 0, 0, 7, 7]),  # while it queues
        (45, [2, 43, 0, 0, 0, 4]),  # while it stands at the station
    ],
)
def test_an_order_of_two_parts(tiny: RunInfo, last_part_s: int, expected: list[float]) -> None:
    """The first part is assigned at 2 s; what the last pod did before the last part was assigned counts as nothing."""
    assert row_of(tiny, part(2, complete=False), part(last_part_s, complete=True), *WAY) == expected


def test_a_pod_that_comes_from_another_station(tiny: RunInfo) -> None:
    """It sets out for the station when it leaves the one before."""
    before = (
        PodLifted(3_000, 1_000, robot=0, pod=0, cell=3),
        QueueJoined(8_000, robot=0, pod=0, station=1),
        VisitStarted(9_000, visit=1, robot=0, pod=0, station=1),
        VisitEnded(20_000, visit=1, pod=0, station=1, picks=1, next_station=0),
    )
    assert row_of(tiny, part(2, complete=True), *before, *WAY[1:]) == [2, 0, 18, 10, 12, 7]


def test_a_pod_that_is_there_from_the_start(tiny: RunInfo) -> None:
    """Then an order waits in no queue and for no way."""
    assert row_of(tiny, part(0, complete=True), *WAY[3:]) == [0, 0, 0, 0, 0, 49]


def test_an_order_that_is_not_complete(tiny: RunInfo) -> None:
    """It has no times."""
    assert row_of(tiny, part(2, complete=True), *WAY[:3]) == [None] * 6
