"""Recording a run's decisions, and reading them again."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from rmfs_commands.states import decide, read_recording
from rmfs_commands.states.rebuilding import open_state
from rmfs_commands.states.recording import RECORDING_FILE as DECISIONS_FILE
from rmfs_core import InputError, RuleError
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice

SETTINGS = ("instance.orders=6", "rules.pp=free-flow")
RULES = """
@define
class Late:
    "POA: first come, until five orders are left."

    @hookimpl
    def assign_orders(self, warehouse):
        if len(warehouse.backlog) <= 5:
            return [OrderAssignment(99, 0)]
        return [OrderAssignment(warehouse.backlog[0].id, 0)]


@define
class Raising:
    "POA: raises."

    @hookimpl
    def assign_orders(self, warehouse):
        raise ZeroDivisionError("nothing to divide")
"""


def test_nothing_else_changes(tmp_path: Path) -> None:
    """A run is the same whether its decisions are recorded or not, and equal runs are recorded in equal bytes."""
    files = ("orders.csv", "visits.csv")
    plain = rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path / "plain")
    for name in ("one", "two"):
        result = rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path / name, record=["decisions"])
        assert result.metrics == plain.metrics
    for file in files:
        assert (tmp_path / "plain" / file).read_bytes() == (tmp_path / "one" / file).read_bytes()
    assert (tmp_path / "one" / DECISIONS_FILE).read_bytes() == (tmp_path / "two" / DECISIONS_FILE).read_bytes()
    assert not (tmp_path / "plain" / DECISIONS_FILE).exists()


def test_every_decision_is_there(tmp_path: Path) -> None:
    """Each row of periods.csv has its recorded decision, with the same numbers."""
    result = rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path, record=["decisions"])
    recorded = [r for r in read_recording(tmp_path) if r.decides in (Role.POA, Role.PPS)]
    assert [(r.period, r.time_s, r.decides.label, r.rule) for r in recorded] == [
        (row["period"], row["time_s"], row["decides"], row["rule"]) for row in result.periods
    ]
    for decision, row in zip(recorded, result.periods, strict=True):
        assert decision.decision is not None
        assert len(decision.decision.get("assignments", ())) == row["assignments"]
        assert len(decision.decision.get("trips", ())) == row["trips"]


def test_decisions_of_an_earlier_run_go(tmp_path: Path) -> None:
    """A run without recording leaves none of another run's decisions in its folder."""
    rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path, record=["decisions"])
    rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path)
    with pytest.raises(InputError, match="run the scenario with `--record-decisions`"):
        read_recording(tmp_path)


def test_recording_needs_a_folder() -> None:
    """Without `out` there is nowhere to record to."""
    with pytest.raises(InputError, match=r"decisions: .* expected `out`"):
        rmfs_core.run("examples/small", record=["decisions"])


@pytest.mark.parametrize(("rule", "problem"), [("late", "named order 99"), ("raising", "nothing to divide")])
def test_what_a_failing_rule_saw_is_kept(tmp_path: Path, install: Any, rule: str, problem: str) -> None:
    """The last recorded state is the one in which the rule failed: asked again there, it fails again."""
    install(
        "acme",
        {"late": "acme_rules:Late", "raising": "acme_rules:Raising"},
        acme_rules=f"from rmfs_core import OrderAssignment\n{RULES}",
    )
    with pytest.raises(RuleError, match=problem):
        rmfs_core.run("examples/small", overrides=[*SETTINGS, f"rules.poa={rule}"], out=tmp_path, record=["decisions"])
    *_, last = read_recording(tmp_path)
    assert (last.decides, last.decision) == (Role.POA, None)
    with pytest.raises(RuleError, match=problem):
        decide(last.state(), RuleChoice(rule))


@pytest.fixture
def recorded_file(tmp_path: Path) -> Path:
    """Return the file of a recorded run."""
    rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path, record=["decisions"])
    return tmp_path / DECISIONS_FILE


