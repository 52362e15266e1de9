"""Orders that wait for stock in a trace, corrupted in one way each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from attrs import evolve

import rmfs_core
from rmfs_commands.trace import Trace, read_trace
from rmfs_commands.validation import check_trace
from rmfs_commands.validation.stock import joined_at, lets_wait
from rmfs_commands.validation.validator import faults_of
from rmfs_core.events import Event, OrderAssigned, OrderInStock

SHORT = ("instance.replenishment.lead_s=1800", "instance.orders=60", "rules.pp=free-flow")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a run in which orders wait for stock."""
    out = tmp_path_factory.mktemp("short")
    rmfs_core.run("examples/replenished", overrides=SHORT, out=out, record=["trace"])
    return out


@pytest.fixture(scope="module")
def short(folder: Path) -> Trace:
    """Trace of that run."""
    return read_trace(folder / "trace.jsonl.gz")


def faults(trace: Trace, events: Sequence[Event]) -> list[tuple[str, str]]:
    """Return kind and sentence of what is wrong when these are the events."""
    return [(fault.kind, fault.sentence) for fault in faults_of(evolve(trace, events=tuple(events)))]


def test_a_run_in_which_orders_wait_has_no_fault(folder: Path, short: Trace) -> None:
    """Nor do its metrics and tables, of which some say how long orders waited."""
    assert check_trace(folder).faults == []
    told = {event.order: event.tick for event in short.events if isinstance(event, OrderInStock)}
    assert len(told) > 5
    assert told.items() <= joined_at(short).items()
    assert lets_wait(short)


def test_an_order_that_is_not_told_of(short: Trace) -> None:
    """The bundle was enough for it."""
    i = next(i for i, event in enumerate(short.events) if isinstance(event, OrderInStock))
    found = faults(short, [*short.events[:i], *short.events[i + 1 :]])
    assert {kind for kind, _ in found} == {"in-stock", "backlog"}
    assert any("nothing tells of that" in text for _, text in found)


def test_an_order_that_is_told_of_and_did_not_wait(short: Trace) -> None:
    """No bundle has come for it."""
    i, event = next((i, event) for i, event in enumerate(short.events) if isinstance(event, OrderAssigned))
    false = OrderInStock(event.tick, event.order)
    found = faults(short, [*short.events[:i], false, *short.events[i:]])
    assert "is said to be in stock" in next(text for kind, text in found if kind == "in-stock")


def test_an_order_that_is_assigned_while_it_waits(short: Trace) -> None:
    """Told of after it was assigned."""
    i, late = next((i, event) for i, event in enumerate(short.events) if isinstance(event, OrderInStock))
    events = [*short.events[:i], *short.events[i + 1 :]]
    at, before = max((j, event) for j, event in enumerate(events[:i]) if isinstance(event, OrderAssigned))
    early = evolve(before, order=late.order)
    kinds = {kind for kind, _ in faults(short, [*events[:at], early, *events[at:]])}
    assert "assigned-without-stock" in kinds


def test_runs_in_which_nothing_waits(short: Trace) -> None:
    """With the key that switches it off, any such event is false, and each order is there with its arrival."""
    rules = {**short.scenario["rules"], "wait_for_stock": False}
    trace = evolve(short, scenario={**short.scenario, "rules": rules})
    assert not lets_wait(trace)
    assert joined_at(trace) == {i: order.arrival_tick for i, order in enumerate(trace.instance.orders)}
    assert {kind for kind, _ in faults(trace, trace.events)} >= {"in-stock"}
