"""The watch on a run's memory."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

TOOL = Path(__file__).resolve().parents[2] / "tools" / "soak.py"


def test_a_short_run_is_watched_under_both_planners(tmp_path: Path) -> None:
    """They complete; what they grow by is said, and decides on the exit code."""
    done = subprocess.run(
        [sys.executable, str(TOOL), "--orders", "20"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.stderr == ""
    lines = done.stdout.splitlines()
    assert [line for line in lines if "orders," in line] == [
        "sipp, 20 orders, 119 an hour",
        "whca-n, 20 orders, 119 an hour",
    ]
    assert sum("complete after 0." in line for line in lines) == 2
    assert sum("kB an order since day 2" in line for line in lines) == 2
    assert done.returncode == 0
