"""What running an experiment costs besides its runs. `make bench` measures; the bars are asserted there only."""

import time
from pathlib import Path
from typing import Any

from distributed import LocalCluster

from rmfs_commands.experiments import Base, Experiment, Job, Row, RuleSetChoice, Watcher, run_experiment
from rmfs_core.scenario import load_scenario

RUNS = 40


class Clock(Watcher):
    """Takes the time from the end of the first run, when the worker is warm, to the end of the last one."""

    def __init__(self) -> None:
        self.ended_at: list[float] = []
        self.own_s = 0.0

    def run_finished(self, job: Job, row: Row) -> None:
        self.ended_at.append(time.perf_counter())
        if len(self.ended_at) > 1:
            self.own_s += row["run_s"]

    @property
    def used_s(self) -> float:
        """Time from the end of the fourth run on: two workers are warm then."""
        return self.ended_at[-1] - self.ended_at[3]

    @property
    def overhead(self) -> float:
        """Time that passed besides the runs, as a share of theirs."""
        return (self.ended_at[-1] - self.ended_at[0]) / self.own_s - 1


def test_overhead_of_an_experiment(benchmark: Any, tmp_path: Path) -> None:
    """Bar: with one worker, whole 250-order runs, everything besides the runs takes under 5 % of their own time."""
    experiment = Experiment(
        name="overhead",
        bases=(Base("paper-250", load_scenario("paper-250", ["rules.pp=free-flow"])),),
        rule_sets=(RuleSetChoice("sequential"),),
        seeds=tuple(range(1, RUNS + 1 if benchmark.enabled else 3)),
        baseline="sequential",
    )
    clock = Clock()
    result = benchmark.pedantic(
        run_experiment, args=(experiment,), kwargs={"store": tmp_path, "jobs": 1, "watcher": clock}, rounds=1
    )
    assert not result.failed
    benchmark.extra_info["overhead"] = clock.overhead
    if benchmark.enabled:
        assert clock.overhead < 0.05


def test_a_cluster_of_this_machine(benchmark: Any, tmp_path: Path) -> None:
    """Bar: two Dask processes do as much as 0.85 of what two of joblib's do in the same time."""
    experiment = Experiment(
        name="cluster",
        bases=(Base("paper-250", load_scenario("paper-250", ["rules.pp=free-flow"])),),
        rule_sets=(RuleSetChoice("sequential"),),
        seeds=tuple(range(1, RUNS + 1 if benchmark.enabled else 6)),
        baseline="sequential",
    )
    near, far = Clock(), Clock()
    assert not run_experiment(experiment, store=tmp_path / "near", jobs=2, watcher=near).failed
    with LocalCluster(2, threads_per_worker=1, dashboard_address=":0", local_directory=str(tmp_path)) as cluster:
        options = {"store": tmp_path / "far", "dask": cluster.scheduler_address, "watcher": far}
        result = benchmark.pedantic(run_experiment, args=(experiment,), kwargs=options, rounds=1)
    assert (len(result.rows), result.failed) == (len(experiment.seeds), [])
    benchmark.extra_info["efficiency"] = near.used_s / far.used_s
    if benchmark.enabled:
        assert near.used_s / far.used_s >= 0.85
