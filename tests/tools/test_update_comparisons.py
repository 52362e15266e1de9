"""tools/update_comparisons.py: from comparisons to docs/paper/league and docs/paper/study."""

from __future__ import annotations

import csv
import runpy
from pathlib import Path

TOOL = runpy.run_path(str(Path(__file__).resolve().parents[2] / "tools" / "update_comparisons.py"))
FIGURES = {"good": (0.1, 10.0), "dear": (0.2, 5.0), "bad": (0.3, 20.0)}
"""Visits, and what all other figures are, by rule set; and one that was never done."""


def written(folder: Path) -> Path:
    """Return the folder of a comparison."""
    (folder / "plots").mkdir(parents=True)
    for name in ("psv_per_order", "distance_per_order_m"):
        (folder / "plots" / f"front.{name}.turnover_s.png").write_bytes(name.encode())
    columns = ("instances", "metric", "rule_set", "mean", "times_bound", "runs", "complete")
    with (folder / "summary.csv").open("w", encoding="utf-8", newline="") as stream:
        rows = csv.writer(stream)
        rows.writerow(columns)
        for instances in ("scenario=small", "overall"):
            for metric in TOOL["COLUMNS"]:
                for rule_set, (visits, other) in FIGURES.items():
                    mean = visits if metric == "psv_per_order" else other
                    rows.writerow((instances, metric, rule_set, mean, 1.5, 3, 3))
                rows.writerow((instances, metric, "never", "", "", 3, 1))
    return folder


def test_a_table_for_each_instance_set(tmp_path: Path) -> None:
    """Fewest visits first; whom none beats in two figures is on a front; what was not done is counted."""
    league = tmp_path / "league"
    TOOL["update"](written(tmp_path / "all"), tmp_path)
    lines = (league / "all.md").read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if line.startswith("#")] == ["### small"]
    assert [line.split(" | ") for line in lines[-4:]] == [
        ["| good", "0.100", "10.0", "10", "10", "10", "1.50", "1.50", "0", "visits |"],
        ["| dear", "0.200", "5.0", "5", "5", "5", "1.50", "1.50", "0", "visits, metres |"],
        ["| bad", "0.300", "20.0", "20", "20", "20", "1.50", "1.50", "0", " |"],
        ["| never", *"-----", "-", "-", "2", " |"],
    ]
    pictures = {path.name: path.read_bytes() for path in league.glob("*.png")}
    assert pictures == {
        "all-psv_per_order-turnover_s.png": b"psv_per_order",
        "all-distance_per_order_m-turnover_s.png": b"distance_per_order_m",
    }


def test_a_study_says_what_rule_sets_change(tmp_path: Path) -> None:
    """Against the baseline, with intervals; and by metric, where there is more than one instance set."""
    folder = tmp_path / "rules"
    folder.mkdir()
    columns = ("instances", "metric", "rule_set", "baseline", "mean", "runs", "relative", "low", "high")
    with (folder / "summary.csv").open("w", encoding="utf-8", newline="") as stream:
        rows = csv.writer(stream)
        rows.writerow(column if column not in ("low", "high") else f"relative_{column}_holm" for column in columns)
        for instances in ("robots=8", "robots=16", "overall"):
            rows.writerow((instances, "turnover_s", "plain", "plain", 900.2, 5, "", "", ""))
            rows.writerow((instances, "turnover_s", "clever", "plain", 800.2, 5, -0.111, -0.2, 0.004))
    TOOL["update"](folder, tmp_path)
    assert (tmp_path / "study" / "rules.md").read_text(encoding="utf-8").replace("\u00a0", " ").splitlines() == [
        "### Against plain, 5 runs each",
        "",
        "| Rule set | Turn-over |",
        "| --- | ---: |",
        "| clever | -11 % [-20, +0] |",
        "",
        "### Turn-over (s)",
        "",
        "|  | plain | clever |",
        "| --- | ---: | ---: |",
        "| 8 | 900 | -11 % [-20, +0] |",
        "| 16 | 900 | -11 % [-20, +0] |",
    ]


def test_other_folders_are_refused(tmp_path: Path, monkeypatch, capsys) -> None:
    """One sentence, exit code 2."""
    monkeypatch.setattr("sys.argv", ["update_comparisons.py", str(tmp_path)])
    assert TOOL["main"]() == 2
    assert "expected folders that" in capsys.readouterr().err
