"""Faults of the runs of robots, one by one, in traces written by hand and in a run of many orders."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from attrs import evolve

from damage import Damage, assert_found, change, drop
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation import faults_of
from rmfs_core.events import PodLifted, RobotMoved
from rmfs_core.motion import Motion
from rmfs_core.world import NORTH, SOUTH

ONE_WAY = "\n".join(["........", ".>>>>>>.", "...@....", "..##.##.", "......qO", "........"])


def kinds(script: Any) -> list[str]:
    """Return the kinds of faults in a script's trace, in the order of time."""
    return [fault.kind for fault in faults_of(script.trace())]


def diagonal(script: Any) -> None:
    """Drive along no row and no column."""
    script.drive(0, 0, 3)
    script.drive(0, 2, 5)


def against(script: Any) -> None:
    """Drive a one-way aisle the wrong way."""
    script.drive(0, 1, 0)
    script.drive(0, 1, 4)
    script.drive(0, 1, 2)


def into_wall(script: Any) -> None:
    """Drive through a wall."""
    script.drive(0, 2, 0)
    script.drive(0, 2, 5)


def under_pods(script: Any) -> None:
    """Drive to the pod under the other one, and lift it."""
    script.drive(0, 3, 0)
    script.drive(0, 3, 3)
    script.fetch(0, 0)


def through_pod(script: Any) -> None:
    """Carry a pod through another one's storage location."""
    under_pods(script)
    script.drive(0, 3, 0)


def over_storage(script: Any) -> None:
    """Carry a pod across free storage locations."""
    under_pods(script)
    script.drive(0, 4, 3)
    script.drive(0, 4, 4)
    script.drive(0, 3, 4)
    script.drive(0, 3, 7)


def rest_on_storage(script: Any) -> None:
    """Carry a pod to a free storage location, and on again."""
    under_pods(script)
    script.drive(0, 3, 5)
    script.drive(0, 3, 4)


def without_pod_in_queue(script: Any) -> None:
    """Enter a queue without a pod."""
    script.drive(0, 4, 0)
    script.drive(0, 4, 6)


def through_queue(script: Any) -> None:
    """Carry a pod through a queue and past the station."""
    under_pods(script)
    script.drive(0, 4, 3)
    script.drive(0, 4, 7)
    script.drive(0, 5, 7)


def too_fast(script: Any) -> None:
    """Drive four cells in 3 s."""
    script.drive(0, 0, 4, tick=3000)


def too_slow(script: Any) -> None:
    """Drive four cells in 9 s."""
    script.drive(0, 0, 4, tick=9000)


def wrong_heading(script: Any) -> None:
    """Drive sideways."""
    script.drive(0, 3, 0, heading=0, turn_ticks=0, tick=Motion().run_ticks(3))


def wrong_turn(script: Any) -> None:
    """Turn in no time."""
    script.drive(0, 3, 0, turn_ticks=0, tick=Motion().run_ticks(3))


def early(script: Any) -> None:
    """Begin a run before the last one has ended."""
    script.drive(0, 0, 7)
    script.rest(0, -1)
    script.drive(0, 3, 7)


def jump(script: Any) -> None:
    """Begin a run two cells off."""
    script.drive(0, 0, 4)
    script.cells[0] += 2
    script.drive(0, 0, 7)


def longer_than_it_is(script: Any) -> None:
    """Report more metres than there are."""
    script.drive(0, 0, 4, distance_m=5)


def waits_backwards(script: Any) -> None:
    """Wait for less than no time."""
    script.drive(0, 0, 4, wait_s=-1)