def change(file: Path, number: int, entry: dict[str, Any]) -> None:
    """Change keys of a line of a recording; a value of None takes the key out."""
    lines = gzip.decompress(file.read_bytes()).decode().splitlines()
    content = {**json.loads(lines[number]), **entry}
    lines[number] = json.dumps({key: value for key, value in content.items() if value is not None})
    file.write_bytes(gzip.compress("\n".join(lines).encode()))


@pytest.mark.parametrize(
    ("number", "entry", "problem"),
    [
        (0, {"format": "rmfs-trace"}, "line 1, format: expected 'rmfs-decisions', found 'rmfs-trace'"),
        (0, {"version": 9}, "line 1, version: expected version 1 of 'rmfs-decisions', found 9"),
        (0, {"state": None}, "line 1: the header lacks"),
        (0, {"scenario": {"rules": {}}}, "line 1, scenario"),
        (1, {"change": None}, "line 2: this is no recorded decision: it lacks change"),
        (1, {"change": 3}, "line 2, change: expected a JSON object, found 3"),
        (1, {"decides": "PP"}, "line 2: found PP of period 1"),
    ],
)
def test_damaged_recordings(recorded_file: Path, number: int, entry: dict[str, Any], problem: str) -> None:
    """What is no recording, of another version, or lacks something, is refused with the line."""
    change(recorded_file, number, entry)
    with pytest.raises(InputError, match=problem):
        list(read_recording(recorded_file))


def test_a_recording_that_was_cut_off(recorded_file: Path) -> None:
    """A file that ends in the middle is refused where it ends."""
    recorded_file.write_bytes(recorded_file.read_bytes()[:-40])
    with pytest.raises(InputError, match="the file was cut off here"):
        list(read_recording(recorded_file))


def test_a_rule_that_the_scenario_does_not_name(recorded_file: Path) -> None:
    """The rule that decided, with its parameters, is the scenario's; a file that disagrees is refused."""
    recording = read_recording(recorded_file)
    first = next(iter(recording))
    assert recording.choice_of(first).rule == first.rule == "pod-match"
    change(recorded_file, 1, {"decides": "POA+PPS"})
    with pytest.raises(InputError, match=r"has no rule for POA\+PPS"):
        recording.choice_of(next(iter(recording)))


def test_what_is_in_hand_is_recorded(tmp_path: Path) -> None:
    """States with an item in hand are of version 2, others of version 1; the rule sees the same room again."""
    settings = (*SETTINGS, "stations.release=handled")
    rmfs_core.run("examples/small", overrides=settings, out=tmp_path, record=["decisions"])
    states = [recorded.state() for recorded in read_recording(tmp_path)]
    held = [(state, name) for state in states for name, station in state.stations.items() if station.in_hand]
    assert {state.version for state, _ in held} == {2}
    assert {state.version for state in states if not any(s.in_hand for s in state.stations.values())} == {1}
    for state, name in held:
        opened = open_state(state)
        station = opened.warehouse.stations[list(state.stations).index(name)]
        in_hand = state.stations[name].in_hand
        assert in_hand is not None
        assert opened.warehouse.orders[opened.names.orders[in_hand.order]].has_place_at(station.id)


def test_due_times_are_recorded(tmp_path: Path) -> None:
    """States with due times are of version 2, others of version 1; the rule sees the same again."""
    due = ("instance.due.allowance_s=600", "instance.due.priority_share=0.5", "instance.due.priority_allowance_s=60")
    versions = {}
    for name, settings in (("plain", SETTINGS), ("due", (*SETTINGS, *due))):
        rmfs_core.run("examples/small", overrides=settings, out=tmp_path / name, record=["decisions"])
        state = next(iter(read_recording(tmp_path / name))).state()
        versions[name] = state.version
    assert versions == {"plain": 1, "due": 2}
    assert len(state.orders) == 6
    assert {(order.due_s, order.priority) for order in state.orders.values()} == {(600.0, 0), (60.0, 1)}
