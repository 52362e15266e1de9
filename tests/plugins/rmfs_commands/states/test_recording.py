"""A run's decisions: recorded, read again, and decided again."""

import gzip
import json
from collections import Counter
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from bad_rules import write_rule
from calling import refusal
from cases import cases
from rmfs_commands.cli.single_rule import load_rule
from rmfs_commands.results.files import to_json
from rmfs_commands.states import Recording, decide, read_recording, state_from_dict, state_to_dict
from rmfs_commands.states.deciding import ask, outcome_of
from rmfs_commands.states.patches import difference
from rmfs_commands.states.plain import Memento
from rmfs_commands.states.rebuilding import open_state
from rmfs_commands.states.recording import RECORDING_FILE
from rmfs_core import InputError, RuleError, hookimpl
from rmfs_core.info import Question, RunInfo
from rmfs_core.roles import Role
from rmfs_core.rules import BoundRule
from rmfs_core.scenario import RuleChoice

SETTINGS = ("instance.orders=6", "rules.pp=free-flow")


def test_decisions_are_all_there(tmp_path: Path) -> None:
    plain = rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path / "plain")
    for name in ("one", "two"):
        result = rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path / name, record=["decisions"])
        assert result.metrics == plain.metrics
    for file in ("orders.csv", "visits.csv"):
        assert (tmp_path / "plain" / file).read_bytes() == (tmp_path / "one" / file).read_bytes()
    assert (tmp_path / "one" / RECORDING_FILE).read_bytes() == (tmp_path / "two" / RECORDING_FILE).read_bytes()
    assert not (tmp_path / "plain" / RECORDING_FILE).exists()
    recorded = [r for r in read_recording(tmp_path / "two") if r.decides in (Role.POA, Role.PPS)]
    assert [(r.period, r.time_s, r.decides.label, r.rule) for r in recorded] == [
        (row["period"], row["time_s"], row["decides"], row["rule"]) for row in result.periods
    ]
    for decision, row in zip(recorded, result.periods, strict=True):
        assert len(decision.decision.get("assignments", ())) == row["assignments"]
        assert len(decision.decision.get("trips", ())) == row["trips"]


def test_recordings_and_folders(tmp_path: Path) -> None:
    rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path, record=["decisions"])
    rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path)
    with pytest.raises(InputError, match="run the scenario with `--record-decisions`"):
        read_recording(tmp_path)
    with pytest.raises(InputError, match=r"decisions: .* expected `out`"):
        rmfs_core.run("examples/small", record=["decisions"])


@cases(
    "body problem",
    ("return [OrderAssignment(99 if len(warehouse.backlog) <= 5 else warehouse.backlog[0].id, 0)]", "named order 99"),
    ('raise ZeroDivisionError("nothing to divide")', "nothing to divide"),
)
def test_what_a_failing_rule_saw_is_kept(tmp_path: Path, body: str, problem: str) -> None:
    write_rule(tmp_path, "poa", body)
    rule = f"{tmp_path}/bad.py:Bad"
    with pytest.raises(RuleError, match=problem):
        rmfs_core.run("examples/small", overrides=[*SETTINGS, f"rules.poa={rule}"], out=tmp_path, record=["decisions"])
    *_, last = read_recording(tmp_path)
    assert (last.decides, last.decision) == (Role.POA, None)
    with pytest.raises(RuleError, match=problem):
        decide(last.state(), RuleChoice(rule))


def test_a_rule_that_the_scenario_does_not_name(record: Any, damaged: Callable[..., Path]) -> None:
    first = next(iter(record()))
    assert record().choice_of(first).rule == first.rule == "pod-match"
    other = read_recording(damaged(lambda lines: [lines[0], lines[1] | {"decides": "POA+PPS"}, *lines[2:]]))
    with pytest.raises(InputError, match=r"has no rule for POA\+PPS"):
        other.choice_of(next(iter(other)))


