"""States with packing stations: recorded, restored, asked, and refused where they make no sense."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest

import rmfs_core
from rmfs_commands.states import decide, read_recording, state_from_dict
from rmfs_commands.states.deciding import outcome_of
from rmfs_commands.states.plain import Memento
from rmfs_commands.states.rebuilding import open_state
from rmfs_commands.states.recorded import Recording
from rmfs_commands.states.stories import order_story
from rmfs_core import hookimpl
from rmfs_core.errors import InputError
from rmfs_core.info import Question, RunInfo
from rmfs_core.roles import Role
from rmfs_core.scenario.model import RuleChoice

FEW = (
    "instance.orders=20",
    "packing={stations=2, boxes=2, packers=1, sorters=1, open={2=[['06:00', '05:00']]}}",
    "instance.start='2024-03-01T06:30:15'",
    "rules.pp=free-flow",
)


class Mementos:
    """States that rules of packing stations were shown."""

    def __init__(self) -> None:
        self.seen: list[Memento] = []

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        self.skus = run.instance.skus

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        if question.decides in (Role.PACKING, Role.PACKING_TASK):
            self.seen.append(Memento.of(question.warehouse, self.skus))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, list[Memento]]:
    """Decisions of a run with few boxes, and what was there."""
    folder, observer = tmp_path_factory.mktemp("packed"), Mementos()
    rmfs_core.run("examples/packing", overrides=FEW, out=folder, record=["decisions"], observers=[observer])
    return read_recording(folder), observer.seen


def test_what_was_there_is_restored_and_decided_again(recorded: tuple[Recording, list[Memento]]) -> None:
    recording, seen = recorded
    asked = [one for one in recording if one.decides in (Role.PACKING, Role.PACKING_TASK)]
    found: Counter[str] = Counter()
    for one, memento in zip(asked, seen, strict=True):
        state = one.state()
        opened = open_state(state)
        assert Memento.of(opened.view, opened.instance.skus) == memento
        assert one.decision is not None
        assert outcome_of(state, one.decides, one.decision) is None
        answer = decide(state, recording.choice_of(one), decides=one.decides)
        assert answer.decision == one.decision
        found[one.decides.label] += 1
        found["tasks"] += sum(len(station.tasks) for station in memento.packing)
        found["working"] += sum(len(station.working) for station in memento.packing)
        found["packed"] += sum(order.packing is not None and order.packing.packed for order in memento.orders)
        assert [one.zero for one in memento.packing] == [0, (6 * 3600 + 30 * 60 + 15) * 1000]
    assert [one.hours.at(0) for one in opened.view.packing_stations] == [1, 1]
    assert opened.view.packing_stations[1].hours.next_change(0) == (22 * 3600 + 29 * 60 + 45) * 1000
    assert min(found.values()) >= 5
    assert found.keys() == {"packing", "packing-task", "tasks", "working", "packed"}


def test_the_story_of_an_order_goes_on_to_its_packing(recorded: tuple[Recording, list[Memento]]) -> None:
    recording, _ = recorded
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


def asked(rule: str, decides: str, change: Callable[[dict[str, Any]], object] = lambda state: None, **ask: Any) -> Any:
    """Return what a rule decides in the state above, changed."""
    orders = {name: {**order} for name, order in STATE["orders"].items()}
    stations = [{**station} for station in STATE["packing"]["stations"]]
    state = {**STATE, "orders": orders, "packing": {**STATE["packing"], "stations": stations}}
    state["ask"] = {"decides": decides, **ask}
    change(state)
    return decide(state_from_dict(state), RuleChoice(rule)).decision


def test_a_state_written_by_hand() -> None:
    """Station 1 has no box left; of its tasks one is to pack."""
    assert asked("least-reserved", "packing") == {"packing": [{"order": "1", "station": "2"}]}
    assert asked("pack-first", "packing-task") == {"task": 1}
    assert asked("first-come", "packing-task", station="1") == {"task": 0}
    assert asked("first-come", "POA")["assignments"][0]["order"] == "1"


def test_a_rule_that_decides_more_is_asked_that_unless_told_otherwise() -> None:
    state = {**STATE, "ask": {}}
    assert decide(state_from_dict(state), RuleChoice("first-come")).decides is Role.POA


@pytest.mark.parametrize(
    ("change", "told"),
    [
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
    ],
)
def test_a_state_that_contradicts_itself_is_refused(change: Callable[[dict[str, Any]], object], told: str) -> None:
    with pytest.raises(InputError, match=told):
        asked("least-reserved", "packing", change)


def test_nothing_to_do_is_said() -> None:
    with pytest.raises(InputError, match=r"ask.station: no packer is free for a task at packing station 2"):
        asked("shortest", "packing-task", station="2")