@pytest.mark.parametrize(
    ("mistake", "kind"),
    [
        (diagonal, "not-straight"),
        (against, "one-way"),
        (into_wall, "wall"),
        (through_pod, "through-stored-pod"),
        (over_storage, "storage-crossed"),
        (rest_on_storage, "storage-crossed"),
        (without_pod_in_queue, "queue-lane"),
        (through_queue, "queue-lane"),
        (too_fast, "too-fast"),
        (too_slow, "too-slow"),
        (wrong_heading, "heading"),
        (wrong_turn, "turn-time"),
        (early, "time-overlap"),
        (jump, "teleport"),
        (longer_than_it_is, "distance"),
        (waits_backwards, "negative-time"),
    ],
)
def test_each_mistake_is_found_alone(new_script: Any, mistake: Callable[[Any], None], kind: str) -> None:
    """A single mistake in a hand-written trace is that one kind of fault, and the robot is named."""
    script = new_script(ONE_WAY, robots=[(0, 0)], pods=[(3, 3), (3, 2)])
    mistake(script)
    faults = faults_of(script.trace())
    assert {fault.kind for fault in faults} == {kind}
    assert all("robot 1" in fault.sentence for fault in faults)


def test_a_pod_may_be_carried_from_its_start_to_its_goal(new_script: Any) -> None:
    """Under stored pods without one, out of one storage location and into another one with it: no fault."""
    script = new_script(ONE_WAY, robots=[(0, 0)], pods=[(3, 3), (3, 2)], blocked=[(3, 6)])
    under_pods(script)
    script.drive(0, 4, 3)
    script.drive(0, 4, 5, wait_s=1)
    script.drive(0, 3, 5)
    script.store(0)
    script.drive(0, 3, 6)
    assert kinds(script) == []


def shift_run(trace: Trace, event: RobotMoved) -> dict[str, int]:
    """Begin and end a run a second too early."""
    return {"start_tick": event.start_tick - 1000, "tick": event.tick - 1000}


def swap_robots(trace: Trace) -> Trace:
    """Exchange two robots from the middle of the run on."""
    half = len(trace.events) // 2
    names = {0: 1, 1: 0}
    changed = [
        evolve(event, robot=names.get(event.robot, event.robot)) if hasattr(event, "robot") else event
        for event in trace.events[half:]
    ]
    return evolve(trace, events=(*trace.events[:half], *changed))


def long_first(event: RobotMoved) -> bool:
    """Whether a run has some cells."""
    return event.distance_m > 3


DAMAGES: list[tuple[str, Damage, str]] = [
    ("a run a second earlier", change(RobotMoved, shift_run, where=long_first), "time-overlap"),
    ("a run that ends early", change(RobotMoved, lambda t, e: {"tick": e.tick - 400}, where=long_first), "too-fast"),
    ("a run that starts early", change(RobotMoved, lambda t, e: {"wait_ticks": -9}, where=long_first), "negative-time"),
    ("a run that ends late", change(RobotMoved, lambda t, e: {"tick": e.tick + 400}, where=long_first), "too-slow"),
    ("a run with fewer metres", change(RobotMoved, lambda t, e: {"distance_m": e.distance_m - 1}), "distance"),
    ("a turn for nothing", change(RobotMoved, lambda t, e: {"turn_ticks": e.turn_ticks + 1}), "turn-time"),
    ("a robot that drives backwards", change(RobotMoved, lambda t, e: {"heading": (e.heading + 2) % 4}), "heading"),
    ("a run dropped", drop(RobotMoved, number=5), "teleport"),
    ("two robots exchanged", swap_robots, "teleport"),
    (
        "a run to beside its end",
        change(
            RobotMoved, lambda t, e: {"to": e.to + 1}, where=lambda e: long_first(e) and e.heading in (NORTH, SOUTH)
        ),
        "not-straight",
    ),
    (
        "a load that nobody lifted",
        change(RobotMoved, lambda t, e: {"pod": 0}, where=lambda e: e.pod is None),
        "pod-mismatch",
    ),
    ("a lift dropped", drop(PodLifted), "pod-mismatch"),
]


@pytest.mark.parametrize(("damage", "kind"), [pytest.param(d, k, id=name) for name, d, k in DAMAGES])
def test_damage_to_a_run_is_found(recorded: Trace, damage: Damage, kind: str) -> None:
    """Whatever is wrong in a run of many orders is among its faults."""
    assert_found(damage(recorded), kind)
