"""tools/update_results.py: from a report to README.md and results/."""

import runpy
from pathlib import Path

import pytest

TOOL = runpy.run_path(str(Path(__file__).resolve().parents[2] / "tools" / "update_results.py"))
REPORT = """# Title

- Command: `rmfs reproduce`
- Time: 40 min

## Overview

| a | b |
|---|---|
| 1 | 2 |

## Runs

| c |
|---|
| 3 |

## Figure 10: visits

The paper: fewer.

| d |
|---|
| 4 |

![Visits](visits.png)

## Figure 11: distances

| e |
|---|
| 5 |
"""
README = "# rmfs\n\n## Results\n\n" + TOOL["BEGIN"] + "old\n" + TOOL["END"] + "\n\n## Next\n"


def test_the_readme_shows_facts_overview_and_plots_and_folds_the_rest() -> None:
    """Nothing of the report is lost, nothing of the README but what was between the marks."""
    text = TOOL["updated"](README, REPORT)
    shown, folded = text.split("<details>")
    assert shown.startswith("# rmfs\n\n## Results\n") and text.endswith("\n\n## Next\n")
    assert "- Time: 40 min" in shown and "### Overview" in shown and "### Runs" in shown and "| 3 |" in shown
    assert "![Visits](results/visits.png)" in shown and "![Visits]" not in folded
    assert "All 2 tables" in folded and "The paper: fewer." in folded and "| 4 |" in folded and "| 5 |" in folded
    assert "old" not in text and "# Title" not in text


def test_updating_twice_changes_nothing() -> None:
    """The marks stay."""
    once = TOOL["updated"](README, REPORT)
    assert TOOL["updated"](once, REPORT) == once


def test_files_of_an_earlier_report_go(tmp_path: Path) -> None:
    """results/ has the report and its plots, and no picture that no text shows."""
    source = tmp_path / "out"
    source.mkdir()
    (source / "report.md").write_text(REPORT)
    (source / "visits.png").write_bytes(b"new")
    (tmp_path / "README.md").write_text(README)
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "old.png").write_bytes(b"old")
    TOOL["update"](tmp_path, source)
    assert sorted(path.name for path in (tmp_path / "results").iterdir()) == ["report.md", "visits.png"]
    assert "Time: 40 min" in (tmp_path / "README.md").read_text()


def test_a_folder_without_a_report_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys) -> None:
    """With exit code 2 and a sentence."""
    monkeypatch.setattr("sys.argv", ["update_results.py", str(tmp_path)])
    assert TOOL["main"]() == 2
    assert "rmfs reproduce --out" in capsys.readouterr().err
