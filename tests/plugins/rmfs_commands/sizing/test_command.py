"""`rmfs size` as a person uses it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rmfs_commands.cli.main import main

QUICK = ("--stations", "2", "--robots", "2", "--seeds", "2", "--jobs", "1")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, poisson_text: str) -> Path:
    """Return the current folder, with a scenario and a rule that fails."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    (tmp_path / "hall.toml").write_text(poisson_text, encoding="utf-8")
    (tmp_path / "failing.py").write_text(
        "import attrs\nfrom rmfs_core import hookimpl\n\n@attrs.define\nclass Failing:\n    @hookimpl\n"
        "    def choose_storage_location(self, warehouse, pod):\n        raise ValueError('out of ideas')\n",
        encoding="utf-8",
    )
    return tmp_path


def code_of(*arguments: str) -> int:
    """Return the exit code of a command line."""
    try:
        main(["size", *arguments])
    except SystemExit as stop:
        return int(stop.code or 0)
    return 0


def test_the_answer_is_printed_and_kept(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A table, a sentence, files; the same command again computes nothing, and says and writes the same."""
    assert code_of("hall.toml", "--p95", "5000", *QUICK) == 0
    printed = capsys.readouterr()
    assert "Turn-over time, 95 %, at most 5,000.0 s with 95 % confidence: 2 stations with 2 robots." in printed.out
    assert printed.err.splitlines()[-1].startswith("2 stations, 2 robots: ")
    out = folder / "rmfs-runs" / "size-hall"
    assert {path.name for path in out.iterdir()} == {"runs", "answer.json", "candidates.csv"}
    before = {path: path.stat().st_mtime_ns for path in (out / "runs").rglob("*")}
    text = (out / "answer.json").read_text("utf-8")
    assert code_of("hall.toml", "--p95", "5000", *QUICK) == 0
    assert capsys.readouterr().out == printed.out
    assert (out / "answer.json").read_text("utf-8") == text
    assert {path: path.stat().st_mtime_ns for path in (out / "runs").rglob("*")} == before
    costs = ("--robot-cost", "2", "--station-cost", "3")
    assert code_of("hall.toml", "--most", "psv_per_order=99", *costs, "--json", *QUICK) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["metric"] == "psv_per_order"
    assert content["cheapest"] == {"stations": 2, "robots": 2, "cost": 10}


def test_a_run_that_fails_ends_with_code_1(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The answer is written all the same."""
    failing = ("--set", "rules.pr=./failing.py:Failing", "--out", "out")
    assert code_of("hall.toml", "--mean", "5000", *failing, *QUICK) == 1
    printed = capsys.readouterr()
    assert "Loading code from failing.py." in printed.err
    assert "2 runs failed; out/candidates.csv says why." in printed.err
    assert "out of ideas" in (folder / "out" / "candidates.csv").read_text("utf-8")
    assert code_of("hall.toml", "--mean", "5000", "--no-inline-rules", *failing, *QUICK) == 2


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((), "expected one of --p95, --mean and --most"),
        (("--p95", "900", "--mean", "300"), "expected one of --p95, --mean and --most"),
        (("--p95", "0"), "expected a number > 0, found 0"),
        (("--p95", "3x"), "expected a number > 0, found 3x"),
        (
            ("--most", "late=2", *QUICK),
            '--most late=2: there is no metric "late" (did you mean',
        ),
        (("--most", "late_percent=-2"), "`late_percent` is never below 0; expected a number >= 0"),
        (("--p95", "inf"), "expected a number, as in --p95 900"),
        (("--p95", "nan"), "nan"),
        (("--most", "late_percent"), "expected a number, as in --p95 900 or --most late_percent=2"),
        (("--most", "late_percent=few"), "found late_percent=few"),
        (
            ("--most", "late_percnt=2", *QUICK),
            '--most late_percnt=2: there is no metric "late_percnt" (did you mean `late_percent`',
        ),
        (
            ("--most", "late_percent=2", *QUICK),
            "--most late_percent=2: these runs have no `late_percent`: no order has a due time; expected one that",
        ),
        (
            ("--most", "pile_on=2", *QUICK),
            "--most pile_on=2: more of `pile_on` is better; expected one of which less is better, such as ",
        ),
        (("--most", "picks=9", *QUICK), "--most picks=9: `picks` is the same for every number of robots; expected"),
        (
            ("--most", "stock_outs=2", *QUICK),
            "--most stock_outs=2: these runs have no `stock_outs`: nothing in them measures it; expected one that",
        ),
        (("--p95", "900", "--robots", "0-4"), "expected a number from 1 on, or two such as 2-6, found 0-4"),
        (("--p95", "900", "--stations", "5-2"), "or two such as 2-6, found 5-2"),
        (("--p95", "900", "--stations", "2-9999"), "--stations: found 9,999; expected 200 at most"),
        (("--p95", "900", "--robots", "1-999"), "found 999; the layout has"),
        (("--p95", "900", "--robot-cost", "3"), "--robot-cost and --station-cost together, or neither"),
        (("--p95", "900", "--set", "instance.pods=1000"), "1000 pods, but the layout has"),
    ],
)
def test_wrong_input_is_one_sentence(
    arguments: tuple[str, ...], sentence: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 2, what is wrong where, and no traceback."""
    assert code_of("hall.toml", *arguments) == 2
    err = capsys.readouterr().err
    assert sentence in err
    assert "Traceback" not in err