@cases(
    "line change problem",
    (1, lambda header: header | {"format": "other"}, "format: expected 'rmfs-decisions', found 'other'"),
    (1, lambda header: header | {"version": 99}, "version: expected version 1 of 'rmfs-decisions', found 99"),
    (1, lambda header: without(header, "state"), "lacks `scenario` or `state`"),
    (1, lambda header: header | {"scenario": 5}, "lacks `scenario` or `state`"),
    (1, lambda header: header | {"scenario": {"rules": {}}}, "scenario"),
    (4, lambda line: line | {"decides": "lunch"}, "no role is called 'lunch'"),
    (4, lambda line: line | {"decides": "PP"}, "found PP of period 1"),
    (4, lambda line: without(line, "rule"), "this is no recorded decision: it lacks rule"),
    (4, lambda line: line | {"change": 5}, "change: expected a JSON object, found 5"),
    (4, lambda line: line | {"decision": "POA"}, "decision: expected a JSON object, found 'POA'"),
    (4, lambda line: line | {"rule": ["demand"]}, "rule: expected a rule's name, found ['demand']"),
    (4, lambda line: line | {"report": [1]}, "report: expected a JSON object, found [1]"),
    (4, lambda line: 5, "expected a JSON object, found int"),
)
def test_a_line_that_is_no_decision_is_named(damaged, line, change, problem) -> None:
    folder = damaged(lambda lines: [*lines[: line - 1], change(lines[line - 1]), *lines[line:]])
    said = refusal(lambda: [*read_recording(folder)])
    assert f"line {line}" in said
    assert problem in said


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
WAITING = (*REPLENISHED, "instance.orders=40", "instance.replenishment.lead_s=240")
PACKING = (
    *(*JOINT, "rules.poa_pps=pod-index", "instance.start='2024-03-01T06:30:15'"),
    "packing={stations=2, boxes=2, packers=1, sorters=1, open={2=[['06:00', '05:00']]}}",
)
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
    "orders that wait for stock": WAITING,
    "packing stations": PACKING,
    "packing capacity": (*JOINT, 'rules.poa_pps={rule="split-over-time",packing_capacity=2}'),
}


@pytest.mark.parametrize("settings", RULE_SETS.values(), ids=RULE_SETS)
def test_every_decision_of_a_run_is_made_again(record: Any, settings: tuple[str, ...]) -> None:
    recording = record(*settings)
    kinds: Counter[str] = Counter()
    rules: dict[str, BoundRule] = {}
    for recorded in recording:
        state = recorded.state()
        assert state_from_dict(json.loads(to_json(state_to_dict(state)))) == state
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
    if recording.scenario.packing:
        assert min(kinds["packing"], kinds["packing-task"]) >= 5


@cases(
    "settings",
    ("instance.items_per_sku=20", "stations.order_capacity=2"),
    ("rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time", 'rules.filters=[{rule="most-covered",n=4}]'),
    ("stations.order_capacity=2", "rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time"),
    ("rules.pp=free-flow", "stations.item_capacity=3"),
    ("rules.pp=sipp",),
    REPLENISHED,
    ("stations.release=handled", "stations.order_capacity=2"),
    ("stations.release=handled", "rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time"),
    ("stations.release=handled", "stations.item_capacity=3"),
    WAITING,
    PACKING,
    ('instance.arrivals={process="refill", backlog=4}', "stations.release=handled"),
    (
        'stations.open={1 = [["00:00", "00:02"]], 2 = [["00:01", "24:00"]]}',
        'robots.available=[["00:00", "00:03"], ["00:03", "24:00", 1]]',
        "rules.activate={rule='backlog-threshold', open_above=2, timeout_s=60}",
    ),
)
def test_rules_see_what_they_saw_in_the_run(tmp_path: Path, settings: tuple[str, ...]) -> None:
    """A state as JSON, opened, is the warehouse at each decision."""
    seen: list[Memento] = []

    class Note:
        @hookimpl
        def run_started(self, run: RunInfo) -> None:
            self.skus = run.instance.skus

        @hookimpl
        def rule_asked(self, question: Question) -> None:
            if question.decides not in (Role.FILTER, Role.PP):
                seen.append(Memento.of(question.warehouse, self.skus))

    overrides = ["instance.orders=14", "instance.max_lines=5", "stations.item_capacity=6", *settings]
    rmfs_core.run("examples/small", overrides=overrides, out=tmp_path, record=["decisions"], observers=[Note()])
    for recorded, memento in zip(read_recording(tmp_path), seen, strict=True):
        opened = open_state(recorded.state())
        assert Memento.of(opened.view, opened.instance.skus) == memento
    assert len(seen) > 20


def without(line: dict[str, Any], key: str) -> dict[str, Any]:
    return {name: value for name, value in line.items() if name != key}


def test_a_line_holds_no_more_than_what_changed(record: Callable[..., Recording]) -> None:
    recording = record(*REPLENISHED)
    _, *lines = map(json.loads, gzip.decompress(recording.file.read_bytes()).splitlines())
    for (before, after), line in zip(pairwise(recording), lines[1:], strict=True):
        assert line["change"] == difference(before.content, after.content), line
