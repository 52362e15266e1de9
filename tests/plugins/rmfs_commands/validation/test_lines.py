"""Pods visit the stations they are bound for, in the order in which they came."""

from __future__ import annotations

from typing import Any

import pytest
from attrs import evolve

from damage import (
    Damage,
    assert_found,
    at,
    change,
    drop,
    earlier,
    find,
    other,
    put,
    repeat,
    told,
    told_before,
    twice,
    without,
)
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation import faults_of
from rmfs_core.events import QueueJoined, RobotMoved, TripDecided, VisitEnded, VisitStarted

TRIP, PPS, JOIN, VISIT, LEAVE = 3, 4, 10, 12, 17
"""Places of events in `day`."""


def short_queue(trace: Trace) -> Trace:
    """Leave no place but the station, and let two robots be in line for it."""
    at = find(trace, QueueJoined)
    changed = put(trace, at, trace.events[at], evolve(trace.events[at], robot=other(len(trace.robots), 0)))
    return evolve(changed, scenario={**trace.scenario, "stations": {**trace.scenario["stations"], "queue_length": 0}})


def queue_jumper(trace: Trace) -> Trace:
    """Exchange two robots in a line."""
    for i, first in enumerate(trace.events):
        if not isinstance(first, QueueJoined):
            continue
        for j in range(i + 1, len(trace.events)):
            second = trace.events[j]
            if isinstance(second, VisitEnded) and second.station == first.station:
                break
            if isinstance(second, QueueJoined) and second.station == first.station:
                return put(put(trace, i, evolve(second, tick=first.tick)), j, evolve(first, tick=second.tick))
    raise AssertionError("no two robots were in a line at once")


def move_in_visit(trace: Trace) -> Trace:
    """Let the robot at a station drive off and come back before the visit has ended."""
    at = find(trace, VisitEnded)
    ended = trace.events[at]
    assert isinstance(ended, VisitEnded)
    began = next(e for e in trace.events if isinstance(e, VisitStarted) and e.visit == ended.visit)
    cell = trace.layout.stations[ended.station].station
    wait = RobotMoved(ended.tick, ended.tick - 500, began.robot, cell, cell, 0, 500, 0, 0, ended.pod)
    return put(trace, at, wait, ended)


def lane_visit(trace: Trace) -> Trace:
    """Leave out that a pod joined a line and what it did there."""
    at = find(trace, QueueJoined)
    joined = trace.events[at]
    assert isinstance(joined, QueueJoined)
    begun = next(i for i in range(at, len(trace.events)) if getattr(trace.events[i], "visit", None) is not None)
    visit = getattr(trace.events[begun], "visit", None)
    kept = [e for i, e in enumerate(trace.events) if i != at and getattr(e, "visit", None) != visit]
    return evolve(trace, events=tuple(kept))


def turn_in_visit(trace: Trace) -> Trace:
    """Let the robot of the day move on the spot before its visit ends."""
    end = trace.events[LEAVE]
    return put(trace, LEAVE, RobotMoved(end.tick, end.tick - 500, 0, 39, 39, 0, 500, 0, 0, 0), end)


DAMAGES: list[tuple[str, Damage, str]] = [
    ("a trip dropped", drop(TripDecided), "not-bound"),
    ("a trip to two stations", change(TripDecided, lambda t, e: {"station": 1 - e.station}), "not-bound"),
    ("a trip twice", repeat(TripDecided), "bound-twice"),
    ("a line joined twice", repeat(QueueJoined), "queue-order"),
    ("a line not joined", drop(QueueJoined), "queue-order"),
    ("a robot before its turn", queue_jumper, "queue-order"),
    ("a line too long", short_queue, "queue-too-long"),
    ("a queue used as a shortcut", lane_visit, "queue-lane"),
    ("a visit dropped", drop(VisitStarted), "visit-number"),
    ("a visit at another station", change(VisitStarted, lambda t, e: {"station": 1 - e.station}), "robot-elsewhere"),
    ("a visit by another pod", change(VisitStarted, lambda t, e: {"pod": other(len(t.pods), e.pod)}), "pod-mismatch"),
    ("a visit twice", repeat(VisitStarted), "station-busy"),
    ("a visit's end dropped", drop(VisitEnded), "station-busy"),
    ("a visit's end twice", repeat(VisitEnded), "visit-end"),
    ("a visit with other picks", change(VisitEnded, lambda t, e: {"picks": e.picks + 1}), "visit-picks"),
    ("a visit without its robot", move_in_visit, "moved-in-visit"),
    (
        "a pod that goes elsewhere",
        change(VisitEnded, lambda t, e: {"next_station": 1 - e.station}),
        "next-station",
    ),
    ("a pod that leaves too early", earlier(VisitEnded, by=2, where=lambda e: e.picks > 1), "left-early"),
]


@pytest.mark.parametrize(("damage", "kind"), [pytest.param(d, k, id=name) for name, d, k in DAMAGES])
def test_damage_to_a_run_is_found(recorded: Trace, damage: Damage, kind: str) -> None:
    """Whatever is wrong in a run of many orders is among its faults."""
    assert_found(damage(recorded), kind)


