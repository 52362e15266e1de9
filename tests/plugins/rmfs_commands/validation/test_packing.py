"""Whether what happens at packing stations can have happened."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from rmfs_commands.trace import read_trace
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation import check_trace, faults_of
from rmfs_core.events import (
    Event,
    OrderConsolidated,
    OrderPacked,
    PackingAssigned,
    PackingStarted,
    PartArrived,
    PartPut,
    PartSent,
)

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


def split(event: Any) -> bool:
    return event.box is not None


CHANGES: dict[str, tuple[type[Event], Callable[[Any], Any], Callable[[Any], bool]]] = {
    "packing-bound": (PackingAssigned, lambda event: evolve(event, box=None), split),
    "box": (PackingAssigned, lambda event: evolve(event, box=1 - event.box), split),
    "tote": (PartSent, lambda event: evolve(event, items=event.items + 1), lambda _: True),
    "conveyor-time": (PartArrived, lambda event: evolve(event, tick=event.tick - 1), lambda _: True),
    "put": (PartPut, lambda event: evolve(event, start_tick=event.start_tick - 1), lambda _: True),
    "consolidated": (PartPut, lambda event: evolve(event, items=event.items - 1), lambda _: True),
    "packed-early": (OrderConsolidated, lambda event: evolve(event, order=event.order ^ 1), lambda _: True),
    "pack-time": (PackingStarted, lambda event: evolve(event, tick=event.tick - 1), lambda _: True),
}


@pytest.mark.parametrize("kind", CHANGES)
def test_what_cannot_be_is_found(packed: Trace, kind: str) -> None:
    """As late in the run as there is one: a box that another order has."""
    cls, change, where = CHANGES[kind]
    found = set()
    for at, event in enumerate(packed.events):
        if isinstance(event, cls) and where(event):
            events = (*packed.events[:at], change(event), *packed.events[at + 1 :])
            found |= {fault.kind for fault in faults_of(evolve(packed, events=events))}
            if kind in found:
                return
    pytest.fail(f"found {found}")


def test_an_order_that_is_not_packed_is_found(packed: Trace) -> None:
    last = [event for event in packed.events if isinstance(event, OrderPacked)][-1]
    (fault,) = faults_of(evolve(packed, events=tuple(event for event in packed.events if event is not last)))[-1:]
    assert fault.kind in ("not-packed", "end")
    assert "not-packed" in {fault.kind for fault in faults_of(evolve(packed, events=packed.events[:-1]))}


@pytest.mark.parametrize("change", [{"packers": 0}, {"open": {"1": [["12:00", "13:00"]]}}])
def test_more_packers_than_there_are_show(packed: Trace, change: dict[str, Any]) -> None:
    """In the whole run, and in one that ends while the first order is packed."""
    section = packed.scenario["packing"] | change
    begun = next(at for at, one in enumerate(packed.events) if isinstance(one, PackingStarted) and one.packing == 0)
    events = tuple(event for event in packed.events[: begun + 1] if not isinstance(event, PartPut))
    for part in (packed, evolve(packed, events=events, status="horizon")):
        found = faults_of(evolve(part, scenario={**packed.scenario, "packing": section}))
        assert {fault.kind for fault in found} >= {"packers"}
