"""Notices of single runs while sizes are tried: only the unusual."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rmfs_commands.cli.screen import say
from rmfs_commands.experiments import Job, Watcher

if TYPE_CHECKING:
    from rich.console import Console


class Notices(Watcher):
    """Writes a line for a run that is computed again.

    Parameters
    ----------
    console
        Where to.
    """

    def __init__(self, console: Console) -> None:
        self._console = console

    def run_dropped(self, job: Job, problem: str) -> None:
        """Write a line."""
        say(self._console, f"Computed again: {job}: {problem}")

    def run_repeated(self, job: Job, problem: str) -> None:
        """Write a line."""
        say(self._console, f"Repeated: {job}: {problem}")
