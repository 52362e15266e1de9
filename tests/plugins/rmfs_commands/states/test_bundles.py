"""States with bundles, with orders that wait for stock, and with packing stations."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from cases import cases
from rmfs_commands.cli.main import main
from rmfs_commands.states import decide, read_recording, state_from_dict
from rmfs_commands.states.recorded import Recording
from rmfs_commands.states.stories import order_story, pod_story
from rmfs_core import InputError
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice


def state(**changes: Any) -> dict[str, Any]:
    """Return a state: a station for picking, one for bundles; one bundle waits, the other is at its station."""
    return {
        "format": "rmfs-state",
        "version": 2,
        "time_s": 100,
        "pods": {"P": {"contents": {"a": 3}, "capacity": 10}, "Q": {"contents": {"b": 1}, "capacity": 10}},
        "stations": {"out": {"item_capacity": 5}, "in": {"bundle_capacity": 2}},
        "orders": {},
        "sizes": {"b": 2},
        "bundles": [
            {"name": "late", "sku": "a", "items": 4, "arrival_s": 90},
            {"name": "early", "sku": "b", "items": 4, "arrival_s": 10, "station": "in"},
        ],
    } | changes


@cases(
    "rule decided outcome",
    ("first-bundle", {"bundles": [{"bundle": "late", "station": "in"}]}, (1, 0, 0, 0, 2)),
    ("same-sku", {"stores": [{"bundle": "early", "pod": "Q"}]}, (0, 4, 1, 1, 0)),
    (
        {"rule": "pod-first", "parameters": {"pod": "same-sku"}},
        {
            "bundles": [{"bundle": "late", "station": "in"}],
            "stores": [{"bundle": "early", "pod": "Q"}, {"bundle": "late", "pod": "P"}],
        },
        (1, 8, 2, 0, 0),
    ),
)
def test_each_decision_has_its_answer_and_outcome(rule: Any, decided: dict[str, Any], outcome: tuple[int, ...]) -> None:
    choice = RuleChoice(**rule) if isinstance(rule, dict) else RuleChoice(rule)
    answer = decide(state_from_dict(state()), choice).to_dict()
    assert {key: answer[key] for key in ("bundles", "stores") if key in answer} == decided
    assert tuple(answer["outcome"].values()) == outcome


def test_pods_have_their_own_capacity_and_number() -> None:
    pods = {"P": {"contents": {"a": 8}, "capacity": 10}, "Q": {"contents": {"b": 1}, "capacity": 3}}
    bundles = [{"name": "x", "sku": "b", "items": 1, "arrival_s": 10, "station": "in"}]
    answer = decide(state_from_dict(state(pods=pods, bundles=bundles)), RuleChoice("emptiest-pod")).to_dict()
    assert answer["stores"] == [{"bundle": "x", "pod": "P"}]
    for more in ({"ask": {"max_fetches": 0}}, {"robots": {}}):
        assert decide(state_from_dict(state(**more)), RuleChoice("same-sku")).decision == {"stores": []}


LATE = {"name": "late", "sku": "a", "items": 4}


@cases(
    "changes problem",
    ({"version": 1}, "`bundle_capacity` or `bundles` in a state of version 1"),
    ({"bundles": [LATE, LATE]}, r'bundles\[1\]\.name: found "late" twice'),
    ({"bundles": [LATE | {"station": "on"}]}, r'bundles\[0\]\.station: names station "on"'),
    ({"bundles": [LATE | {"station": "out"}]}, r"bundles\[0\]\.station: expected one that holds more bundles"),
    ({"bundles": [LATE | {"station": "in", "pod": "P"}]}, r"bundles\[0\]\.pod: expected a pod with space"),
    ({"bundles": [LATE | {"arrival_s": 101}]}, r"bundles\[0\]\.arrival_s: found 101.*later than now"),
    ({"bundles": [LATE | {"items": 0}]}, r"bundles\[0\]\.items: expected a whole number from 1"),
    ({"sizes": {"z": 1}}, r'sizes\.z: names SKU "z"'),
    ({"stations": {"in": {"bundle_capacity": 2}}, "bundles": []}, "stations: found none; expected at least one"),
    (
        {"stations": {"in": {"bundle_capacity": 2}, "out": {"item_capacity": 5}}, "bundles": []},
        r"stations\.out: found one that picks orders; expected stations that only store bundles to come last",
    ),
    ({"stations": {"out": {"queue_length": 2}}}, "expected either `item_capacity` or `order_capacity`"),
)
def test_what_cannot_be_is_refused(changes: dict[str, Any], problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        decide(state_from_dict(state(**changes)), RuleChoice("first-bundle"))


def test_stations_are_of_the_kinds_that_the_layout_has() -> None:
    wrong = {"out": {"item_capacity": 5, "queue_length": 1}, "in": {"item_capacity": 2, "queue_length": 1}}
    layout = {"blocks": {"block_rows": 3, "block_columns": 1, "stations_east": 1, "replenishment_west": 1}}
    given = state(stations=wrong, pods={}, sizes={}, skus=["a", "b"], layout=layout, bundles=[])
    with pytest.raises(InputError, match=r"stations\.in: found one that picks orders; expected one that stores"):
        decide(state_from_dict(given), RuleChoice("first-bundle"))


def test_a_run_explains_what_was_decided_for_bundles(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rmfs_core.run("examples/replenished", overrides=["instance.orders=40"], out=tmp_path, record=["decisions"])
    chosen = next(recorded for recorded in read_recording(tmp_path) if recorded.decides.label == "RPS")
    (store,) = chosen.decision["stores"]
    against = ("--against", "spread-sku", "--against", "random")
    main(["explain", str(tmp_path), "--decision", str(chosen.number), *against])
    shown = capsys.readouterr().out
    assert f"RPS by emptiest-pod, period {chosen.period}" in shown
    assert "Without" in shown
    assert f"bundles {store['bundle']} to pod {store['pod']}" in shown
    told = [episode.what for episode in pod_story(read_recording(tmp_path), store["pod"])]
    assert any(what.startswith(f"chosen for bundle {store['bundle']}: ") for what in told)


NEW = {"format": "rmfs-state", "version": 2}


def asked(**orders: dict[str, Any]) -> dict[str, Any]:
    """Return the answer of a rule that assigns orders, the only place of a station among it."""
    given = NEW | {
        "pods": {"P": {"contents": {"tea": 3}}},
        "stations": {"n": {"order_capacity": 1}},
        "orders": {"old": {"lines": {"milk": 1}}, "new": {"lines": {"tea": 1}}} | orders,
    }
    return decide(state_from_dict(given), RuleChoice("pod-match")).to_dict()


def test_orders_that_stock_cannot_serve_are_not_shown() -> None:
    """The younger order is assigned, and the answer names the one that waits; what a state says of it counts."""
    answer = asked()
    assert [given["order"] for given in answer["assignments"]] == ["new"]
    assert answer["waiting_for_stock"] == ["old"]
    answer = asked(old={"lines": {"milk": 1}, "waits_for_stock": False})
    assert [given["order"] for given in answer["assignments"]] == ["old"]
    assert "waiting_for_stock" not in answer
    answer = asked(new={"lines": {"tea": 1}, "waits_for_stock": True})
    assert (answer["assignments"], answer["waiting_for_stock"]) == ([], ["old", "new"])


def test_the_oldest_orders_take_their_share_of_stock_first() -> None:
    """Two items are left for orders, as one of three is requested; an order that is begun keeps what it wants."""
    stations = {"n": {"item_capacity": 9, "requests": [{"order": "B", "sku": "tea"}]}}
    orders = {
        "A": {"lines": {"tea": 1}, "arrival_s": 30},
        "B": {"lines": {"tea": 1, "jam": 1}, "arrival_s": 20},
        "C": {"lines": {"tea": 2}, "arrival_s": 10},
        "D": {"lines": {"jam": 1}, "arrival_s": 5},
    }
    given = NEW | {"pods": {"P": {"contents": {"tea": 3, "jam": 1}}}, "stations": stations, "orders": orders}
    answer = decide(state_from_dict(given), RuleChoice("first-come")).to_dict()
    assert [one["order"] for one in answer["assignments"]] == ["C", "B"]
    assert answer["waiting_for_stock"] == ["D", "A"]


@cases(
    "changes problem",
    ({"version": 1}, "`waits_for_stock` in a state of version 1; expected version 2"),
    ({"backlog": ["A"]}, r"orders\.A\.waits_for_stock: found true .* waits no more: `backlog` names it"),
    (
        {"stations": {"n": {"order_capacity": 1, "requests": [{"order": "A", "sku": "tea"}]}}},
        r"orders\.A\.waits_for_stock: found true .*: lines of it are assigned",
    ),
)
def test_an_order_that_waits_is_neither_shown_nor_begun(changes: dict[str, Any], problem: str) -> None:
    orders = {"A": {"lines": {"tea": 1, "jam": 1}, "waits_for_stock": True}}
    given = NEW | {"pods": {"P": {"contents": {"tea": 3}}}, "stations": {"n": {"order_capacity": 1}}, "orders": orders}
    with pytest.raises(InputError, match=problem):
        decide(state_from_dict(given | changes), RuleChoice("first-come"))


PACKING = (
    *("rules.poa=", "rules.pps=", "rules.poa_pps=pod-index", "instance.start='2024-03-01T06:30:15'"),
    "packing={stations=2, boxes=2, packers=1, sorters=1, open={2=[['06:00', '05:00']]}}",
)


def test_the_story_of_an_order_goes_on_to_its_packing(record: Callable[..., Recording]) -> None:
    recording = record(*PACKING)
    bound = {
        one["order"] for made in recording if made.decides is Role.PACKING for one in (made.decision or {})["packing"]
    }
    told = {order: " ".join(episode.what for episode in order_story(recording, order)) for order in sorted(bound)[:8]}
    assert all("bound for packing station " in story for story in told.values())
    assert any("and no box was free to split it" in story for story in told.values())
    assert any(
        re.search(r"(pack order|put tote \d+, into the box of order) \d+ at packing", one) for one in told.values()
    )


STATE: dict[str, Any] = {
    "format": "rmfs-state",
    "version": 2,
    "pods": {"P": {"contents": {"a": 9, "b": 9}}},
    "stations": {"1": {"item_capacity": 9}, "2": {"item_capacity": 9}},
    "orders": {
        "1": {"lines": {"a": 1, "b": 1}, "parts": [{"station": "1", "skus": ["a"]}]},
        "2": {
            "lines": {"a": 2, "b": 1},
            "parts": [{"station": "1", "skus": ["a"]}, {"station": "2", "skus": ["b"]}],
            "packing": {"station": "1", "box": 0, "items_in_box": 1},
        },
        "3": {"lines": {"a": 1}, "parts": [{"station": "1", "skus": ["a"]}], "packing": {"station": "1"}},
    },
    "packing": {
        "section": {"boxes": 1, "packers": 1},
        "stations": [
            {
                "tasks": [
                    {"kind": "put", "order": "2", "tote": 1, "items": 2, "duration_s": 11},
                    {"kind": "pack", "order": "3", "tote": 2, "items": 1, "duration_s": 35},
                ]
            },
            {},
        ],
    },
}


def answer_of(
    rule: str, decides: str, change: Callable[[dict[str, Any]], object] = lambda state: None, **ask: Any
) -> Any:
    orders = {name: {**order} for name, order in STATE["orders"].items()}
    stations = [{**station} for station in STATE["packing"]["stations"]]
    state = {**STATE, "orders": orders, "packing": {**STATE["packing"], "stations": stations}}
    state["ask"] = {"decides": decides, **ask}
    change(state)
    return decide(state_from_dict(state), RuleChoice(rule)).decision


def test_a_state_written_by_hand() -> None:
    """Station 1 has no box left; of its tasks one is to pack."""
    assert answer_of("least-reserved", "packing") == {"packing": [{"order": "1", "station": "2"}]}
    assert answer_of("pack-first", "packing-task") == {"task": 1}
    assert answer_of("first-come", "packing-task", station="1") == {"task": 0}
    assert answer_of("first-come", "POA")["assignments"][0]["order"] == "1"


def test_a_rule_that_decides_more_is_asked_that_unless_told_otherwise() -> None:
    state = {**STATE, "ask": {}}
    assert decide(state_from_dict(state), RuleChoice("first-come")).decides is Role.POA


@cases(
    "change told",
    (lambda s: s.pop("packing"), r'orders.2.packing.station: names packing station "1"; the state has 0'),
    (lambda s: s["orders"]["1"].update(packing={"station": "3"}), 'packing station "3"; the state has 2'),
    (lambda s: s["orders"]["2"].update(packing={"station": "1"}), "expected a box for an order that is split"),
    (lambda s: s["orders"]["1"].update(packing={"station": "1", "box": 0}), "found a box that two orders have"),
    (lambda s: s["orders"]["3"].update(parts=[]), "found it for an order of which no part is assigned"),
    (lambda s: s["packing"]["stations"][0].update(orders=["3"]), "whose `packing` names it .* not packed: 2, 3"),
    (lambda s: s["packing"].update(stations=[]), "expected one packing station or more"),
    (
        lambda s: s["packing"]["stations"][1].update(tasks=[{"kind": "pack", "order": "3"}]),
        r'packing.stations\[1\].tasks: names order "3", which is not bound for it',
    ),
    (lambda s: s.update(version=1), "found `packing` in a state of version 1"),
    (lambda s: s["ask"].update(orders=["2"]), 'ask.orders: names order "2", which is bound for a packing station'),
)
def test_a_state_that_contradicts_itself_is_refused(change: Callable[[dict[str, Any]], object], told: str) -> None:
    with pytest.raises(InputError, match=told):
        answer_of("least-reserved", "packing", change)


def test_nothing_to_do_is_said() -> None:
    with pytest.raises(InputError, match=r"ask.station: no packer is free for a task at packing station 2"):
        answer_of("shortest", "packing-task", station="2")
