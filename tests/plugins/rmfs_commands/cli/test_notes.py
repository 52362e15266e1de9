"""What commands say besides their output."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.parametrize("ends", ["2>/dev/full", "2>&-", "2>&1 >/dev/null | true"])
def test_a_run_goes_on_when_nobody_reads_what_it_says(ends: str, tmp_path: Path) -> None:
    """Whoever has closed the standard error stream misses the lines, and nothing else."""
    program = f"{sys.executable} -c 'from rmfs_commands.cli.main import main; main()'"
    call = f"set -o pipefail; {program} run examples/small --set instance.orders=20 --out out {ends}"
    subprocess.run(["bash", "-c", call], cwd=tmp_path, check=True, capture_output=True)
    result = json.loads((tmp_path / "out" / "result.json").read_text("utf-8"))
    assert (result["status"], result["metrics"]["orders_completed"]) == ("complete", 20)
