"""Runs, experiments, episodes and decisions outside a run: how long each takes, from the start to the last file.

`make bench` measures; the bars are asserted there only.
"""

import os
import subprocess
import sys
import time
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

import pytest
from distributed import LocalCluster
from pytest_benchmark.fixture import BenchmarkFixture

import rmfs_commands.gym
import rmfs_core
from copying import copy_of
from rmfs_commands.experiments import Base, Experiment, Job, Row, RuleSetChoice, Watcher, run_experiment
from rmfs_core.scenario import load_scenario
from rmfs_core.world import read_instance


@pytest.fixture(scope="module", autouse=True)
def warm() -> None:
    """Compile and import everything once: a run's time is counted after start-up."""
    rmfs_core.run("paper-250")


@pytest.mark.parametrize("skus", [20, 100])
@pytest.mark.parametrize("pods", [50, 100])
def test_a_250_order_run_with_free_flow(benchmark: Any, skus: int, pods: int) -> None:
    """Bar: under 1.5 s, and at least 3,000 simulated seconds per second."""
    overrides = [f"instance.skus={skus}", f"instance.pods={pods}", "rules.pp=free-flow"]
    result = benchmark(rmfs_core.run, "paper-250", overrides=overrides)
    assert result.status == "complete"
    if benchmark.enabled:
        seconds = benchmark.stats.stats.median
        benchmark.extra_info["simulated_s_per_s"] = result.metrics["makespan_s"] / seconds
        assert seconds < 1.5
        assert result.metrics["makespan_s"] / seconds >= 3000


def test_help_is_there_at_once(benchmark: Any) -> None:
    """Bar: `rmfs --help` takes less than 0.3 s of processor time, its own and the system's.

    Its modules are compiled to bytecode, as those of an installed package are.
    """
    seconds = []
    variables = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}

    def ask() -> None:
        before = os.times()
        subprocess.run(
            [sys.executable, "-c", "from rmfs_commands.cli.main import main; main(['--help'])"],
            check=True,
            env=variables,
        )
        after = os.times()
        spent = after.children_user + after.children_system - before.children_user - before.children_system
        seconds.append(spent)

    benchmark.pedantic(ask, rounds=7, warmup_rounds=1)
    if benchmark.enabled:
        benchmark.extra_info["cpu_s"] = median(seconds[1:])
        assert median(seconds[1:]) < 0.3


def test_load_100_000_rows(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    """100,000 order rows; the aim is under 2 s."""
    rows = "".join(f"W{i // 2},{i // 2},SKU{i * 7 % 5000},{i % 3 + 1}\n" for i in range(100_000))
    (tmp_path / "orders.csv").write_text("order,arrival_s,sku,quantity\n" + rows, encoding="utf-8")
    pods = "".join(f"P{i // 3},SKU{i},\n" for i in range(5000))
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\n" + pods, encoding="utf-8")
    instance = benchmark(read_instance, tmp_path / "orders.csv", tmp_path / "pods.csv")
    assert len(instance.orders) == 50_000


@pytest.mark.parametrize("decides", ["POA", "PPS", "PR", "TA"])
@pytest.mark.parametrize("world", ["examples/small", "paper-250"])
def test_an_episode_takes_little_longer_than_a_run(benchmark: Any, world: str, decides: str) -> None:
    """Bar: at least 80 % of the speed of the simulation with the rule that the policy copies, its own time included.

    Robots do not see each other (``free-flow``): where paths are planned the simulation takes longer.
    """
    rule = {"POA": "pod-match", "PPS": "nearest-pod", "PR": "nearest", "TA": "nearest-robot"}[decides]
    overrides = ["rules.pp=free-flow", f"rules.{decides.lower()}={rule}"]
    env = rmfs_commands.gym.make(world, decides, overrides=overrides, orders_shown=250)
    policy = copy_of(decides, rule, stations=2 if world == "examples/small" else 4)
    spent: dict[str, list[float]] = {"episode": [], "run": []}

    def episode() -> None:
        observation, info = env.reset(seed=1)
        over = False
        while not over:
            observation, _, terminated, truncated, info = env.step(policy(observation, info["action_mask"]))
            over = terminated or truncated

    def both() -> None:
        for name, play in (("episode", episode), ("run", lambda: rmfs_core.run(world, overrides=overrides))):
            before = process_time()
            play()
            spent[name].append(process_time() - before)

    benchmark.pedantic(both, rounds=5, warmup_rounds=1)
    if benchmark.enabled:
        share = min(spent["run"]) / min(spent["episode"])
        benchmark.extra_info["share_of_speed"] = share
        assert share >= 0.8


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


def sequential(seeds: int) -> Experiment:
    return Experiment(
        name="sequential",
        bases=(Base("paper-250", load_scenario("paper-250", ["rules.pp=free-flow"])),),
        rule_sets=(RuleSetChoice("sequential"),),
        seeds=tuple(range(1, seeds + 1)),
        baseline="sequential",
    )


def test_overhead_of_an_experiment(benchmark: Any, tmp_path: Path) -> None:
    """Bar: with one worker, whole 250-order runs, everything besides the runs takes under 5 % of their own time."""
    experiment = sequential(RUNS if benchmark.enabled else 2)
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
    experiment = sequential(RUNS if benchmark.enabled else 5)
    near, far = Clock(), Clock()
    assert not run_experiment(experiment, store=tmp_path / "near", jobs=2, watcher=near).failed
    with LocalCluster(2, threads_per_worker=1, dashboard_address=":0", local_directory=str(tmp_path)) as cluster:
        options = {"store": tmp_path / "far", "dask": cluster.scheduler_address, "watcher": far}
        result = benchmark.pedantic(run_experiment, args=(experiment,), kwargs=options, rounds=1)
    assert (len(result.rows), result.failed) == (len(experiment.seeds), [])
    benchmark.extra_info["efficiency"] = near.used_s / far.used_s
    if benchmark.enabled:
        assert near.used_s / far.used_s >= 0.85
