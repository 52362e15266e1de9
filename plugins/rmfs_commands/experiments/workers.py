"""Workers that do the runs of an experiment: processes of this machine, or the workers of a Dask cluster."""

from __future__ import annotations

from typing import Protocol

from rmfs_commands.experiments.experiment import Job
from rmfs_commands.experiments.outcome import Outcome


class WorkerDiedError(Exception):
    """The process that ran a run died without an answer.

    Parameters
    ----------
    problem
        How it died.
    repeated
        Whether the run was repeated already, so that it is given up now.
    """

    def __init__(self, problem: str, *, repeated: bool = False) -> None:
        super().__init__(problem)
        self.repeated = repeated


class Workers(Protocol):
    """A number of processes that each run one run at a time."""

    count: int
    closed: bool

    def run(self, job: Job) -> Outcome:
        """Run a job on a free worker and wait for it; called from ``count`` threads at a time.

        Raises
        ------
        WorkerDiedError
            When the worker died.
        """

    def close(self) -> None:
        """Stop all workers at once, whatever they do."""
