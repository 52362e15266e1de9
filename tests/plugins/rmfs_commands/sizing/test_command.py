"""`rmfs size` and its report."""

import csv
import json
from functools import partial
from pathlib import Path

import pytest

from calling import exit_code
from cases import cases
from rmfs_commands.cli.screen import output_console
from rmfs_commands.sizing.judging import Estimate, Verdict
from rmfs_commands.sizing.report import content_of, sentences_of, table_of, verdict_of, write_answers
from rmfs_commands.sizing.searching import Found
from rmfs_commands.sizing.sizing import Answer
from rmfs_commands.sizing.target import Target
from rmfs_commands.sizing.trials import Candidate

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


size = partial(exit_code, "size")


def test_the_answer_is_printed_and_kept(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert size("hall.toml", "--p95", "5000", *QUICK) == 0
    printed = capsys.readouterr()
    assert "Turn-over time, 95 %, at most 5,000.0 s with 95 % confidence: 2 stations with 2 robots." in printed.out
    assert printed.err.splitlines()[-1].startswith("2 stations, 2 robots: ")
    out = folder / "rmfs-runs" / "size-hall"
    assert {path.name for path in out.iterdir()} == {"runs", "answer.json", "candidates.csv"}
    before = {path: path.stat().st_mtime_ns for path in (out / "runs").rglob("*")}
    text = (out / "answer.json").read_text("utf-8")
    assert size("hall.toml", "--p95", "5000", *QUICK) == 0
    assert capsys.readouterr().out == printed.out
    assert (out / "answer.json").read_text("utf-8") == text
    assert {path: path.stat().st_mtime_ns for path in (out / "runs").rglob("*")} == before
    costs = ("--robot-cost", "2", "--station-cost", "3")
    assert size("hall.toml", "--most", "psv_per_order=99", *costs, "--json", *QUICK) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["metric"] == "psv_per_order"
    assert content["cheapest"] == {"stations": 2, "robots": 2, "cost": 10}


def test_packers_and_boxes_are_sized(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One packer has 150 orders of more than 35 s an hour."""
    asked = ("--packers", "1-2", "--boxes", "1-3", "--seeds", "2", "--jobs", "1", "--set", "packing.conveyor_s=20")
    costs = ("--robot-cost", "2", "--station-cost", "3", "--set", "rules.poa_pps=pod-index")
    without = ("--set", "rules.poa=", "--set", "rules.pps=")
    assert size("hall.toml", "--p95", "5000", *asked, *costs, *without, "--json") == 0
    printed = capsys.readouterr()
    assert printed.err.splitlines()[0].startswith("2 packers, 3 boxes: ")
    content = json.loads(printed.out)
    assert content["metric"] == "packed_p95_s"
    assert [row["boxes"] for row in content["packers"]] == [None, 1]
    assert "keep each packer busy for 1" in content["packers"][0]["reason"]
    assert content["cheapest"] == {"packers": 2, "boxes": 1, "cost": 8}
    assert "Packers and boxes are those of each packing station." in content["notes"]


def test_with_costs_the_cheapest_size_is_sought_beside_the_fewest_robots(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    prices = ("--set", "costs={picker_per_h=60, robot_per_h=1}", "--set", "instance.arrivals={process='start'}")
    asked = ("--stations", "2", "--robots", "1-6", "--seeds", "2", "--jobs", "1", "--json")
    assert size("hall.toml", "--most", "turnover_s=5000", *asked, *prices) == 0
    content = json.loads(capsys.readouterr().out)
    costs = {row["robots"]: row["cost_per_order"] for row in content["candidates"]}
    best = content["least_per_order"]["robots"]
    assert content["frontier"][0]["robots"] == 1 < best  # with more robots people go home earlier
    assert costs[best] == min(costs.values()) == content["least_per_order"]["cost_per_order"]
    assert {best - 1, min(best + 1, 6)} <= costs.keys()
    assert f"an order costs least with 2 stations with {best} robots: {costs[best]:,.4f}" in content["notes"][1]
    table = (folder / "rmfs-runs" / "size-hall" / "candidates.csv").read_text("utf-8")
    assert table.splitlines()[0].endswith(",reason,cost_per_order")


def test_a_run_that_fails_ends_with_code_1(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    failing = ("--set", "rules.pr=./failing.py:Failing", "--out", "out")
    assert size("hall.toml", "--mean", "5000", *failing, *QUICK) == 1
    printed = capsys.readouterr()
    assert "Loading code from failing.py." in printed.err
    assert "2 runs failed; out/answer.json says why." in printed.err
    assert "out of ideas" in (folder / "out" / "candidates.csv").read_text("utf-8")
    assert size("hall.toml", "--mean", "5000", "--no-inline-rules", *failing, *QUICK) == 2


@cases(
    "arguments sentence",
    ((), "expected one of --p95, --mean and --most"),
    (("--p95", "900", "--mean", "300"), "expected one of --p95, --mean and --most"),
    (("--p95", "0"), "expected a number > 0, found 0"),
    (("--p95", "inf"), "expected a number, as in --p95 900"),
    (("--most", "late_percent"), "expected a number, as in --p95 900 or --most late_percent=2"),
    (("--most", "late_percent=few"), "found late_percent=few"),
    (
        ("--most", "late_percnt=2", *QUICK),
        '--most late_percnt=2: there is no metric "late_percnt" (did you mean `late_percent`',
    ),
    (("--p95", "900", "--robots", "0-4"), "expected a number from 1 on, or two such as 2-6, found 0-4"),
    (("--p95", "900", "--stations", "5-2"), "or two such as 2-6, found 5-2"),
    (("--p95", "900", "--stations", "2-9999"), "--stations: found 9,999; expected 200 at most"),
    (("--p95", "900", "--robots", "1-999"), "found 999; the layout has"),
    (("--p95", "900", "--robot-cost", "3"), "--robot-cost and --station-cost together, or neither"),
    (("--p95", "900", "--set", "instance.pods=1000"), "1000 pods, but the layout has"),
    (("--p95", "900", "--boxes", "4"), "--packers, --boxes: the scenario has no packing stations; expected one with a"),
    (("--p95", "900", "--boxes", "4", "--robots", "4"), "expected --stations and --robots, or --packers and --boxes"),
    (
        ("--p95", "9", "--boxes", "999999", "--set", "packing.boxes=1"),
        "--boxes: found 999,999; expected 100,000 at",
    ),
)
def test_wrong_input_is_one_sentence(
    arguments: tuple[str, ...], sentence: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert size("hall.toml", *arguments) == 2
    err = capsys.readouterr().err
    assert sentence in err
    assert "Traceback" not in err


TARGET = Target("turnover_p95_s", 900, seeds=(1, 2, 3, 4))
PASSES = Candidate(2, 9, Verdict.PASSES, 4, Estimate(612.34, 500, 700))
UNDECIDED = Candidate(2, 8, Verdict.UNDECIDED, 4, Estimate(880, 700, 1060))
PARTIAL = Candidate(3, 8, Verdict.FAILS, 4, None, "seed 3 ends with orders left")
ANSWER = Answer(
    "hall",
    TARGET,
    (Found(1, None, "too busy"), Found(2, 9), Found(3, None, "saves no robot")),
    (PASSES,),
    (UNDECIDED, PASSES, PARTIAL),
    at_once=False,
)


def test_the_table_has_every_size(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    output_console().print(table_of(ANSWER))
    rows = [line.split(maxsplit=6) for line in capsys.readouterr().out.splitlines()]
    assert rows[0] == ["Turn-over", "time,", "95", "%,", "at", "most", "900.0 s"]
    assert rows[2] == ["Stations", "Robots", "Mean", "Interval", "Seeds", "Verdict"]
    assert rows[4:9] == [
        ["1", "too", "busy"],
        ["2", "8", "880.0", "[700.0,", "1,060.0]", "4", "undecided"],
        ["2", "9", "612.3", "[500.0,", "700.0]", "4", "passes, fewest"],
        ["3", "8", "4", "fails:", "seed", "3", "ends with orders left"],
        ["3", "saves", "no", "robot"],
    ]


@cases(
    "candidate words",
    (PASSES, "612.3 [500.0, 700.0], 4 seeds, passes"),
    (PARTIAL, "4 seeds, fails: seed 3 ends with orders left"),
    (Candidate(1, 1, Verdict.FAILS, reason="it is 912.0 s or more"), "fails: it is 912.0 s or more"),
)
def test_a_verdict_in_words(candidate: Candidate, words: str) -> None:
    assert verdict_of(candidate, TARGET) == words


def test_the_answer_in_one_sentence() -> None:
    assert list(sentences_of(ANSWER, (1, 10))) == [
        "Turn-over time, 95 %, at most 900.0 s with 95 % confidence: 2 stations with 9 robots.",
        "The cheapest of these costs 29: 2 stations with 9 robots.",
        "Undecided after 4 seeds: 2 with 8; more --seeds may tell.",
    ]
    nothing = Answer("hall", TARGET, (Found(1, None, "too busy"),), (), (), at_once=True)
    none, backlog = sentences_of(nothing, (1, 10))
    assert none.endswith("none of the sizes is shown to be enough.")
    assert backlog.startswith("All orders are there at once")


def test_files_have_the_same(tmp_path: Path) -> None:
    write_answers([ANSWER], (1, 10), tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"answer.json", "candidates.csv"}
    with (tmp_path / "candidates.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["stations"], row["robots"], row["mean"], row["fewest"]) for row in rows] == [
        ("2", "8", "880", "false"),
        ("2", "9", "612.34", "true"),
        ("3", "8", "", "false"),
    ]
    content = json.loads((tmp_path / "answer.json").read_text("utf-8"))
    assert content == content_of(ANSWER, (1, 10))
    assert content["cheapest"] == {"stations": 2, "robots": 9, "cost": 29}
    assert [one["robots"] for one in content["frontier"]] == [9]
    assert [one["reason"] for one in content["stations"]] == ["too busy", None, "saves no robot"]
    assert "cheapest" not in content_of(ANSWER, None)
