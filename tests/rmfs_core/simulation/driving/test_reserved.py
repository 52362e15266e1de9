"""Robots that keep out of each other's way, whatever way their paths are reserved."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from corridor import CORRIDOR, INSTANCE, inline
from rmfs_commands.testing import small_layout
from rmfs_core.errors import InputError, RuleError
from rmfs_core.events import (
    Event,
    OrderCompleted,
    PodStored,
    QueueJoined,
    RobotMoved,
    TaskAssigned,
    VisitStarted,
)


@pytest.fixture(params=["sipp", "whca-n"])
def pp(request: pytest.FixtureRequest) -> str:
    """Return each rule that reserves."""
    return str(request.param)


def test_every_order_is_completed(tiny_run: Callable[..., Any], pp: str) -> None:
    """More robots than the queue has cells: the run ends with every order complete."""
    tiny = tiny_run(INSTANCE, capacity=3, robots=6, queue_length=1, pp=pp)
    tiny.simulation.run()
    assert len(tiny.recorder.of(OrderCompleted)) == 16


def test_robots_line_up_and_are_served_in_order(tiny_run: Callable[..., Any], pp: str) -> None:
    """Pods start their visits in the order in which they joined the queue."""
    tiny = tiny_run(INSTANCE, capacity=3, robots=4, pp=pp)
    tiny.simulation.run()
    joined = [event.pod for event in tiny.recorder.of(QueueJoined)]
    assert [event.pod for event in tiny.recorder.of(VisitStarted)] == joined


def test_pods_at_the_station_from_the_start_are_served_first(tiny_run: Callable[..., Any], pp: str) -> None:
    """Robots that stand in line at time 0 hold their cells, and the others queue behind them."""
    tiny = tiny_run(INSTANCE, capacity=3, robots=4, pp=pp, at_stations={"1": ("2", "3")})
    tiny.simulation.run()
    assert [event.pod for event in tiny.recorder.of(VisitStarted)][:2] == [1, 2]
    assert len(tiny.recorder.of(OrderCompleted)) == 16


def moved_without_a_task(events: list[Event]) -> bool:
    """Whether some robot drove though it had no task."""
    busy: set[int] = set()
    for event in events:
        if isinstance(event, TaskAssigned):
            busy.add(event.robot)
        elif isinstance(event, PodStored):
            busy.discard(event.robot)
        elif isinstance(event, RobotMoved) and event.robot not in busy:
            return True
    return False


@pytest.mark.parametrize("seed", range(4))
def test_idle_robots_step_aside(tiny_run: Callable[..., Any], pp: str, seed: int) -> None:
    """With a robot in all locations but one, robots are in each other's way all the time; empty ones give way."""
    layout = small_layout(1, block_columns=1, queue_length=1)
    tiny = tiny_run(
        INSTANCE, capacity=3, robots=len(layout.storage_locations) - 1, queue_length=1, layout=layout, pp=pp, seed=seed
    )
    tiny.simulation.run()
    assert len(tiny.recorder.of(OrderCompleted)) == 16
    assert moved_without_a_task(tiny.recorder.events)


@pytest.mark.parametrize("reserves", ["full paths", "windows"])
def test_a_path_that_hits_a_reservation_is_refused(tiny_run: Callable[..., Any], tmp_path: Path, reserves: str) -> None:
    """A rule that heeds nobody is named, with the robot in the way and the cell."""
    tiny = tiny_run(INSTANCE, capacity=3, robots=4, layout=CORRIDOR, queue_length=1, pp=inline(tmp_path, reserves))
    with pytest.raises(RuleError, match=r"mine.py.*a path that hits a reservation: robot \d has row \d+, column \d+"):
        tiny.simulation.run()


def test_one_location_is_left_for_who_steps_aside(tiny_run: Callable[..., Any], pp: str) -> None:
    """As many robots as storage locations are refused before the run."""
    layout = small_layout(1, block_columns=1, queue_length=1)
    count = len(layout.storage_locations)
    with pytest.raises(InputError, match=rf"robots.count: found {count} robots and {count} storage locations"):
        tiny_run(INSTANCE, capacity=3, robots=count, queue_length=1, layout=layout, pp=pp)


@pytest.mark.parametrize("pp", ["sipp", "whca-n", "free-flow"])
def test_who_finds_nobody_in_line_takes_the_shortcut(pp: str) -> None:
    """A robot by itself drives 6 m less a visit, and from the ring 8 m, whoever plans its paths."""

    def visits_and_metres(queue: str) -> tuple[float, float]:
        settings = [f"rules.pp={pp}", f"layout.queue={queue}", "robots.count=1", "stations.queue_length=12"]
        # At a pick the robot is at the station in both, so that the same is decided; 6 s later it would not be.
        metrics = rmfs_core.run("examples/small", overrides=[*settings, "stations.release=picked"]).metrics
        return metrics["pod_station_visits"], metrics["loaded_distance_m"]

    (visits, plain), (same, short) = visits_and_metres("plain"), visits_and_metres("shortcut")
    assert visits == same
    assert 6 * visits <= plain - short <= 8 * visits
