"""All checks over one trace: what is handed to them, in which order, and what comes of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from attrs import evolve

from damage import Damage, assert_found, at, change, drop, repeat
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation import faults_of
from rmfs_core.events import (
    DecisionMade,
    ItemPicked,
    OrderAssigned,
    OrderCompleted,
    PodLifted,
    QueueJoined,
    RobotMoved,
    TaskAssigned,
    TripDecided,
    VisitEnded,
    VisitStarted,
)

HALL = "........\n" * 5
ASSIGNED, TRIP, LIFT, JOIN, LEAVE = 1, 3, 7, 10, 17
"""Places of events in `day`."""


def kinds(script: Any, collisions: bool | None = None) -> list[str]:
    """Return the kinds of faults in a script's trace, in the order of time."""
    return [fault.kind for fault in faults_of(script.trace(), collisions=collisions)]


def ends_early(trace: Trace) -> Trace:
    """Let the run end before its last event."""
    return evolve(trace, tick=trace.tick - 1)


DAMAGES: list[tuple[str, Damage, str]] = [
    ("a run to the edge of the world", change(RobotMoved, lambda t, e: {"to": 10**6}), "unknown-id"),
    ("events out of order", change(VisitEnded, lambda t, e: {"tick": e.tick - 1}), "time-order"),
    ("a run's end before its last event", ends_early, "time-order"),
    ("a complete run that goes on", lambda trace: evolve(trace, tick=trace.tick + 1), "end"),
]


@pytest.mark.parametrize(("damage", "kind"), [pytest.param(d, k, id=name) for name, d, k in DAMAGES])
def test_damage_to_a_run_is_found(recorded: Trace, damage: Damage, kind: str) -> None:
    """Whatever is wrong in a run of many orders is among its faults."""
    assert_found(damage(recorded), kind)


FEW: list[tuple[str, Damage]] = [
    ("a run dropped", drop(RobotMoved, number=5)),
    ("a lift dropped", drop(PodLifted)),
    ("a task dropped", drop(TaskAssigned)),
    ("a trip dropped", drop(TripDecided)),
    ("a line joined twice", repeat(QueueJoined)),
    ("a visit twice", repeat(VisitStarted)),
    ("a visit's end dropped", drop(VisitEnded)),
    ("a pick in another visit", change(ItemPicked, lambda t, e: {"visit": e.visit + 1})),
    ("an assignment to the other station", change(OrderAssigned, lambda t, e: {"station": 1 - e.station})),
    ("an order complete twice", repeat(OrderCompleted)),
    ("a period too far", change(DecisionMade, lambda t, e: {"period": e.period + 1})),
]


@pytest.mark.parametrize("damage", [pytest.param(damage, id=name) for name, damage in FEW])
def test_one_damage_is_not_a_thousand_faults(recorded: Trace, damage: Damage) -> None:
    """After a fault the validation goes on from what the trace says, so that a single slip shows as a few faults."""
    assert 1 <= len(faults_of(damage(recorded))) <= 3


def test_good_runs_have_no_fault(recorded: Trace, recorded_result: Mapping[str, Any], day: Trace) -> None:
    """Neither a run of many orders with its result, nor a day of one order."""
    assert faults_of(recorded, recorded_result) == []
    assert faults_of(day) == []


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (at(TRIP, pod=2), "TripDecided names pod 2, which does not exist"),
        (at(ASSIGNED, skus=(0, 7)), "OrderAssigned names skus 7, which does not exist"),
        (at(LEAVE, next_station=3), "VisitEnded names next_station 3, which does not exist"),
        (at(LIFT, cell=-1), "PodLifted names cell -1, which does not exist"),
    ],
)
def test_an_unknown_id_is_named(day: Trace, damage: Damage, sentence: str) -> None:
    """The first fault of its event is the only one: an event that names what is not there is not followed."""
    assert [fault.sentence for fault in faults_of(damage(day)) if fault.kind == "unknown-id"] == [sentence]


def test_what_rests_on_the_whole_trace_is_left_out_when_an_id_is_unknown(day: Trace) -> None:
    """Metrics of a trace that names what does not exist mean nothing: they are not compared."""
    wrong = {"metrics": {}, "status": "complete", "scenario": day.scenario}
    assert "metric" in {fault.kind for fault in faults_of(day, wrong)}
    assert "metric" not in {fault.kind for fault in faults_of(at(TRIP, pod=2)(day), wrong)}


def test_the_order_of_time_is_checked(day: Trace) -> None:
    """Each event below a later one is told, and a run's end before its last event."""
    (fault,) = faults_of(at(JOIN, tick=13_027)(day))
    assert (fault.kind, fault.tick) == ("time-order", 13_027)
    assert fault.sentence == "QueueJoined at 13.027 s stands below an event of 13.028 s"
    (fault,) = faults_of(evolve(day, tick=61_097))
    assert fault.sentence == "the last event is later than the end of the run at 61.097 s"


def test_a_run_ends_when_it_is_over(day: Trace) -> None:
    """Complete, with the last thing that happens; else not after the time that the scenario gives it."""
    (fault,) = faults_of(evolve(day, tick=day.tick + 1))
    assert (fault.kind, fault.tick) == ("end", day.tick + 1)
    assert fault.sentence == "the run ends at 61.099 s, complete, but nothing has happened since 61.098 s"
    late = evolve(day, scenario={**day.scenario, "run": {"until_s": 60}}, status="failed")
    assert [fault.sentence for fault in faults_of(late)] == ["the run ends at 61.098 s; run.until_s is 60"]


def test_a_rule_that_ignores_other_robots_is_not_held_to_it(new_script: Any) -> None:
    """Collisions are checked unless the PP rule is free-flow; the argument overrides."""
    script = new_script(HALL, robots=[(0, 0), (0, 5)])
    script.drive(0, 0, 7)
    script.rest(1, 30)
    script.drive(1, 4, 5)
    assert faults_of(script.trace("free-flow")) == []
    assert [fault.kind for fault in faults_of(script.trace("free-flow"), collisions=True)] == ["collision"]
    assert kinds(script, collisions=False) == []
