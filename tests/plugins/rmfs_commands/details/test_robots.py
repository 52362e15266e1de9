"""Where a robot's time goes, from hand-made events."""

from __future__ import annotations

import pytest
from attrs import evolve

from rmfs_commands.details.robots import Robots
from rmfs_core.events import (
    Event,
    PodLifted,
    PodStored,
    QueueJoined,
    RobotMoved,
    RobotsOnDuty,
    TaskAssigned,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.info import RunInfo
from rmfs_core.scenario.model import RobotsSection


def moved(start_s: int, wait_s: int, end_s: int, distance_m: int, pod: int | None) -> RobotMoved:
    """Return a leg of the first robot."""
    return RobotMoved(
        end_s * 1000,
        start_s * 1000,
        robot=0,
        origin=0,
        to=1,
        heading=0,
        wait_ticks=wait_s * 1000,
        turn_ticks=0,
        distance_m=distance_m,
        pod=pod,
    )


TRIP: tuple[Event, ...] = (
    TaskAssigned(10_000, robot=0, pod=0),
    moved(10, 3, 20, 7, None),  # waits 3 s
    PodLifted(22_000, 20_000, robot=0, pod=0, cell=1),
    moved(25, 1, 35, 9, 0),  # waits 3 s for its path, and 1 s on it
    QueueJoined(35_000, robot=0, pod=0, station=0),
    VisitStarted(40_000, visit=1, robot=0, pod=0, station=0),
    VisitEnded(47_000, visit=1, pod=0, station=0, picks=1, next_station=None),
    moved(47, 0, 57, 10, 0),
    PodStored(59_000, 57_000, robot=0, pod=0, cell=1),
)


def test_a_task_on_the_way(tiny: RunInfo) -> None:
    """A robot that steps aside gets a task: the rest of that leg counts to the task, and nobody waits."""
    robots = Robots(tiny, 0)
    robots.handlers[TaskAssigned](TaskAssigned(12_000, robot=0, pod=0))
    robots.handlers[RobotMoved](moved(10, 0, 15, 3, None))
    row = robots.rows(20_000)[0]
    assert (row["idle_s"], row["to_pod_s"], row["waiting_s"]) == (12, 8, 0)


@pytest.mark.parametrize(
    ("begin_s", "expected"),
    [
        (0, [26, 19, 21.0, 9.0, 9.0, 5.0, 7.0, 12.0, 7.0]),
        (34, [19, 19, 11.0, 0.0, 1.0, 5.0, 7.0, 12.0, 0.0]),
    ],
)
def test_a_trip(tiny: RunInfo, begin_s: int, expected: list[float]) -> None:
    """Fetching, driving, queueing, serving, storing, waiting for others and nothing add up to all of the time."""
    robots = Robots(tiny, begin_s * 1000)
    for event in TRIP:
        if type(event) in robots.handlers:
            robots.handlers[type(event)](event)
    row, other = robots.rows(70_000)
    assert list(row.values())[1:] == expected
    assert sum(list(row.values())[3:]) == 70 - begin_s
    assert other["idle_s"] == 70 - begin_s
    assert robots.waiting_ticks == expected[-1] * 1000


def test_waiting_for_room_at_the_station(tiny: RunInfo) -> None:
    """What lies between coming to the pod and lifting it is told apart from the other waiting."""
    robots = Robots(tiny, 0)
    late = PodLifted(62_000, 60_000, robot=0, pod=0, cell=1)
    for event in (*TRIP[:2], late, moved(65, 0, 70, 9, 0)):
        robots.handlers[type(event)](event)
    assert robots.for_room_ticks == 40_000
    assert robots.waiting_ticks == 46_000


def test_time_off_duty_is_no_idle_time(tiny: RunInfo) -> None:
    """A robot that has a task when it goes off duty finishes it first; there is no column for those always on duty."""
    assert "off_s" not in Robots(tiny, 0).rows(1000)[0]
    robots = Robots(
        evolve(tiny, scenario=evolve(tiny.scenario, robots=RobotsSection(available=(("00:00", "01:00"),)))), 0
    )
    for event in (*TRIP[:2], RobotsOnDuty(21_000, number=0), *TRIP[2:], RobotsOnDuty(100_000, number=1)):
        robots.handlers[type(event)](event)
    row = robots.rows(130_000)[0]
    assert (row["idle_s"], row["off_s"], row["storing_s"]) == (10 + 30, 41, 12)
