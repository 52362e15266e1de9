"""A recorded state handed to the same rule gives the decision of the run."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from rmfs_commands.cli.single_rule import load_rule
from rmfs_commands.states import decide, read_recording, state_from_dict, state_to_dict
from rmfs_commands.states.deciding import ask, outcome_of
from rmfs_commands.states.rebuilding import open_state
from rmfs_core import hookimpl
from rmfs_core.info import Question
from rmfs_core.results.files import to_json
from rmfs_core.roles import Role
from rmfs_core.rules import BoundRule
from rmfs_core.warehouse import WarehouseView
from rmfs_core.warehouse.parts import Part, ReadOnly

JOINT = ("rules.poa=", "rules.pps=")
REPLENISHED = (
    'instance.replenishment={process="reorder-point", reorder_point=12, order_up_to=20, bundle_items=5, lead_s=5}',
    "instance.orders=18",
    "instance.items_per_sku=3",
    "instance.pod_capacity=25",
    "layout.replenishment_west=2",
    "rules.roa=first-bundle",
    "rules.rps=correlated",
)
AT_PICKING = ("layout.replenishment_west=", "stations.also_replenish=true", "rules.roa=", "rules.rps=")
RULE_SETS = {
    "sequential": ("rules.pr=random",),
    "common-lines and nearest-pod": ("rules.poa=common-lines", "rules.pps=nearest-pod", "rules.pr=fixed"),
    "first-come, finite stock": ("rules.poa=first-come", "instance.items_per_sku=20"),
    "a prefilter": ('rules.filters=[{rule="most-covered",n=3}]',),
    "order capacity, arrivals": (
        "stations.order_capacity=2",
        "instance.arrivals.process=poisson",
        "instance.arrivals.orders_per_hour=200",
    ),
    "integrated": (*JOINT, "rules.poa_pps=integrated"),
    "split-among-stations": (*JOINT, "rules.poa_pps=split-among-stations"),
    "split-over-time": (*JOINT, "rules.poa_pps=split-over-time", "rules.pr=random"),
    "order capacity, split-over-time": (*JOINT, "rules.poa_pps=split-over-time", "stations.order_capacity=2"),
    "places that are kept until items are handled": ("stations.release=handled", "stations.order_capacity=2"),
    "a backlog that is refilled": ('instance.arrivals={process="refill", backlog=4}', "stations.release=handled"),
    "orders larger than any station": ("stations.item_capacity=3",),
    "orders larger than any station, integrated": (*JOINT, "rules.poa_pps=integrated", "stations.item_capacity=3"),
    "robots that rest": (
        "rules.idle=rest-middle",
        "instance.arrivals.process=poisson",
        "instance.arrivals.orders_per_hour=200",
    ),
    "robots that charge": (
        "rules.idle=charge-when-low",
        "layout.chargers=1",
        "robots.battery={capacity_wh=55, loaded_w=900, charging_w=20000, detour=1.2}",
    ),
    "replenishment": (*REPLENISHED, "rules.roa=same-pod", "rules.rps=random"),
    "replenishment at picking stations": (*REPLENISHED, *AT_PICKING, "rules.roa_rps=pod-first"),
    "packing capacity": (*JOINT, 'rules.poa_pps={rule="split-over-time",packing_capacity=2}'),
}


@pytest.mark.parametrize("settings", RULE_SETS.values(), ids=RULE_SETS)
def test_every_decision_of_a_run_is_made_again(record: Any, settings: tuple[str, ...]) -> None:
    """Each recorded state, asked again, gives the same decision and report; and applying it does not fail."""
    recording = record(*settings)
    kinds: Counter[str] = Counter()
    rules: dict[str, BoundRule] = {}
    for recorded in recording:
        if recorded.decides not in rules:
            rules[recorded.decides] = load_rule(recording.choice_of(recorded), (recorded.decides,))
        again = ask(open_state(recorded.state(), recorded.place), rules[recorded.decides])
        assert again.decision == recorded.decision, recorded.place
        assert again.report == recorded.report, recorded.place
        assert outcome_of(recorded.state(), recorded.decides, recorded.decision or {}) == again.outcome
        kinds[recorded.decides.label] += 1
    assert min(kinds.values()) >= 2
    decided = [role for role in (Role.ROA, Role.RPS, Role.ROA_RPS) if getattr(recording.scenario.rules, role.key)]
    assert kinds.keys() >= {"PR", "TA", *(role.label for role in decided)}


def test_numbers_are_drawn_as_in_the_run(record: Any) -> None:
    """The random rule has drawn before in most states: what is stored of its generator is what gives its next place."""
    recording = record("rules.pr=random")
    drawn = [recorded for recorded in recording if recorded.decides is Role.PR and "random" in recorded.content]
    assert len(drawn) >= 5
    forgotten = 0
    for recorded in drawn:
        choice = recording.choice_of(recorded)
        assert decide(recorded.state(), choice).decision == recorded.decision
        fresh = state_from_dict({key: value for key, value in recorded.content.items() if key != "random"})
        forgotten += decide(fresh, choice).decision != recorded.decision
    assert forgotten


def test_a_recorded_state_is_one_json_object(record: Any) -> None:
    """What `explain --state` writes reads back as an equal state, and so does what is written of that."""
    for recorded in record("rules.pr=random"):
        state = recorded.state()
        assert state_from_dict(json.loads(to_json(recorded.content))) == state
        assert state_from_dict(json.loads(to_json(state_to_dict(state)))) == state


@pytest.mark.parametrize(
    "settings",
    [
        ("instance.items_per_sku=20", "stations.order_capacity=2"),
        ("rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time", 'rules.filters=[{rule="most-covered",n=4}]'),
        ("stations.order_capacity=2", "rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time"),
        ("rules.pp=free-flow", "stations.item_capacity=3"),
        ("rules.pp=sipp",),
        REPLENISHED,
    ],
)
def test_rules_see_what_they_saw_in_the_run(tmp_path: Path, settings: tuple[str, ...]) -> None:
    """Every public value of everything in the view is the same in the run and in the warehouse made from the state."""
    seen: list[dict[Any, Any]] = []

    class Note:
        @hookimpl
        def rule_asked(self, question: Question) -> None:
            if question.decides not in (Role.FILTER, Role.PP):
                seen.append(public_values(question.warehouse))

    overrides = ["instance.orders=14", "instance.max_lines=5", "stations.item_capacity=6", *settings]
    rmfs_core.run("examples/small", overrides=overrides, out=tmp_path, record=["decisions"], observers=[Note()])
    for recorded, values in zip(read_recording(tmp_path), seen, strict=True):
        again = public_values(open_state(recorded.state()).view)
        assert {key: value for key, value in again.items() if values[key] != value} == {}
        assert again.keys() == values.keys()
    assert len(seen) > 20


COLUMNS = {"backlog_lines", "free_items", "lines", "stock"}
"""Arrays made of the other values, which are compared by themselves."""


def public_values(view: WarehouseView) -> dict[Any, Any]:
    """Return what a view and everything in it show, by whose it is and what it is called."""
    parts: list[Any] = [view, *view.orders, *view.pods, *view.stations, *view.robots, *view.bundles]
    parts += [request for station in view.stations for request in station.open_requests]
    parts += [station for station in view.replenishment_stations if not station.picks]
    parts += [bundle for station in view.replenishment_stations for bundle in station.bundles]
    values: dict[Any, Any] = {}
    for part in parts:
        for name in dir(part):
            if not name.startswith("_") and name not in COLUMNS | {"label", "travel"}:
                value = getattr(part, name)
                if not callable(value):
                    values[plain(part), name] = plain(value)
    for pod in view.pods:
        values["free", pod.id] = [pod.free_items(sku) for sku in pod.contents]
        values["home", pod.id] = view.home(pod)
    lines, stock = view.backlog_lines, view.stock
    values["lines"] = [of.tolist() for of in (lines.order, lines.sku, lines.quantity)]
    values["stock"] = [of.tolist() for of in (*stock[:6], stock.at, stock.location, stock.space)]
    values["sums"] = [of.tolist() for of in (view.open_demand(), view.available(), view.ordered())]
    return values


def plain(value: Any) -> Any:
    """Return a value as one that can be compared across two warehouses."""
    if isinstance(value, Part):
        return ("part", value.order.id, value.station, value.period, value.items, value.unpicked_items)
    if isinstance(value, ReadOnly):
        return (type(value).__name__, getattr(value, "id", None))
    if isinstance(value, Mapping):
        return list(value.items())
    if isinstance(value, tuple) and not hasattr(value, "_fields"):
        return [plain(entry) for entry in value]
    return value
