import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from calling import exit_code
from cases import cases
from installed import RMFS
from rmfs_commands.cli.main import main
from rmfs_commands.states import read_recording


@pytest.fixture
def decide(write: Any, by_hand: Any, capsys: Any) -> Callable[..., tuple[int, str, str]]:

    def run(*arguments: str, **changes: Any) -> tuple[int, str, str]:
        code = exit_code("decide", str(write(by_hand | changes)), *arguments)
        out, err = capsys.readouterr()
        return code, out, err

    return run


def test_a_decision_as_json(decide: Any) -> None:
    code, out, err = decide("--rule", "split-over-time", "--set", "max_seconds=5")
    assert (code, err) == (0, "")
    written = json.loads(out)
    assert list(written) == [
        *("rule", "distribution", "version", "decides", "assignments", "trips", "report", "outcome")
    ]
    assert written["trips"] == [{"pod": "P1", "station": "north"}, {"pod": "P2", "station": "north"}]
    assert written["outcome"] == {"orders": 2, "items": 4, "visits": 2, "unused": 0, "uncovered": 0}
    assert decide("--rule", "first-come", "--seed", "7") == decide("--rule", "first-come")


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


@cases(
    "arguments changes problem",
    (("--rule", "first-come"), {"version": 3}, "state.json, version: expected version 1 or 2"),
    (("--rule", "first-come"), {"order": {}}, "state.json, order: unknown key (did you mean `orders`?)"),
    (("--rule", "firstcome"), {}, 'there is no rule "firstcome" (did you mean `first-come`'),
    (("--rule", "integrated", "--set", "gap=-1"), {}, "gap"),
    (("--rule", "fixed"), {}, "decides PR, but the state has no layout"),
    (("--rule", "./mine.py:Mine", "--no-inline-rules"), {}, "--no-inline-rules refuses"),
    ((), {}, "Missing option '--rule'"),
)
def test_wrong_input(decide: Any, arguments: tuple[str, ...], changes: dict[str, Any], problem: str) -> None:
    code, out, err = decide(*arguments, **changes)
    assert (code, out) == (2, "")
    assert problem in err
    assert "Traceback" not in err


@pytest.mark.parametrize(("changes", "code"), [({}, 0), ({"version": 3}, 2)])
def test_standard_input(by_hand: Any, capsys: Any, monkeypatch: Any, changes: dict[str, Any], code: int) -> None:
    given = io.TextIOWrapper(io.BytesIO(json.dumps(by_hand | changes).encode()))
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


def test_what_can_be_asked(capsys: pytest.CaptureFixture[str]) -> None:
    main(["decide", "--schema"])
    assert json.loads(capsys.readouterr().out)["title"] == "rmfs decision state"


JOINT = ("rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time")


@pytest.fixture
def sequential(record: Any) -> str:
    return str(record().file.parent)


@pytest.fixture
def joint(record: Any) -> str:
    return str(record(*JOINT).file.parent)


