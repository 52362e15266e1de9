"""The answer for people and as files, without a run."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from rmfs_commands.cli.screen import output_console
from rmfs_commands.sizing.judging import Estimate, Verdict
from rmfs_commands.sizing.report import content_of, sentences_of, table_of, verdict_of, write_answer
from rmfs_commands.sizing.searching import Found
from rmfs_commands.sizing.sizing import Answer
from rmfs_commands.sizing.target import Target
from rmfs_commands.sizing.trials import Candidate

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
    """Its mean, interval, seeds and verdict; and numbers of stations that have none with the reason."""
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


@pytest.mark.parametrize(
    ("candidate", "words"),
    [
        (PASSES, "612.3 [500.0, 700.0], 4 seeds, passes"),
        (PARTIAL, "4 seeds, fails: seed 3 ends with orders left"),
        (Candidate(1, 1, Verdict.FAILS, reason="it is 912.0 s or more"), "fails: it is 912.0 s or more"),
    ],
)
def test_a_verdict_in_words(candidate: Candidate, words: str) -> None:
    """With the figures that there are."""
    assert verdict_of(candidate, TARGET) == words


def test_the_answer_in_one_sentence() -> None:
    """What is enough, what may be, and what is cheapest."""
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
    """A row for every size that was judged; JSON has the rest, too."""
    write_answer(ANSWER, (1, 10), tmp_path)
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
