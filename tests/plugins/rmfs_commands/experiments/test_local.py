"""Worker processes on this machine: one run at a time each, and what happens when one dies."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import psutil
import pytest
from attrs import evolve

from rmfs_commands.experiments import Experiment, Job
from rmfs_commands.experiments.local import LocalWorkers
from rmfs_commands.experiments.outcome import simulate
from rmfs_commands.experiments.workers import WorkerDiedError
from rmfs_core.scenario import RuleChoice


def deadly(job: Job, folder: Path) -> Job:
    """Return the run with a rule that kills its process the first time it is asked."""
    choice = RuleChoice("./bad.py:Deadly", {"counter": str(folder / "count")})
    scenario = evolve(job.scenario, rules=evolve(job.scenario.rules, pr=choice))
    return evolve(job, scenario=scenario, versions=job.versions)


def test_runs_and_deaths(experiment: Callable[..., Experiment], folder: Path) -> None:
    """A worker answers as this process would; one that is killed costs its own run, and the next has a new one."""
    job = experiment().jobs()[0]
    workers = LocalWorkers(1)
    try:
        outcome, expected = workers.run(job), simulate(job)
        assert outcome.result is not None
        assert expected.result is not None
        assert outcome.result.metrics == expected.result.metrics
        with pytest.raises(WorkerDiedError, match=r"^its worker process died with SIGKILL\(-9\)$") as caught:
            workers.run(deadly(job, folder))
        assert not caught.value.repeated
        again = workers.run(job).result
        assert again is not None
        assert again.metrics == expected.result.metrics
    finally:
        workers.close()
    assert workers.closed


def test_a_killed_helper_of_joblib_is_told_in_a_sentence(
    experiment: Callable[..., Experiment], capfd: pytest.CaptureFixture[str]
) -> None:
    """It keeps track of semaphores; the runs go on without it, and nothing of it is told by tracebacks."""
    job = experiment().jobs()[0]
    workers = LocalWorkers(1)
    try:
        assert workers.run(job).result is not None
        for child in psutil.Process().children():
            if "loky.backend.resource_tracker" in " ".join(child.cmdline()):
                child.kill()
        assert workers.run(job).result is not None
    finally:
        workers.close()
    assert capfd.readouterr().err == "A helper process of joblib was killed; it is started anew, and no run is lost.\n"
