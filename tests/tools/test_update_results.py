"""tools/update_results.py: from a reproduction to docs/paper/reproduction."""

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


def test_report_and_plots_take_the_place_of_earlier_ones(tmp_path: Path) -> None:
    """The folder has the report and the plots that it shows, and nothing else."""
    source, reports = tmp_path / "out", tmp_path / "reports"
    source.mkdir()
    reports.mkdir()
    (source / "report.md").write_text(REPORT)
    (source / "visits.png").write_bytes(b"new")
    (source / "unseen.png").write_bytes(b"new")
    (reports / "old.png").write_bytes(b"old")
    TOOL["update"](reports, source)
    assert sorted(path.name for path in reports.iterdir()) == ["report.md", "visits.png"]
    assert (reports / "report.md").read_text() == REPORT


def test_the_folder_of_a_machine_is_left_out() -> None:
    """Where a report was written is nobody's business."""
    line = "- Command: `rmfs reproduce --out somewhere --jobs 2`"
    assert TOOL["without_folder"](f"# Title\n\n{line}\n") == "# Title\n\n- Command: `rmfs reproduce --jobs 2`\n"


def test_a_folder_without_a_report_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys) -> None:
    """With exit code 2 and a sentence."""
    monkeypatch.setattr("sys.argv", ["update_results.py", str(tmp_path)])
    assert TOOL["main"]() == 2
    assert "rmfs reproduce --out" in capsys.readouterr().err
