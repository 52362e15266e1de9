"""Experiments on a Dask cluster: a scheduler and workers as processes of their own, one of which is killed."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from attrs import define, field

from rmfs_commands.details.loading import load_result
from rmfs_commands.experiments import Experiment, Job, Row, Watcher, run_experiment
from rmfs_core.errors import InputError, RunError

Write = Callable[..., Experiment]

LONGER = """
base = "tiny.toml"
seeds = { count = 6 }
baseline = "pod-match"
[axes]
instance.orders = [100]
[[rule_sets]]
name = "pod-match"
[[rule_sets]]
name = "first-come"
rules.poa = "first-come"
"""


@define
class Cluster:
    """A scheduler and its workers, each a process."""

    folder: Path
    processes: list[subprocess.Popen[bytes]] = field(factory=list)
    address: str = ""

    def start(self, module: str, *arguments: str) -> subprocess.Popen[bytes]:
        """Start a process of distributed's command line."""
        command = [sys.executable, "-m", f"distributed.cli.{module}", *arguments]
        with (self.folder / f"{len(self.processes)}.log").open("wb") as log:
            process = subprocess.Popen(command, stdout=log, stderr=log, cwd=self.folder, process_group=0)
        self.processes.append(process)
        return process

    def start_scheduler(self) -> None:
        """Start the scheduler on a free port, and wait until it listens."""
        file = self.folder / "scheduler.json"
        self.start(
            "dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file)
        )
        until = time.monotonic() + 60
        while not (file.exists() and '"tcp://' in file.read_text()):
            assert time.monotonic() < until, "the scheduler did not start"
            time.sleep(0.1)
        self.address = file.read_text().partition('"address": "')[2].partition('"')[0]

    def start_worker(self, *arguments: str, threads: int = 1) -> subprocess.Popen[bytes]:
        """Start a worker of so many threads."""
        return self.start("dask_worker", self.address, "--nthreads", f"{threads}", "--no-dashboard", *arguments)


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    """Return a scheduler without workers, on this machine alone."""
    folder = tmp_path / "cluster"
    folder.mkdir()
    started = Cluster(folder)
    started.start_scheduler()
    yield started
    for process in started.processes:  # with what a nanny has started
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait(timeout=30)


@define
class KillerAfter(Watcher):
    """Kills a process once so many runs are done."""

    process: subprocess.Popen[bytes]
    runs: int
    done: int = 0

    def run_finished(self, job: Job, row: Row) -> None:
        self.done += 1
        if self.done == self.runs:
            os.kill(self.process.pid, signal.SIGKILL)


@pytest.mark.slow
def test_a_killed_worker_costs_nothing(cluster: Cluster, experiment: Write, tmp_path: Path) -> None:
    """With one of two workers killed in the middle every run is there, and the same as when run locally."""
    workers = [cluster.start_worker("--no-nanny") for _ in range(2)]
    one = experiment(LONGER)
    killer = KillerAfter(workers[0], runs=3)
    result = run_experiment(one, store=tmp_path / "cluster-runs", dask=cluster.address, watcher=killer)
    assert workers[0].wait(timeout=30) == -signal.SIGKILL
    local = run_experiment(one, store=tmp_path / "local-runs")
    assert (len(result.rows), result.failed, result.computed) == (12, [], 12)
    for job in one.jobs():
        ours, theirs = (load_result(tmp_path / name / job.key) for name in ("cluster-runs", "local-runs"))
        assert ours.metrics == theirs.metrics
        assert (ours.orders, ours.visits) == (theirs.orders, theirs.visits)
        assert ours.to_dict().keys() == theirs.to_dict().keys()
    assert len(local.rows) == 12


@pytest.mark.slow
def test_a_worker_of_several_threads_writes_the_same_bytes(cluster: Cluster, experiment: Write, tmp_path: Path) -> None:
    """It runs as many runs at a time in one process, none of them in its main thread."""
    cluster.start_worker("--no-nanny", threads=4)
    paths = "".join(f'[[rule_sets]]\nname = "{rule}"\nrules.pp = "{rule}"\n' for rule in ("whca-n", "pbs"))
    models = '[[rule_sets]]\nname = "model"\nrules.poa_pps = "split-over-time"\n'
    one = experiment(LONGER + paths + models)
    far = run_experiment(one, store=tmp_path / "cluster-runs", dask=cluster.address)
    near = run_experiment(one, store=tmp_path / "local-runs")
    assert (len(far.rows), far.failed, near.failed) == (30, [], [])
    for job in one.jobs():
        for file in ("orders.csv", "visits.csv"):
            ours, theirs = (tmp_path / name / job.key / file for name in ("cluster-runs", "local-runs"))
            assert ours.read_bytes() == theirs.read_bytes(), (job.rule_set, job.seed, file)


@pytest.mark.slow
def test_a_run_that_kills_every_worker_is_given_up(
    cluster: Cluster, experiment: Write, folder: Path, tmp_path: Path
) -> None:
    """Dask tries it on some workers, which their nannies replace; then it is a failed row, and the others are done."""
    for _ in range(2):
        cluster.start_worker()
    choice = f'{{ rule = "./bad.py:Deadly", counter = "{folder / "count"}", deaths = 99 }}'
    one = experiment(
        'base = "tiny.toml"\nseeds = [1]\nbaseline = "good"\n[[rule_sets]]\nname = "good"\n'
        f'[[rule_sets]]\nname = "bad"\nrules.pr = {choice}\n'
    )
    result = run_experiment(one, store=tmp_path / "runs", dask=cluster.address)
    assert [row["status"] for row in result.rows] == ["complete", "failed"]
    assert "Dask workers died of it" in result.rows[1]["error"]


@pytest.mark.slow
def test_a_killed_scheduler_is_told_in_a_sentence(
    cluster: Cluster, experiment: Write, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """What finished is kept; the libraries' tracebacks are not shown."""
    cluster.start_worker("--no-nanny")
    killer = KillerAfter(cluster.processes[0], runs=2)
    with pytest.raises(RunError, match=f"the Dask scheduler at {cluster.address} is lost; what finished is kept"):
        run_experiment(experiment(LONGER), store=tmp_path / "runs", dask=cluster.address, watcher=killer)
    assert len(list((tmp_path / "runs").iterdir())) >= 2
    assert capfd.readouterr().err == ""


@pytest.mark.slow
def test_a_scheduler_without_workers_is_refused(cluster: Cluster, experiment: Write, tmp_path: Path) -> None:
    """Nothing would ever be run."""
    with pytest.raises(InputError, match="the scheduler has no workers"):
        run_experiment(experiment(), store=tmp_path / "runs", dask=cluster.address)


@pytest.mark.slow
def test_no_scheduler_is_refused(experiment: Write, tmp_path: Path) -> None:
    """An address where nothing answers is an error that says what an address looks like."""
    with pytest.raises(InputError, match="no Dask scheduler answers there; expected tcp://host:8786"):
        run_experiment(experiment(), store=tmp_path / "runs", dask="tcp://127.0.0.1:9")


def test_what_is_no_address_is_refused(experiment: Write, tmp_path: Path) -> None:
    """A host alone is no address."""
    with pytest.raises(InputError, match="expected the address of a scheduler, tcp://host:8786, found localhost"):
        run_experiment(experiment(), store=tmp_path / "runs", dask="localhost")
