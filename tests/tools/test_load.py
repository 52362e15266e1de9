"""tools/load.py: what it makes of hey's figures, and a short run of it."""

from __future__ import annotations

import os
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

TOOL = Path(__file__).resolve().parents[2] / "tools" / "load.py"
PRINTED = """
Summary:
  Total:        0.0234 secs
  Slowest:      0.0121 secs
  Requests/sec: 854.7812

Latency distribution:
  10%% in 0.0020 secs
  50%% in 0.0031 secs
  99%% in 0.0119 secs

Status code distribution:
  [200] 20 responses
"""


@pytest.fixture
def with_hey(tmp_path: Path) -> dict[str, str]:
    """Return an environment with a `hey` that has measured before it was asked."""
    (tmp_path / "hey").write_text(f"#!/bin/sh\ncat <<'END'\n{PRINTED}\nEND\n", encoding="utf-8")
    (tmp_path / "hey").chmod(0o755)
    return {**os.environ, "PATH": f"{tmp_path}{os.pathsep}{os.environ.get('PATH', '')}"}


def load(environment: dict[str, str], *arguments: str) -> tuple[int, str]:
    """Return exit code and output of the tool."""
    done = subprocess.run(
        (sys.executable, str(TOOL), *arguments), env=environment, capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout + done.stderr


def test_what_hey_prints() -> None:
    """Rate, times and statuses; answers that did not come count."""
    measured: Any = runpy.run_path(str(TOOL))["Measured"]
    found = measured.of(PRINTED)
    assert (found.rate, found.median_s, found.p99_s, found.statuses) == (854.7812, 0.0031, 0.0119, {"200": 20})
    assert measured.of(PRINTED + "\nError distribution:\n  [3]\tEOF\n").statuses == {"200": 20, "none": 1}


def test_a_short_run(with_hey: dict[str, str]) -> None:
    """The service is started, looked at and ended; each bar is told, and one that is missed by the exit code, too."""
    code, told = load(with_hey, "--requests", "20")
    assert code == 0, told
    assert "Memory after 2 and 20 requests: service " in told and told.count("\nok: ") == 4
    file = Path(with_hey["PATH"].partition(os.pathsep)[0]) / "hey"
    file.write_text(file.read_text(encoding="utf-8").replace("0.0119", "0.0219"), encoding="utf-8")
    code, told = load(with_hey, "--requests", "20")
    assert code == 1
    assert "NOT SO: 99 % within 20 ms at 200 a second" in told


def test_without_hey(tmp_path: Path) -> None:
    """One sentence."""
    code, told = load({**os.environ, "PATH": str(tmp_path)})
    assert (code, told) == (2, "Error: hey is not installed; expected `apt-get install hey`.\n")
