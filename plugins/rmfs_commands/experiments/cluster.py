"""The workers of a Dask cluster."""

from __future__ import annotations

import logging
import re
from typing import Any

from rmfs_commands.experiments.experiment import Job
from rmfs_commands.experiments.outcome import Outcome, simulate
from rmfs_commands.experiments.workers import WorkerDiedError
from rmfs_core.errors import InputError, RunError

TIMEOUT_S = 10
QUEUED_PER_THREAD = 2
"""Runs handed over for each thread of the cluster: no worker waits while a result travels."""


SILENT = ("distributed", "tornado", "asyncio")
"""Libraries whose loggers show a lost scheduler with tracebacks, before it is told in a sentence."""


class ClusterWorkers:
    """Dask workers, each reached through the scheduler.

    They need the same versions of everything as here (a run on others is refused), and the scenario's files under the
    same names. Results come back and are stored here.

    Parameters
    ----------
    address
        Of the scheduler: ``tcp://host:8786``.
    count
        Runs handed over at a time; None: two for each thread of the cluster.

    Raises
    ------
    InputError
        When the packages are not installed, or no scheduler with workers answers.
    """

    def __init__(self, address: str, count: int | None = None) -> None:
        try:
            from distributed import Client
        except ImportError as error:
            raise InputError(
                "dask", f"needs further packages; expected `pip install 'rmfs[dask]'` ({error})"
            ) from error
        if not re.fullmatch(r"[a-z]+://\S+:\d+", address):
            raise InputError("dask", f"expected the address of a scheduler, tcp://host:8786, found {address}")
        self.address = address
        self.closed = False
        _quieten()
        self._client: Any
        try:
            self._client = Client(  # type: ignore[no-untyped-call]
                address, set_as_default=False, timeout=TIMEOUT_S
            )
        except (OSError, ValueError) as error:
            raise InputError(
                f"dask {address}", f"no Dask scheduler answers there; expected tcp://host:8786 ({error})"
            ) from error
        try:
            self._client.wait_for_workers(1, timeout=TIMEOUT_S)
        except TimeoutError as error:
            self._client.close()
            raise InputError(f"dask {address}", "the scheduler has no workers; expected at least one") from error
        self.count = count or QUEUED_PER_THREAD * sum(self._client.nthreads().values())

    def run(self, job: Job) -> Outcome:
        """Run a job somewhere on the cluster. Dask itself repeats it elsewhere when a worker is lost."""
        from distributed import KilledWorker

        try:
            outcome = self._client.submit(simulate, job, pure=False).result()
        except KilledWorker as error:
            problem = f"{error.allowed_failures + 1} Dask workers died of it, {error.last_worker.address} last"
            raise WorkerDiedError(problem, repeated=True) from error
        except Exception as error:
            problem = f"{type(error).__name__}: {error}".splitlines()[0]
            raise RunError(
                f"the Dask scheduler at {self.address} is lost; what finished is kept ({problem})"
            ) from error
        assert isinstance(outcome, Outcome)
        return outcome

    def close(self) -> None:
        """Drop the runs that are handed over, and the connection."""
        self.closed = True
        self._client.close(timeout=TIMEOUT_S)


def _quieten() -> None:
    """Let libraries log nothing: what comes of runs, and of the scheduler, is told by errors."""
    for name, logger in list(logging.getLogger().manager.loggerDict.items()):
        if name.partition(".")[0] in SILENT and isinstance(logger, logging.Logger):
            logger.disabled = True