def explain(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = exit_code("explain", *arguments)
    out, err = capsys.readouterr()
    return code, "\n".join(" ".join(line.split()) for line in out.splitlines()), " ".join(err.split())


def test_what_was_decided(sequential: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = explain(capsys, sequential)
    assert code == 0
    for words in ("POA pod-match", "PPS demand", "PR nearest", "TA nearest-robot", "Periods 1 to"):
        assert words in out
    code, out, _ = explain(capsys, sequential, "--period", "1", "--limit", "3")
    assert code == 0
    assert "Decision 1: POA by pod-match, period 1, at 0.000 s" in out
    assert "1 6 of 6 items 0 0 13 -" in out
    assert "Backlog: 14 orders" in out
    assert "more orders; --limit shows more" in out
    assert "Pods selected in this period" in out


def test_other_rules_than_those_recorded(joint: str, capsys: pytest.CaptureFixture[str], sequential: str) -> None:
    against = ("--against", "integrated", "--against", "first-come", "--against", "pod-match + demand")
    code, out, _ = explain(capsys, joint, "--period", "1", *against)
    assert code == 0
    assert "Model: optimal, objective" in out
    lines = out.splitlines()
    *_, objective, _, bound = figures_of("split-over-time (decided)", lines)
    assert objective == bound
    assert sum(line.startswith("integrated") for line in lines) == 2
    assert sum(line.startswith("pod-match + demand") for line in lines) == 2
    assert figures_of("first-come", lines)[4] == "-"  # no pods are sent, so nothing is covered
    for period in (2, 3, 4):
        code, out, err = explain(capsys, sequential, "--period", str(period), "--against", "split-over-time")
        assert (code, err) == (0, "")
        assert "\nsplit-over-time " in out


def figures_of(rule: str, lines: list[str]) -> list[str]:
    """Return the figures of a rule, which stand below its name where names are too long for 80 columns."""
    return lines[lines.index(rule) + 1].split()


def test_a_state_goes_round(joint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "state.json"
    code, out, _ = explain(capsys, joint, "--period", "2", "--state", str(file))
    assert code == 0
    assert f"State written to {file}" in out
    main(["decide", str(file), "--rule", "split-over-time"])
    again = json.loads(capsys.readouterr().out)
    recorded = next(r for r in read_recording(joint) if r.period == 2)
    assert recorded.decision == {key: again[key] for key in ("assignments", "trips")}


def test_stories_of_orders_and_pods(sequential: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = explain(capsys, sequential, "--order", "14")
    assert code == 0
    assert "What was decided for order 14" in out
    assert "assigned to station" in out
    sent = next(line for line in out.splitlines() if " sent to station " in line and "pod " in line)
    pod = sent.split("pod ")[1].split()[0]
    code, out, _ = explain(capsys, sequential, "--pod", pod)
    assert code == 0
    assert "fetches it" in out
    told = [explain(capsys, sequential, "--pod", str(pod))[1] for pod in range(1, 31)]
    assert any("no decision concerned it" in out for out in told)
    code, _, err = explain(capsys, "a" * 300)
    assert (code, err) == (2, f"Error: {'a' * 300}: cannot be read: File name too long")


@cases(
    "arguments problem",
    (("--period", "9999"), "there is none; the run has periods 1 to"),
    (("--decision", "9999"), "there is none; the run has decisions 1 to"),
    (("--order", "15"), "the run has no order of that name"),
    (("--order", "x"), "no order of that name; expected one such as 1, 2, 3, 4, 5 and 9 more"),
    (("--pod", "300"), "did you mean `30`"),
    (("--pod", "3", "--order", "3"), "exclude each other"),
    (("--against", "demand"), "need --period or --decision"),
    (("--order", "3", "--state", "x.json"), "need --period or --decision"),
    (
        ("--period", "1", "--against", "demand"),
        f'--against demand: rule "demand" ({RMFS}) decides PPS; expected a rule for POA or POA+PPS',
    ),
    (("--period", "1", "--against", "first-come+demand+nearest"), "--against first-come+demand+nearest: found 3 rules"),
    (("--period", "1", "--against", "./a.py:A", "--no-inline-rules"), "--no-inline-rules refuses"),
)
def test_what_cannot_be_explained_is_refused(sequential, capsys, arguments, problem) -> None:
    code, out, err = explain(capsys, sequential, *arguments)
    assert (code, out) == (2, "")
    assert problem in err


@cases(
    "change",
    lambda first: first | {"decision": {"assignments": [{"order": "1"}]}},
    lambda first: first | {"change": first["change"] | {"seed": -1}},
    lambda first: first | {"change": first["change"] | {"time_s": 1e308}},
)
def test_a_recording_that_was_changed(change: Any, damaged: Any, tmp_path: Path, capsys: Any) -> None:
    """One sentence for a decision, or a state, that rmfs cannot have recorded; no state is written then."""
    folder = damaged(lambda lines: [lines[0], change(lines[1]), *lines[2:]])
    code, _, err = explain(capsys, str(folder), "--decision", "1", "--state", str(tmp_path / "state.json"))
    assert code == 2
    assert err.startswith(f"Error: {folder}/decisions.jsonl.gz")
    assert "raised" not in err
    assert not (tmp_path / "state.json").exists()


def test_runs_without_decisions(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = explain(capsys, str(tmp_path), "--period", "1")
    assert code == 2
    assert "found no recorded decisions; run the scenario with `--record-decisions`" in err
    main(["run", "examples/small", "--record-decisions", "--out", str(tmp_path), "--set", "instance.orders=6"])
    assert "decisions.jsonl.gz" in capsys.readouterr().out
    assert explain(capsys, str(tmp_path))[0] == 0


def test_json(sequential: str, joint: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Counts, a decision with what other rules would have decided, and stories: all that the tables tell."""
    counted = plain(capsys, sequential)
    assert sum(row["decisions"] for row in counted["by_rule"]) == counted["decisions"]
    decision = plain(capsys, joint, "--period", "1", "--against", "integrated")
    assert (decision["number"], decision["decides"], decision["rule"]) == (1, "POA+PPS", "split-over-time")
    assert decision["outcome"]["orders"] > 0
    assert [(one["rule"], one["report"]["status"]) for one in decision["against"]] == [("integrated", "optimal")]
    assert all(one["decides"] == "PPS" for one in plain(capsys, sequential, "--period", "1")["then"])
    story = plain(capsys, sequential, "--order", "14")
    assert story["order"] == "14"
    assert any("assigned to station" in episode["what"] for episode in story["episodes"])


def plain(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    main(["explain", *arguments, "--json"])
    return json.loads(capsys.readouterr().out)


def test_due_times_and_nothing_are_shown(record: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    due = ("instance.due.allowance_s=600", "instance.due.priority_share=0.5", "instance.due.priority_allowance_s=60")
    code, out, _ = explain(capsys, str(record(*due).file.parent), "--decision", "1")
    assert code == 0
    assert "Order Waits Due in Priority Open lines (SKUs)" in out
    assert "0 s 60 s 1" in out
    assert "0 s 600 s 0" in out
    early = ["run", "examples/poisson", "--set", "run.until_s=0.001", "--out", str(tmp_path / "run")]
    main([*early, "--quiet", "--record-decisions"])
    for option in ("period", "decision"):
        code, _, problem = explain(capsys, str(tmp_path / "run"), f"--{option}", "1")
        assert (code, problem) == (2, f"Error: --{option} 1: there is none; the run has no {option}")
