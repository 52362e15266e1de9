"""Saying that searches are being compiled."""

from __future__ import annotations

import io

from numba import njit
from rich.console import Console

from rmfs_commands.cli.compiling import compiling_announced


def test_it_is_said_once_and_only_when_something_is_compiled() -> None:
    """Two functions compiled in a row are announced in one line; calling them again is not."""
    increased, doubled = njit(lambda number: number + 1), njit(lambda number: 2 * number)
    said = []
    for _ in range(2):
        notes = Console(file=io.StringIO(), width=40)
        with compiling_announced(notes):
            assert doubled(increased(1)) == 4
        said.append(notes.file.getvalue())
    assert said == ["Compiling searches (once a rule; up to a minute) ...\n", ""]


def test_what_is_compiled_elsewhere_is_not_announced() -> None:
    """Once the block is left nobody listens."""
    notes = Console(file=io.StringIO())
    with compiling_announced(notes):
        pass
    assert njit(lambda number: number - 1)(1) == 0
    assert notes.file.getvalue() == ""
