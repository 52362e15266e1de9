"""Stations open and close, and robots come and go, when the scenario says."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from damage import Damage, assert_found, change, drop, find, put, repeat, told
from rmfs_commands.trace import read_trace
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation import validate_trace
from rmfs_core.events import OrderAssigned, RobotsOnDuty, StationClosed, StationOpened, TaskAssigned

HOURS = (
    "instance.orders=24",
    "instance.arrivals={process='poisson', orders_per_hour=300}",
    "rules.pp=free-flow",
    'stations.open={1 = [["00:00", "00:02"]], 2 = [["00:01", "24:00"]]}',
    'robots.available=[["00:00", "00:03"], ["00:03", "24:00", 1]]',
)
BY_LOAD = "rules.activate={rule='backlog-threshold', open_above=2, timeout_s=60}"

Recorded = Callable[[bool], Trace]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    """Return what gives the trace of a run with opening hours, with or without an activation rule, once each."""
    made: dict[bool, Trace] = {}

    def trace(by_load: bool) -> Trace:
        if by_load not in made:
            out: Path = tmp_path_factory.mktemp("hours")
            rmfs_core.run(
                "examples/small", overrides=[*HOURS, *([BY_LOAD] if by_load else [])], out=out, record=["trace"]
            )
            assert validate_trace(out) == []
            made[by_load] = read_trace(out / "trace.jsonl.gz")
        return made[by_load]

    return trace


@pytest.mark.parametrize("by_load", [False, True])
def test_a_run_with_opening_hours_is_right(recorded: Recorded, by_load: bool) -> None:
    """Its result and its tables, too: `validate_trace` found nothing."""
    kinds = {type(event) for event in recorded(by_load).events}
    assert {StationOpened, StationClosed, RobotsOnDuty} <= kinds


def to_closed(trace: Trace) -> Trace:
    """Assign the last order to the station that is closed then."""
    at = find(trace, OrderAssigned, number=99)
    return put(trace, at, evolve(trace.events[at], station=0))  # type: ignore[call-arg]


def to_who_left(trace: Trace) -> Trace:
    """Give the last task to the robot that is off duty then."""
    at = find(trace, TaskAssigned, number=99)
    return put(trace, at, evolve(trace.events[at], robot=1))  # type: ignore[call-arg]


def later(trace: Trace, event: Any) -> dict[str, Any]:
    """A second later."""
    return {"tick": event.tick + 1000}


DAMAGES: list[tuple[str, Damage, str]] = [
    ("an order for a closed station", to_closed, "station-closed"),
    ("a task for a robot off duty", to_who_left, "off-duty"),
    ("an opening left out", drop(StationOpened), "station-hours"),
    ("a closing left out", drop(StationClosed), "station-hours"),
    ("an opening twice", repeat(StationOpened), "station-hours"),
    ("a closing twice", repeat(StationClosed), "station-hours"),
    ("an opening too late", change(StationOpened, later), "station-hours"),
    ("a closing too late", change(StationClosed, later), "station-hours"),
    ("robots that stay", drop(RobotsOnDuty), "robot-hours"),
    ("robots told of twice", repeat(RobotsOnDuty), "robot-hours"),
    ("another number of robots", change(RobotsOnDuty, lambda t, e: {"number": 0}), "robot-hours"),
    ("robots that leave too late", change(RobotsOnDuty, later), "robot-hours"),
]


@pytest.mark.parametrize(("damage", "kind"), [row[1:] for row in DAMAGES], ids=[row[0] for row in DAMAGES])
def test_damage_to_the_hours_is_found(recorded: Recorded, damage: Damage, kind: str) -> None:
    """Each by its kind."""
    assert_found(damage(recorded(False)), kind)


def test_a_rule_may_close_what_could_be_open(recorded: Recorded) -> None:
    """And not open what is closed by its timetable; nor leave it open."""
    trace = recorded(True)
    closed = StationClosed(trace.tick, 1)
    at = len(trace.events)
    assert not any("station-hours" in fault for fault in told(put(trace, at, closed, instead_of=0)))
    opened = StationOpened(trace.tick, 0)
    sentence = "station-hours: station 1 opens, which `stations.open` does not say"
    assert sentence in told(put(trace, at, opened, instead_of=0))


def test_who_has_no_timetable_never_closes(recorded: Recorded) -> None:
    """Nor do robots leave whose scenario does not say so."""
    trace = recorded(False)
    scenario = {**trace.scenario, "stations": {k: v for k, v in trace.scenario["stations"].items() if k != "open"}}
    scenario["robots"] = {k: v for k, v in trace.scenario["robots"].items() if k != "available"}
    faults = told(evolve(trace, scenario=scenario))
    assert "station-hours: station 2 closes, which `stations.open` does not say" in faults
    assert "robot-hours: robots on duty from now on: 1; the scenario says 4" in faults
