"""The study of comparisons whose truth is known."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

TOOL = Path(__file__).resolve().parents[2] / "tools" / "coverage_study.py"


def test_the_study_counts(tmp_path: Path) -> None:
    """A few repeats make the table, and only figures that are off are complained of; nothing contradicts itself."""
    done = subprocess.run(
        [sys.executable, str(TOOL), "--repeats", "40"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    head, _, *rows = done.stdout.splitlines()
    assert head.count("|") == 7
    assert len(rows) == 6
    several = [row.split("|") for row in rows if "4 instances" in row]
    assert all(float(row[2].strip(" %")) > float(row[-2].strip(" %")) + 5 for row in several)
    assert done.returncode == (1 if done.stderr else 0)
    assert "Traceback" not in done.stderr
    assert "contradictions" not in done.stderr
