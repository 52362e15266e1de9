"""The command line as a whole."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

COMMANDS = [
    ("rules",),
    ("rules", "--json"),
    ("scenario", "list"),
    ("scenario", "map", "examples/small"),
    ("scenario", "schema"),
    ("scenario", "check", "examples/small"),
    ("compare", "--list"),
    ("run", "examples/example-1-integrated", "--out", "out"),
    ("run", "examples/example-1-integrated", "--out", "out", "--json"),
]


@pytest.mark.parametrize("arguments", COMMANDS, ids=" ".join)
def test_a_reader_that_goes_away_ends_a_command_quietly(arguments: tuple[str, ...], tmp_path: Path) -> None:
    """As in `rmfs rules | head`: the exit code is a shell's for a closed pipe, and nothing is said of it."""
    command = [sys.executable, "-c", "from rmfs_core.cli import main; main()", *arguments]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, cwd=tmp_path) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        errors = process.stderr.read()
    assert process.returncode == 141
    for word in ("Traceback", "Exception", "Error", "pipe"):
        assert word not in errors
    if arguments[0] == "run":
        assert (tmp_path / "out" / "result.json").exists()
