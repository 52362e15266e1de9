"""Places that are kept until items are handled, and backlogs that are refilled: what a trace cannot have."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from damage import find, put
from rmfs_commands.trace import read_trace
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.validator import faults_of
from rmfs_core.events import DecisionMade, Event, ItemPicked, OrderArrived, OrderCompleted

SETTINGS = ("stations.release=handled", 'instance.arrivals={process="refill", backlog=5}', "rules.pp=free-flow")


@pytest.fixture(scope="module")
def handled(tmp_path_factory: pytest.TempPathFactory) -> Trace:
    """Trace of a run with both."""
    folder = tmp_path_factory.mktemp("handled")
    rmfs_core.run("examples/small", overrides=SETTINGS, out=folder, record=["trace"])
    return read_trace(folder / "trace.jsonl.gz")


def with_release(trace: Trace, release: str) -> Trace:
    """Return the trace of a run that is said to give places back at another time."""
    stations = {**trace.scenario["stations"], "release": release}
    return evolve(trace, scenario={**trace.scenario, "stations": stations})


def complete_when_picked(trace: Trace) -> Trace:
    """Tell that the first order is complete as soon as its last item is picked."""
    number = find(trace, OrderCompleted)
    done: Any = trace.events[number]
    events = list(trace.events)
    events.remove(done)
    last = max(i for i, e in enumerate(events) if isinstance(e, ItemPicked) and e.order == done.order)
    events.insert(last + 1, evolve(done, tick=events[last].tick))
    return evolve(trace, events=tuple(events))


def other_order(trace: Trace) -> Trace:
    """Let two orders arrive in each other's place."""
    first, second = (i for i, e in enumerate(trace.events) if isinstance(e, OrderArrived) and e.order in (6, 7))
    events: list[Event] = list(trace.events)
    events[first], events[second] = evolve(events[first], order=7), evolve(events[second], order=6)  # type: ignore[call-arg]
    return evolve(trace, events=tuple(events))


def one_too_many(trace: Trace) -> Trace:
    """Let an order arrive while enough are waiting: the sixth at the start."""
    number = next(i for i, e in enumerate(trace.events) if isinstance(e, OrderArrived) and e.order == 5)
    moved = evolve(trace.events[number], tick=0)
    return put(put(trace, number), find(trace, OrderArrived), trace.events[find(trace, OrderArrived)], moved)


def not_refilled(trace: Trace) -> Trace:
    """Let the last order of a refill arrive only after the decision that follows."""
    number = next(i for i, e in enumerate(trace.events) if isinstance(e, OrderArrived) and e.order == 6)
    after = next(i for i, e in enumerate(trace.events) if i > number and isinstance(e, DecisionMade))
    events = list(trace.events)
    events.insert(after, events.pop(number))
    return evolve(trace, events=tuple(events))


def test_the_run_has_no_faults(handled: Trace) -> None:
    """As it was recorded."""
    assert faults_of(handled) == []


@pytest.mark.parametrize(
    ("damage", "kind"),
    [
        (complete_when_picked, "completed-early"),
        (lambda trace: with_release(trace, "picked"), "completed-late"),
        (other_order, "arrival"),
        (one_too_many, "arrival"),
        (not_refilled, "arrival"),
    ],
)
def test_what_cannot_have_happened_is_found(handled: Trace, damage: Callable[[Trace], Trace], kind: str) -> None:
    """Orders that end before their items are handled, or come when it is not their turn, or too late."""
    assert kind in {fault.kind for fault in faults_of(damage(handled))}


def test_a_place_that_is_still_kept_is_not_taken(tmp_path: Path) -> None:
    """A run that gave places back at the pick had more orders at a station than one that does later."""
    settings = ("stations.order_capacity=1", "stations.release=picked", "rules.pp=free-flow")
    rmfs_core.run("examples/small", overrides=settings, out=tmp_path, record=["trace"])
    trace = with_release(read_trace(tmp_path / "trace.jsonl.gz"), "handled")
    assert "capacity-exceeded" in {fault.kind for fault in faults_of(trace)}
