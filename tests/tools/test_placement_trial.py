"""The trial of placements on made-up days."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

TOOL = Path(__file__).resolve().parents[2] / "tools" / "placement_trial.py"


def test_a_short_day_is_compared() -> None:
    """A row for each set of rules and shape: change of turn-over and visits for each placement but random."""
    options = ["--hours", "0.05", "--seeds", "1", "--shapes", "bought together", "--rules", "pod-match+demand"]
    done = subprocess.run([sys.executable, str(TOOL), *options], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    first, row = done.stdout.splitlines()
    assert first == "Turn-over time and pod visits against random: popularity, co-purchase, foresight"
    assert row.startswith("pod-match+demand bought together")
    assert len(re.findall(r"[+-]\d+ %", row)) == 6
