"""``rmfs decide``."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rmfs_commands.cli.main import main
from rmfs_commands.states import state
from rmfs_commands.states.decide_command import DECIDING

STATE = {
    "format": "rmfs-state",
    "version": 1,
    "pods": {"P1": {"contents": {"milk": None, "tea": None}}, "P2": {"contents": {"jam": None}}},
    "stations": {"north": {"item_capacity": 4}},
    "orders": {"A": {"lines": {"milk": 1, "tea": 1}}, "B": {"lines": {"jam": 2}}},
}


@pytest.fixture
def decide(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Return a function that asks for a decision: exit code, output, errors."""

    def run(*arguments: str, **changes: Any) -> tuple[int, str, str]:
        file = tmp_path / "state.json"
        file.write_text(json.dumps({**STATE, **changes}), encoding="utf-8")
        code = 0
        try:
            main(["decide", str(file), *arguments])
        except SystemExit as stop:
            code = int(stop.code or 0)
        out, err = capsys.readouterr()
        return code, out, err

    return run


def test_a_decision_as_json(decide: Any) -> None:
    """The decision, the solve's report and what it comes to are one JSON object."""
    code, out, err = decide("--rule", "split-over-time", "--set", "max_seconds=5")
    assert (code, err) == (0, "")
    written = json.loads(out)
    assert list(written) == [
        *("rule", "distribution", "version", "decides", "assignments", "trips", "report", "outcome"),
    ]
    assert written["trips"] == [{"pod": "P1", "station": "north"}, {"pod": "P2", "station": "north"}]
    assert written["outcome"] == {"orders": 2, "items": 4, "visits": 2, "unused": 0, "uncovered": 0}


def test_due_times(decide: Any) -> None:
    """The orders decided on that have a due time are told with it, and with what is left until then."""
    orders = {"A": {"lines": {"milk": 1}, "due_s": 90, "priority": 2}, "B": {"lines": {"jam": 2}, "priority": 1}}
    code, out, _ = decide("--rule", "first-come", version=2, time_s=100.5, orders=orders)
    assert code == 0
    assert json.loads(out)["due"] == {"A": {"due_s": 90.0, "priority": 2, "slack_s": -10.5}}
    code, _, err = decide("--rule", "first-come", version=1, orders=orders)
    assert code == 2
    assert "found `due_s` or `priority` in a state of version 1; expected version 2 with them" in err
    stations = {"1": {"item_capacity": 3, "requests": [], "in_hand": {"order": "1", "sku": "a"}}}
    code, _, err = decide("--rule", "first-come", version=1, stations=stations)
    assert code == 2
    assert "found `in_hand` in a state of version 1; expected version 2 with it" in err


def test_seed(decide: Any) -> None:
    """The seed may be given; a rule that draws nothing decides the same."""
    assert decide("--rule", "first-come", "--seed", "7") == decide("--rule", "first-come")


@pytest.mark.parametrize(
    ("arguments", "changes", "problem"),
    [
        (("--rule", "first-come"), {"version": 3}, "state.json, version: expected version 1 or 2"),
        (("--rule", "first-come"), {"order": {}}, "state.json, order: unknown key (did you mean `orders`?)"),
        (("--rule", "firstcome"), {}, 'there is no rule "firstcome" (did you mean `first-come`'),
        (("--rule", "integrated", "--set", "gap=-1"), {}, "gap"),
        (("--rule", "fixed"), {}, "decides PR, but the state has no layout"),
        (("--rule", "./mine.py:Mine", "--no-inline-rules"), {}, "--no-inline-rules refuses"),
        ((), {}, "Missing option '--rule'"),
    ],
)
def test_wrong_input(decide: Any, arguments: tuple[str, ...], changes: dict[str, Any], problem: str) -> None:
    """What is wrong with state or rule is one sentence; exit code 2."""
    code, out, err = decide(*arguments, **changes)
    assert (code, out) == (2, "")
    assert problem in err
    assert "Traceback" not in err


def test_a_rule_from_a_file(decide: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A rule beside the state needs no packaging."""
    source = (
        "from attrs import define\nfrom rmfs_core import hookimpl\n\n\n@define\nclass Lazy:\n"
        "    @hookimpl\n    def assign_orders(self, warehouse):\n        return []\n"
    )
    (tmp_path / "mine.py").write_text(source, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    code, out, _ = decide("--rule", "./mine.py:Lazy")
    assert code == 0
    assert json.loads(out)["assignments"] == []


@pytest.mark.parametrize(("changes", "code"), [({}, 0), ({"version": 3}, 2)])
def test_standard_input(capsys: Any, monkeypatch: pytest.MonkeyPatch, changes: dict[str, Any], code: int) -> None:
    """`-` stands for it, and messages call it so; one that is closed is empty."""
    given = io.TextIOWrapper(io.BytesIO(json.dumps({**STATE, **changes}).encode()))
    found = 0
    for stream in (given, None):
        monkeypatch.setattr("sys.stdin", stream)
        try:
            main(["decide", "-", "--rule", "first-come"])
        except SystemExit as stop:
            found = int(stop.code or 0)
        out, err = capsys.readouterr()
        if stream is None:
            assert err.startswith("Error: standard input, line 1: this is no valid JSON")
        elif code:
            assert err.startswith("Error: standard input, version: expected version 1 or 2")
        else:
            assert (found, json.loads(out)["rule"]) == (0, "first-come")
    assert found == 2


def test_what_can_be_asked() -> None:
    """The command offers what the format has."""
    assert DECIDING == state.DECIDING


def test_the_schema(capsys: pytest.CaptureFixture[str]) -> None:
    """`--schema` needs no state."""
    main(["decide", "--schema"])
    assert json.loads(capsys.readouterr().out)["title"] == "rmfs decision state"