@pytest.mark.parametrize(
    ("damage", "faults"),
    [
        (
            twice(TRIP),
            [
                "bound-twice: pod P0 is sent to station 1, where it is or is bound for already",
                "decision-size: the PPS decision of period 1 reports 0 assignments and 1 trips; it had 0 and 2",
            ],
        ),
        (
            without(JOIN),
            [
                "queue-order: robot 1 with pod P0 starts a visit at station 1, but nobody is in its line",
                "queue-lane: robot 1 drove through the queue of station 1",
            ],
        ),
        (
            twice(JOIN),
            [
                "queue-order: robot 1 with pod P0 joins the line of station 1, but is in it already",
            ],
        ),
        (
            told_before(JOIN, JOIN - 1),
            [
                "robot-elsewhere: robot 1 with pod P0 joins the line of station 1, but stands at row 5, column 4",
                "queue-lane: robot 1 drove through the queue of station 1",
            ],
        ),
        (
            at(JOIN, pod=1),
            [
                "pod-mismatch: robot 1 with pod P1 joins the line of station 1, but carries pod P0",
                "not-bound: robot 1 with pod P1 joins the line of station 1, but pod P1 is bound for no station first",
            ],
        ),
        (
            twice(VISIT),
            [
                "visit-number: robot 1 with pod P0 starts a visit at station 1 with the number 1; expected 2",
                "station-busy: robot 1 with pod P0 starts a visit at station 1, where pod P0 still is",
            ],
        ),
        (
            twice(LEAVE),
            [
                "visit-end: pod P0 leaves station 1 after visit 1, but no pod is there",
            ],
        ),
        (
            at(LEAVE, picks=2),
            [
                "visit-picks: pod P0 leaves station 1 after 3 picks, but reports 2",
            ],
        ),
        (
            at(LEAVE, visit=9),
            [
                "visit-end: pod P0 leaves station 1 after visit 9, but pod P0 with visit 1 is there",
            ],
        ),
        (
            without(LEAVE),
            [
                "moved-in-visit: robot 1 left row 5, column 8 during visit 1, which has no end",
            ],
        ),
        (
            turn_in_visit,
            [
                "moved-in-visit: pod P0 leaves station 1, but robot 1 moved during the visit",
            ],
        ),
    ],
)
def test_a_damaged_day_is_told(day: Trace, damage: Damage, faults: list[str]) -> None:
    """Each fault of one visit has its sentence, and what follows from it only once."""
    assert told(damage(day)) == faults


def test_a_line_of_one_too_many_is_told(day: Trace) -> None:
    """A line may have as many robots as the queue has places, and one at the station."""
    for length, faults in ((0, []), (-1, ["queue-too-long"])):
        stations = {**day.scenario["stations"], "queue_length": length}
        found = told(evolve(day, scenario={**day.scenario, "stations": stations}))
        assert [fault.partition(":")[0] for fault in found] == faults


def test_a_pod_that_can_still_serve_stays(day: Trace) -> None:
    """Only what never runs out is held against a pod that leaves: an item may be promised by another one."""
    early = told_before(LEAVE, 14)(day)
    assert not any(fault.startswith("left-early") for fault in told(early))
    (first, *others) = day.instance.pods
    endless = evolve(first, contents=((0, None), (1, None)))
    early = evolve(early, instance=evolve(day.instance, pods=(endless, *others)))
    assert "left-early: pod P0 leaves station 1, where SKU jam is still wanted" in told(early)


def test_a_robot_keeps_behind_its_place_in_line(new_script: Any) -> None:
    """By a shortcut or another entrance, too: what lies ahead of its place is for those ahead of it."""
    yard = ".........\n.....v...\n..qqqqqO.\n..##.##..\n........."
    script = new_script(yard, robots=[(4, 2), (4, 5)], pods=[(3, 2), (3, 5)])
    for robot, way in ((0, [(4, 1), (2, 1), (2, 2)]), (1, [(4, 8), (0, 8), (0, 5), (2, 5)])):
        script.drive(robot, 3, script.cells[robot] % 9)
        script.fetch(robot, robot)
        script.drive(robot, 4, script.cells[robot] % 9)
        for row, column in way:
            script.drive(robot, row, column)
        script.events.append(QueueJoined(script.now[robot], robot, robot, 0))
    assert not [fault for fault in told(script.trace()) if fault.startswith("queue-passed")]
    script.drive(1, 2, 7)
    assert [fault for fault in told(script.trace()) if fault.startswith("queue-passed")] == [
        "queue-passed: robot 2 drives to row 3, column 8 in the queue of station 1, "
        "place 0 there; robots ahead of it in line: 1"
    ]
    assert faults_of(script.trace(), collisions=False) == []  # robots pass through each other, in queues, too


def test_who_waits_in_a_queue_is_in_its_line(new_script: Any) -> None:
    """A robot that stood still in the queue has joined before it is served, unless another one has lost its place."""
    script = new_script("........\n...@....\n..##.##.\n.....qqO\n........", robots=[(4, 3)], pods=[(2, 3)])
    script.drive(0, 2, 3)
    script.fetch(0, 0)
    script.drive(0, 3, 3)
    script.drive(0, 3, 5)
    script.events.append(QueueJoined(script.now[0], 0, 0, 0))
    script.drive(0, 3, 7, wait_s=3)
    script.events.append(VisitStarted(script.now[0], 1, 0, 0, 0))
    trace = script.trace()
    assert told(trace) == []
    at, late = find(trace, QueueJoined), find(trace, RobotMoved)
    joined = evolve(trace.events[at], tick=trace.events[late].tick)
    assert told(put(put(trace, late, trace.events[late], joined), at)) == [
        "joined-late: robot 1 with pod P0 starts a visit at station 1, in whose queue it waited; "
        "it joined the line just now"
    ]
