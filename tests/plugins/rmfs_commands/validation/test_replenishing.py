"""Bundles in a trace, corrupted in one way each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from replenished import RULES, scenario_of
from rmfs_commands.trace import Trace, read_trace
from rmfs_commands.validation import check_trace
from rmfs_commands.validation.validator import faults_of
from rmfs_core.events import BundleArrived, BundleAssigned, BundleBound, BundleStored, DecisionMade, Event, TripDecided
from rmfs_core.roles import Role

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
    """Trace of a run with reorder points."""
    folder = tmp_path_factory.mktemp("replenished")
    result = rmfs_core.run(scenario_of(SUPPLY, instance=INSTANCE), out=folder, record=["trace"])
    assert result.metrics["bundles_stored"] > 4
    return read_trace(folder / "trace.jsonl.gz")


Change = Callable[[Any], Event | None]


def changed(trace: Trace, kind: type[Event], change: Change, at: int = 0) -> Trace:
    """Return a trace with another event in place of one of a kind; without it where there is none."""
    places = [i for i, event in enumerate(trace.events) if isinstance(event, kind)]
    events: list[Event | None] = list(trace.events)
    events[places[at]] = change(events[places[at]])
    return evolve(trace, events=tuple(event for event in events if event is not None))


def kinds(trace: Trace) -> set[str]:
    """Return the kinds of faults of a trace."""
    return {fault.kind for fault in faults_of(trace)}


def test_a_run_with_replenishment_has_no_fault(replenished: Trace) -> None:
    """Read back, it has what it started from."""
    assert kinds(replenished) == set()
    assert replenished.instance.levels == ((3, 8),) * 4
    assert replenished.layout.replenishing == 1
    assert [station.get("bundle_capacity") for station in replenished.stations] == [None, 10]


def test_levels_that_nobody_could_have_ordered_take_no_time(replenished: Trace) -> None:
    """However many bundles they make; and so do items that no pod has room for."""
    instance = evolve(replenished.instance, levels=((10**15, 10**16),) * 4)
    assert "bundle-arrival" in kinds(evolve(replenished, instance=instance))
    assert "pod-capacity" in kinds(evolve(replenished, instance=evolve(replenished.instance, sizes=(99,) * 4)))


@pytest.mark.parametrize(
    ("kind", "change", "fault"),
    [
        (BundleArrived, lambda event: None, "bundle-arrival"),
        (BundleArrived, lambda event: evolve(event, items=event.items + 1), "bundle-arrival"),
        (BundleArrived, lambda event: evolve(event, tick=event.tick + 1), "bundle-arrival"),
        (BundleArrived, lambda event: evolve(event, bundle=5), "bundle-arrival"),
        (BundleAssigned, lambda event: None, "bundle-elsewhere"),
        (BundleAssigned, lambda event: evolve(event, station=0), "bundle-capacity"),
        (BundleAssigned, lambda event: evolve(event, bundle=99), "unknown-id"),
        (BundleBound, lambda event: evolve(event, pod=event.pod ^ 1), "bundle-elsewhere"),
        (BundleStored, lambda event: None, "left-early"),
        (BundleStored, lambda event: evolve(event, items=event.items + 9), "pod-capacity"),
        (BundleStored, lambda event: evolve(event, items=event.items - 1), "bundle-items"),
        (BundleStored, lambda event: evolve(event, start_tick=event.start_tick + 1), "store-time"),
        (BundleStored, lambda event: evolve(event, visit=99), "no-visit"),
        (BundleStored, lambda event: evolve(event, pod=event.pod ^ 1), "no-visit"),
    ],
)
def test_what_cannot_have_happened_is_found(replenished: Trace, kind: type[Event], change: Change, fault: str) -> None:
    """Each corruption by the kind of fault that it is."""
    assert fault in kinds(changed(replenished, kind, change))


@pytest.mark.parametrize("kind", [BundleAssigned, BundleBound, BundleStored])
def test_nothing_happens_to_a_bundle_twice(replenished: Trace, kind: type[Event]) -> None:
    """It is assigned, given a pod and stored once."""
    i = next(i for i, event in enumerate(replenished.events) if isinstance(event, kind))
    twice: Sequence[Event] = (*replenished.events[: i + 1], replenished.events[i], *replenished.events[i + 1 :])
    assert "bundle-twice" in kinds(evolve(replenished, events=tuple(twice)))


def test_a_pod_is_sent_to_a_replenishment_station_for_a_bundle_alone(replenished: Trace) -> None:
    """A trip to where nothing is picked, of a pod that no bundle is for."""
    picking = next(event for event in replenished.events if isinstance(event, TripDecided) and event.station == 0)
    i = replenished.events.index(picking)
    events = (*replenished.events[:i], evolve(picking, station=1), *replenished.events[i + 1 :])
    assert "bundle-elsewhere" in kinds(evolve(replenished, events=events))


@pytest.mark.parametrize(
    ("change", "fault"),
    [({"assignments": 7}, "decision-size"), ({"backlog": 77}, "backlog"), ({"rule": "other"}, "rule")],
)
def test_decisions_about_bundles_are_counted(replenished: Trace, change: dict[str, Any], fault: str) -> None:
    """What ROA says it decided, saw, and who it was."""
    made = [event for event in replenished.events if isinstance(event, DecisionMade)]
    at = next(i for i, event in enumerate(made) if event.decides is Role.ROA)
    assert fault in kinds(changed(replenished, DecisionMade, lambda event: evolve(event, **change), at))


def test_bundles_of_a_file(tmp_path: Path) -> None:
    """The header has what was to come; a validator needs no file beside it."""
    (tmp_path / "bundles.csv").write_text("bundle,arrival_s,sku,items\nB,5,new,3\nA,1,1,2\n", encoding="utf-8")
    supply = {"process": "file", "file": str(tmp_path / "bundles.csv")}
    scenario = scenario_of(supply, instance=INSTANCE | {"orders": 6, "replenishment": supply}, run={"until_s": 90.0})
    rmfs_core.run(scenario, out=tmp_path / "out", record=["trace"])
    trace = read_trace(tmp_path / "out" / "trace.jsonl.gz")
    assert [(bundle.name, bundle.arrival_tick) for bundle in trace.instance.bundles] == [("A", 1000), ("B", 5000)]
    assert trace.instance.skus[-1] == "new"
    assert kinds(trace) == set()
    assert "bundle-arrival" in kinds(changed(trace, BundleArrived, lambda event: None, at=1))


def test_bundles_are_stored_while_pickers_are_away(tmp_path: Path) -> None:
    """Opening hours are those of picking stations: the others go on, and the validator knows."""
    instance = INSTANCE | {"items_per_sku": 1}
    hours = {"open": [["00:10", "24:00"]], "queue_length": 3}
    rmfs_core.run(scenario_of(SUPPLY, instance=instance, stations=hours), out=tmp_path, record=["trace"])
    trace = read_trace(tmp_path / "trace.jsonl.gz")
    assert next(event for event in trace.events if isinstance(event, BundleStored)).tick < 600_000
    assert kinds(trace) == set()


def test_activation_is_of_picking_stations(tmp_path: Path) -> None:
    """Where a rule says by load which stations take orders, nothing becomes of those that store."""
    rules = RULES | {"activate": "backlog-threshold"}
    rmfs_core.run(scenario_of(SUPPLY, instance=INSTANCE, rules=rules), out=tmp_path, record=["trace"])
    assert check_trace(tmp_path).faults == []
