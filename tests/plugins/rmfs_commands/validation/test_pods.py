"""Pods are fetched, lifted and set down only where, when and by whom they can be."""

from __future__ import annotations

import pytest
from attrs import evolve

from damage import Damage, assert_found, at, change, drop, find, other, put, told, told_before, twice, without
from rmfs_commands.trace.reader import Trace
from rmfs_core.events import PodLifted, PodStored, TaskAssigned, TripDecided

TASK, LIFT, LEAVE, STORE = 5, 7, 17, 21
"""Places of events in `day`."""


def blocked_goal(trace: Trace) -> Trace:
    """Let an empty pod stand where a pod is set down."""
    event = trace.events[find(trace, PodStored)]
    assert isinstance(event, PodStored)
    homes = {pod["cell"] for pod in trace.pods}
    free = next(e for e in trace.events if isinstance(e, PodStored) and e.cell not in homes)
    return evolve(trace, blocked=(*trace.blocked, free.cell))


def lift_while_loaded(trace: Trace) -> Trace:
    """Lift a second pod."""
    at = find(trace, PodLifted)
    event = trace.events[at]
    assert isinstance(event, PodLifted)
    return put(trace, at, event, evolve(event, pod=other(len(trace.pods), event.pod)))


def lift_of_another(trace: Trace) -> Trace:
    """Let another robot lift a pod that is carried already."""
    at = find(trace, PodLifted)
    event = trace.events[at]
    assert isinstance(event, PodLifted)
    return put(trace, at, event, evolve(event, robot=other(len(trace.robots), event.robot)))


def fetched_by_two(trace: Trace) -> Trace:
    """Tell another robot to fetch the same pod."""
    at = find(trace, TaskAssigned)
    event = trace.events[at]
    assert isinstance(event, TaskAssigned)
    return put(trace, at, event, evolve(event, robot=other(len(trace.robots), event.robot)))


def never_stored(trace: Trace) -> Trace:
    """Let the run go on for a minute after the robot has brought the pod to its place."""
    return evolve(without(STORE)(trace), tick=trace.tick + 60_000, status="failed")


DAMAGES: list[tuple[str, Damage, str]] = [
    ("a lift elsewhere", change(PodLifted, lambda t, e: {"cell": 0}), "pod-not-there"),
    ("a lift where the robot is not", change(PodLifted, lambda t, e: {"cell": 0}), "robot-elsewhere"),
    ("a lift of another pod", change(PodLifted, lambda t, e: {"pod": other(len(t.pods), e.pod)}), "no-task"),
    ("a lift of two pods", lift_while_loaded, "robot-loaded"),
    ("a lift by two robots", lift_of_another, "pod-in-use"),
    ("a lift too short", change(PodLifted, lambda t, e: {"start_tick": e.start_tick + 100}), "lift-time"),
    ("a setting down too long", change(PodStored, lambda t, e: {"start_tick": e.start_tick - 100}), "lift-time"),
    ("a pod set down by another robot", change(PodStored, lambda t, e: {"robot": other(4, e.robot)}), "pod-in-use"),
    ("a pod set down on the floor", change(PodStored, lambda t, e: {"cell": 0}), "no-storage-location"),
    ("a pod set down on another", blocked_goal, "location-taken"),
    ("a task dropped", drop(TaskAssigned), "no-task"),
    ("a trip dropped", drop(TripDecided), "no-trip"),
    ("a task for two robots", fetched_by_two, "fetched-twice"),
    ("a second task", change(TaskAssigned, lambda t, e: {"robot": other(4, e.robot)}, number=9), "robot-busy"),
]


@pytest.mark.parametrize(("damage", "kind"), [pytest.param(d, k, id=name) for name, d, k in DAMAGES])
def test_damage_to_a_run_is_found(recorded: Trace, damage: Damage, kind: str) -> None:
    """Whatever is wrong in a run of many orders is among its faults."""
    assert_found(damage(recorded), kind)


@pytest.mark.parametrize(
    ("damage", "faults"),
    [
        (
            without(TASK),
            [
                "no-task: robot 1 lifts pod P0 at row 4, column 4, but was not told to fetch it",
            ],
        ),
        (
            told_before(TASK, 3),
            [
                "no-trip: robot 1 shall fetch pod P0, which is bound for no station",
            ],
        ),
        (
            never_stored,
            [
                "not-stored: robot 1 with pod P0 stands at row 4, column 4 since 58.898 s and does not set it down",
            ],
        ),
        (
            twice(TASK),
            [
                "robot-busy: robot 1 shall fetch pod P0, but is still busy with pod P0",
            ],
        ),
        (
            at(LIFT, pod=1),
            [
                "no-task: robot 1 lifts pod P1 at row 4, column 4, but was not told to fetch it",
                "pod-not-there: robot 1 lifts pod P1 at row 4, column 4, but the pod stands at row 4, column 3",
                "pod-mismatch: robot 1 drives with pod P0, but carries pod P1",
            ],
        ),
        (
            at(LIFT, start_tick=3454),
            [
                "lift-time: robot 1 lifts pod P0 at row 4, column 4 in 2.199 s; that takes 2.200 s",
            ],
        ),
        (
            at(LIFT, start_tick=3452),
            [
                "time-overlap: robot 1 lifts pod P0 at row 4, column 4 from 3.452 s on, "
                "but what it did before lasted until 3.453 s",
                "lift-time: robot 1 lifts pod P0 at row 4, column 4 in 2.201 s; that takes 2.200 s",
            ],
        ),
        (
            at(STORE, cell=26),
            [
                "robot-elsewhere: robot 1 sets down pod P0 at row 4, column 3, but stands at row 4, column 4",
                "location-taken: robot 1 sets down pod P0 at row 4, column 3, where pod P1 stands",
            ],
        ),
        (
            at(STORE, cell=43),
            [
                "robot-elsewhere: robot 1 sets down pod P0 at row 6, column 4, but stands at row 4, column 4",
                "no-storage-location: robot 1 sets down pod P0 at row 6, column 4, which is no storage location",
            ],
        ),
        (
            at(STORE, pod=1),
            [
                "pod-in-use: robot 1 sets down pod P1 at row 4, column 4, but carries pod P0",
            ],
        ),
        (
            at(LEAVE, next_station=0),
            [
                "not-bound: pod P0 leaves station 1 for station 1, which it is not bound for",
                "next-station: robot 1 sets down pod P0 at row 4, column 4, but was to carry it on to station 1",
            ],
        ),
    ],
)
def test_a_damaged_day_is_told(day: Trace, damage: Damage, faults: list[str]) -> None:
    """Each fault of one robot with one pod has its sentence, with the names and the times."""
    assert told(damage(day)) == faults
