"""The task of a worker: one run, whatever its outcome."""

from __future__ import annotations

import time
from collections.abc import Mapping

from attrs import evolve, frozen

from rmfs_commands.experiments.experiment import Job
from rmfs_commands.experiments.sources import changed_since
from rmfs_commands.instances.csv_files import warnings_kept
from rmfs_core import run
from rmfs_core.errors import InputError, RunError
from rmfs_core.results import Result
from rmfs_core.wording import listed


@frozen(eq=False)
class Outcome:
    """Outcome of a run.

    Parameters
    ----------
    result
        The result, None when there is nothing to keep.
    error
        The error.
    error_kind
        Name of the error's class.
    run_s
        Wall-clock seconds of the run with its preparation.
    warnings
        Sentences on files that were read for it, for a person; those of files read before are missing.
    """

    result: Result | None
    error: str | None = None
    error_kind: str | None = None
    run_s: float = 0.0
    warnings: tuple[str, ...] = ()


def simulate(job: Job) -> Outcome:
    """Run a job. Never raises: a run that fails is an outcome like any other."""
    with warnings_kept() as told:
        outcome = _simulated(job)
    return evolve(outcome, warnings=tuple(told))


def _simulated(job: Job) -> Outcome:
    started = time.perf_counter()
    changed = changed_since(job.sources)
    if changed:
        problem = f"the worker has other code of {listed(changed)}; expected that which the experiment began with"
        return Outcome(None, problem, "VersionError")
    result: Result | None = None
    error: Exception | None = None
    try:
        result = run(job.scenario)
    except RunError as problem:
        result, error = problem.result, problem
    except Exception as problem:
        error = problem
    if result is not None and result.versions != dict(job.versions):
        return Outcome(None, _difference(job.versions, result.versions), "VersionError")
    seconds = time.perf_counter() - started
    if error is None:
        return Outcome(result, run_s=seconds)
    name = type(error).__name__
    text = str(error) if isinstance(error, RunError | InputError) else f"{name}: {error}"
    return Outcome(result, text, name, seconds)


def _difference(expected: Mapping[str, str], found: Mapping[str, str]) -> str:
    """Say which version of the worker's is another one: its result must not stand for the versions here."""
    names = sorted(name for name in {*expected, *found} if expected.get(name) != found.get(name))
    return "; ".join(f"the worker has {name} {found.get(name)}, expected {expected.get(name)}" for name in names)
