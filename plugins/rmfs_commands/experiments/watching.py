"""Watchers of an experiment, which are told of each run."""

from __future__ import annotations

from rmfs_commands.experiments.experiment import Job
from rmfs_commands.experiments.rows import Row


class Watcher:
    """Told what happens while an experiment runs; does nothing with it. Subclasses do.

    `run_started` and `run_repeated` are called from other threads than the rest, several at a time.
    """

    def run_dropped(self, job: Job, problem: str) -> None:
        """Say, before `started`, that a stored run is computed again, since something is wrong with its files."""

    def started(self, total: int, stored: int, slots: int) -> None:
        """Say that an experiment begins: runs in all, how many of them are stored already, runs at a time."""

    def run_started(self, job: Job) -> None:
        """Say that a run begins."""

    def run_repeated(self, job: Job, problem: str) -> None:
        """Say that a run begins once more, since its worker died."""

    def run_finished(self, job: Job, row: Row) -> None:
        """Say that a run is over, with its row."""

    def bounding(self, instances: int) -> None:
        """Say, after `ended`, that bounds are sought, of so many instances with their seeds."""

    def ended(self) -> None:
        """Say that the experiment is over, or was interrupted."""
