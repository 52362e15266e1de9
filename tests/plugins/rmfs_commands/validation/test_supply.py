"""Faults of bundles, of orders that wait for stock, of capacity given back late, and at packing stations."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from cases import cases
from damage import find, put
from replenished import RULES, scenario_of
from rmfs_commands.trace import Trace, read_trace
from rmfs_commands.validation import check_trace, faults_of
from rmfs_commands.validation.stock import joined_at, lets_wait
from rmfs_core.events import (
    BundleArrived,
    BundleStored,
    DecisionMade,
    Event,
    ItemPicked,
    OrderArrived,
    OrderCompleted,
    OrderInStock,
    PackingStarted,
    PartPut,
)

SUPPLY = {"process": "reorder-point", "reorder_point": 3, "order_up_to": 8, "bundle_items": 4, "lead_s": 30.0}
INSTANCE = {
    "orders": 12,
    "skus": 4,
    "pods": 4,
    "skus_per_pod": 1,
    "items_per_sku": 4,
    "pod_capacity": 9,
    "replenishment": SUPPLY,
}


@pytest.fixture(scope="module")
def replenished(tmp_path_factory: pytest.TempPathFactory) -> Trace:
    folder = tmp_path_factory.mktemp("replenished")
    result = rmfs_core.run(scenario_of(SUPPLY, instance=INSTANCE), out=folder, record=["trace"])
    assert result.metrics["bundles_stored"] > 4
    return read_trace(folder / "trace.jsonl.gz")


Change = Callable[[Any], Event | None]


def changed(trace: Trace, kind: type[Event], change: Change, at: int = 0) -> Trace:
    places = [i for i, event in enumerate(trace.events) if isinstance(event, kind)]
    events: list[Event | None] = list(trace.events)
    events[places[at]] = change(events[places[at]])
    return evolve(trace, events=tuple(event for event in events if event is not None))


def kinds(trace: Trace) -> set[str]:
    return {fault.kind for fault in faults_of(trace)}


def test_a_run_with_replenishment_has_no_fault(replenished: Trace) -> None:
    assert kinds(replenished) == set()
    assert (replenished.instance.levels, replenished.layout.replenishing) == (((3, 8),) * 4, 1)
    assert [station.get("bundle_capacity") for station in replenished.stations] == [None, 10]
    instance = evolve(replenished.instance, levels=((10**15, 10**16),) * 4)
    assert "bundle-arrival" in kinds(evolve(replenished, instance=instance))
    assert "pod-capacity" in kinds(evolve(replenished, instance=evolve(replenished.instance, sizes=(99,) * 4)))


def test_bundles_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "bundles.csv").write_text("bundle,arrival_s,sku,items\nB,5,new,3\nA,1,1,2\n", encoding="utf-8")
    supply = {"process": "file", "file": str(tmp_path / "bundles.csv")}
    scenario = scenario_of(supply, instance=INSTANCE | {"orders": 6, "replenishment": supply}, run={"until_s": 90.0})
    rmfs_core.run(scenario, out=tmp_path / "out", record=["trace"])
    trace = read_trace(tmp_path / "out" / "trace.jsonl.gz")
    assert [(bundle.name, bundle.arrival_tick) for bundle in trace.instance.bundles] == [("A", 1000), ("B", 5000)]
    assert trace.instance.skus[-1] == "new"
    assert kinds(trace) == set()
    assert "bundle-arrival" in kinds(changed(trace, BundleArrived, lambda event: None, at=1))


def test_bundles_while_pickers_are_away_and_stations_activated(tmp_path: Path) -> None:
    instance = INSTANCE | {"items_per_sku": 1}
    hours = {"open": [["00:10", "24:00"]], "queue_length": 3}
    rmfs_core.run(scenario_of(SUPPLY, instance=instance, stations=hours), out=tmp_path, record=["trace"])
    trace = read_trace(tmp_path / "trace.jsonl.gz")
    assert next(event for event in trace.events if isinstance(event, BundleStored)).tick < 600_000
    assert kinds(trace) == set()
    rules = RULES | {"activate": "backlog-threshold"}
    rmfs_core.run(scenario_of(SUPPLY, instance=INSTANCE, rules=rules), out=tmp_path, record=["trace"])
    assert check_trace(tmp_path).faults == []


SHORT = ("instance.replenishment.lead_s=1800", "instance.orders=60", "rules.pp=free-flow")


@pytest.fixture(scope="module")
def short_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("short")
    rmfs_core.run("examples/replenished", overrides=SHORT, out=out, record=["trace"])
    return out


@pytest.fixture(scope="module")
def short(short_folder: Path) -> Trace:
    return read_trace(short_folder / "trace.jsonl.gz")


def faults_with(trace: Trace, events: Sequence[Event]) -> list[tuple[str, str]]:
    return [(fault.kind, fault.sentence) for fault in faults_of(evolve(trace, events=tuple(events)))]


def test_orders_that_wait(short_folder: Path, short: Trace) -> None:
    assert check_trace(short_folder).faults == []
    told = {event.order: event.tick for event in short.events if isinstance(event, OrderInStock)}
    assert len(told) > 5
    assert told.items() <= joined_at(short).items()
    assert lets_wait(short)
    rules = {**short.scenario["rules"], "wait_for_stock": False}
    trace = evolve(short, scenario={**short.scenario, "rules": rules})
    assert not lets_wait(trace)
    assert joined_at(trace) == {i: order.arrival_tick for i, order in enumerate(trace.instance.orders)}
    assert {kind for kind, _ in faults_with(trace, trace.events)} >= {"in-stock"}


SETTINGS = ("stations.release=handled", 'instance.arrivals={process="refill", backlog=5}', "rules.pp=free-flow")


@pytest.fixture(scope="module")
def handled(tmp_path_factory: pytest.TempPathFactory) -> Trace:
    folder = tmp_path_factory.mktemp("handled")
    rmfs_core.run("examples/small", overrides=SETTINGS, out=folder, record=["trace"])
    return read_trace(folder / "trace.jsonl.gz")


def with_release(trace: Trace, release: str) -> Trace:
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
    first, second = (i for i, e in enumerate(trace.events) if isinstance(e, OrderArrived) and e.order in (6, 7))
    events: list[Event] = list(trace.events)
    events[first], events[second] = evolve(events[first], order=7), evolve(events[second], order=6)  # type: ignore[call-arg]
    return evolve(trace, events=tuple(events))


def one_too_many(trace: Trace) -> Trace:
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
    assert faults_of(handled) == []


@cases(
    "damage kind",
    (complete_when_picked, "completed-early"),
    (lambda trace: with_release(trace, "picked"), "completed-late"),
    (other_order, "arrival"),
    (one_too_many, "arrival"),
    (not_refilled, "arrival"),
)
def test_orders_that_end_or_come_at_the_wrong_time_are_found(handled, damage, kind) -> None:
    assert kind in {fault.kind for fault in faults_of(damage(handled))}


def test_a_place_that_is_still_kept_is_not_taken(tmp_path: Path) -> None:
    settings = ("stations.order_capacity=1", "stations.release=picked", "rules.pp=free-flow")
    rmfs_core.run("examples/small", overrides=settings, out=tmp_path, record=["trace"])
    trace = with_release(read_trace(tmp_path / "trace.jsonl.gz"), "handled")
    assert "capacity-exceeded" in {fault.kind for fault in faults_of(trace)}


FEW = ("instance.orders=24", "packing={stations=2, boxes=2, packers=1, conveyor_s=20.0}", "rules.pp=free-flow")
KINDS_OF_RUN = {
    "parts": (),
    "visits, counted until picked": ("packing.tote=visit", "packing.packing_from=picked"),
    "sorters, places free with the pick": ("packing.sorters=1", "stations.release=picked"),
    "hours, split over time": ('packing.open=[["00:05", "24:00"]]', "rules.poa_pps=split-over-time", "run.warmup_s=99"),
    "cut off": ("run.until_s=400", 'packing.open={1=[["00:02", "00:05"]]}', 'instance.start="2024-03-01T00:01:00"'),
}


@pytest.mark.parametrize("changes", KINDS_OF_RUN.values(), ids=KINDS_OF_RUN)
def test_a_recorded_run_has_no_fault(changes: tuple[str, ...], tmp_path: Path) -> None:
    rmfs_core.run("examples/packing", overrides=[*FEW, *changes], out=tmp_path, record=["trace"])
    assert check_trace(tmp_path).faults == []
    result = json.loads((tmp_path / "result.json").read_text())
    for name in ("packer_utilisation_percent", "packer_starved_percent"):
        result["metrics"][name] += 1
    (tmp_path / "result.json").write_text(json.dumps(result))
    assert [fault.kind for fault in check_trace(tmp_path).faults] == ["metric"] * 2


@pytest.fixture(scope="module")
def packed(tmp_path_factory: pytest.TempPathFactory) -> Trace:
    """Trace of a run with few boxes."""
    folder = tmp_path_factory.mktemp("packed")
    rmfs_core.run("examples/packing", overrides=FEW, out=folder, record=["trace"])
    return read_trace(folder / "trace.jsonl.gz")


@pytest.mark.parametrize("change", [{"packers": 0}, {"open": {"1": [["12:00", "13:00"]]}}])
def test_more_packers_than_there_are_show(packed: Trace, change: dict[str, Any]) -> None:
    """In the whole run, and in one that ends while the first order is packed."""
    section = packed.scenario["packing"] | change
    begun = next(at for at, one in enumerate(packed.events) if isinstance(one, PackingStarted) and one.packing == 0)
    events = tuple(event for event in packed.events[: begun + 1] if not isinstance(event, PartPut))
    for part in (packed, evolve(packed, events=events, status="horizon")):
        found = faults_of(evolve(part, scenario={**packed.scenario, "packing": section}))
        assert {fault.kind for fault in found} >= {"packers"}
