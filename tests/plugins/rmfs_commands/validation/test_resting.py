"""Robots that are sent to rest, in traces that say what cannot be."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from attrs import evolve

import rmfs_core
from rmfs_commands.trace import Trace, read_trace
from rmfs_commands.validation.validator import faults_of
from rmfs_core.events import Event, PodMoveDecided, RobotMoved, RobotRested, RobotSent, TripDecided

OVERRIDES = (
    "instance.orders=12",
    "instance.arrivals={process='poisson', orders_per_hour=150}",
    "rules.idle=rest-middle",
    "robots.count=3",
)


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Trace:
    """Return the trace of a run whose robots rest in the middle."""
    folder = tmp_path_factory.mktemp("resting")
    rmfs_core.run("examples/small", overrides=OVERRIDES, out=folder, record=["trace"])
    return read_trace(Path(folder) / "trace.jsonl.gz")


def kinds(trace: Trace, kind: type[Event], change: Callable[[Event], Event | None]) -> set[str]:
    """Return the faults of a trace whose first event of a kind is another one, or missing."""
    events = list(trace.events)
    at = next(i for i, event in enumerate(events) if isinstance(event, kind))
    changed = change(events[at])
    events[at : at + 1] = [] if changed is None else [changed]
    return {fault.kind for fault in faults_of(evolve(trace, events=tuple(events)))}


def test_what_has_happened_is_possible(trace: Trace) -> None:
    """Robots rest, and nothing is found."""
    assert any(isinstance(event, RobotRested) for event in trace.events)
    assert faults_of(trace) == []


def test_where_nobody_may_rest(trace: Trace) -> None:
    """On the floor, and where another robot is."""
    floor = next(cell for cell in range(len(trace.layout.kind)) if trace.layout.kind[cell] == 1)
    assert "no-rest" in kinds(trace, RobotSent, lambda event: evolve(event, cell=floor))
    sent = next(event for event in trace.events if isinstance(event, RobotSent))
    others = {i: robot["cell"] for i, robot in enumerate(trace.robots) if i != sent.robot}
    for event in trace.events[: trace.events.index(sent)]:
        if isinstance(event, RobotMoved) and event.robot != sent.robot:
            others[event.robot] = event.to
    taken = next(cell for cell in others.values() if trace.layout.kind[cell] == 2)
    assert "no-rest" in kinds(trace, RobotSent, lambda event: evolve(event, cell=taken))


def test_a_robot_rests_that_was_sent_and_where_it_stands(trace: Trace) -> None:
    """Neither by itself, nor elsewhere."""
    assert "rested" in kinds(trace, RobotSent, lambda _: None)
    assert "rested" in kinds(trace, RobotRested, lambda event: evolve(event, cell=trace.layout.storage_locations[0]))


def test_a_robot_on_its_way_to_rest_gets_no_task(trace: Trace) -> None:
    """It rests first; a trace in which it does not says that two things are done at once."""
    busy = 0
    for at, event in enumerate(trace.events):
        if isinstance(event, RobotRested):
            events = (*trace.events[:at], *trace.events[at + 1 :])
            busy += any(fault.kind == "robot-busy" for fault in faults_of(evolve(trace, events=events)))
    assert busy


def test_a_pod_that_is_carried_elsewhere_stands_where_it_was_to(tmp_path: Path) -> None:
    """It is bound for no station when it is sent, and is set down where it was sent."""
    overrides = (*OVERRIDES, "rules.move=utility")
    rmfs_core.run("examples/small", overrides=overrides, out=tmp_path, record=["trace"])
    trace = read_trace(tmp_path / "trace.jsonl.gz")
    assert faults_of(trace) == []
    events = list(trace.events)
    decided = next(event for event in events if isinstance(event, PodMoveDecided))
    bound = events.copy()
    bound.insert(events.index(decided), TripDecided(tick=decided.tick, pod=decided.pod, station=0))
    assert "moved-bound" in {fault.kind for fault in faults_of(evolve(trace, events=tuple(bound)))}
    others = (cell for cell in trace.layout.storage_locations if cell != decided.cell)
    assert any(
        "moved-elsewhere" in kinds(trace, PodMoveDecided, lambda event, to=other: evolve(event, cell=to))  # type: ignore[misc]
        for other in others
    )
