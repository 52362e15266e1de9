"""The load on which rmfs and RAWSim-O are compared: what four simulated hours take, in yardsticks.

The map, orders, pods and rules of `scenarios/parity`, with backlog kept at 200; and two hours of another world, for
what is fast in one alone is worth less: 1,000 SKUs in finite stock on 428 pods, 660 orders an hour. CPU time without
start-up, beside a yardstick that runs in the same call, so that figures of different machines and days can be
compared; those of releases are in history.json. What is more than 10 % slower than in the last release is named after
the tests, and fails none.
"""

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rmfs_core
from releases import held_against_release
from rmfs_core import hookimpl
from rmfs_core.world.travel import shared_travel
from yardstick import in_yardsticks

SCENARIO = Path(__file__).parents[2] / "scenarios" / "parity" / "rawsim-o.toml"
HOURS = 4
OTHER_HOURS, OTHER_SKUS, OTHER_PODS = 2, 1000, 428
OTHER = """
[instance]
orders_file = "orders.csv"
pods_file = "pods.csv"
[robots]
count = 16
[rules]
poa = "pod-match"
pps = "demand"
"""


class Clock:
    """Observer that takes the processor time of a run, from its start to its end."""

    @hookimpl
    def run_started(self) -> None:
        self.cpu_s = -time.process_time()

    @hookimpl
    def run_ended(self) -> None:
        self.cpu_s += time.process_time()


def other_world(folder: Path) -> Path:
    """Write a scenario of another world, drawn by a seed: 200 orders at first, then 660 an hour; stock is finite."""
    rng = np.random.default_rng(1)
    arrivals = [0.0] * 200 + np.cumsum(rng.exponential(3600 / 660, 660 * OTHER_HOURS)).round(3).tolist()
    chances = 1 / np.sqrt(np.arange(1, OTHER_SKUS + 1))
    chances /= chances.sum()
    lines, pods = ["order,arrival_s,sku,quantity"], ["pod,sku,quantity"]
    for number, arrival_s in enumerate(arrivals):
        skus = rng.choice(OTHER_SKUS, min(rng.geometric(0.5), 6), replace=False, p=chances)
        lines += [f"{number},{arrival_s},{sku},{rng.geometric(0.8)}" for sku in skus]
    pods += [f"{place // 12},{place % OTHER_SKUS},30" for place in range(12 * OTHER_PODS)]
    for name, rows in (("orders.csv", lines), ("pods.csv", pods)):
        (folder / name).write_text("\n".join(rows) + "\n", encoding="utf-8")
    (folder / "other.toml").write_text(OTHER, encoding="utf-8")
    return folder / "other.toml"


@pytest.mark.parametrize("world", ["", "other"])
@pytest.mark.parametrize("rule", ["whca-n", "sipp"])
@pytest.mark.parametrize("robots", [8, 16, 32, 64])
def test_matched_load(benchmark: Any, record_property: Any, tmp_path: Path, robots: int, rule: str, world: str) -> None:
    """Four hours of RAWSim-O's warehouse; `yardsticks` is what they take, `simulated_s_per_s` what that comes to.

    Where nothing is timed, the four hours are those with 16 robots, as in the comparison; of the others, a quarter.
    """
    scenario, whole = (other_world(tmp_path), OTHER_HOURS) if world else (SCENARIO, HOURS)
    places = ["robots.file="] if robots > 16 and not world else []  # the file has places for sixteen

    clock, results = Clock(), []

    def run(hours: float) -> rmfs_core.Result:
        shared_travel.cache_clear()  # tables of driving times that another run has left are not there in a first run
        until = f"run.until_s={hours * 3600}"
        overrides = [f"robots.count={robots}", f"rules.pp={rule}", until, *places]
        return rmfs_core.run(scenario, overrides=overrides, observers=[clock])

    run(0.05)  # what is compiled is loaded, and compiled before if need be

    if not benchmark.enabled and (robots != 16 or world):
        assert benchmark.pedantic(run, args=(0.25,), rounds=1).metrics["orders_completed"] > 50
        return

    def measure() -> float:
        results.append(run(whole))
        return clock.cpu_s

    def measure_again() -> float:
        return in_yardsticks(measure)

    benchmarked = f"{robots} robots, {rule}{world and ', another world'}"
    least, slower = benchmark.pedantic(held_against_release, args=(benchmarked, measure_again), rounds=1)
    benchmark.extra_info.update(yardsticks=least, simulated_s_per_s=whole * 3600 / clock.cpu_s)
    if slower is not None:
        record_property("slower", slower)
    assert results[0].metrics["orders_completed"] > whole * 400
    assert all(one.metrics == results[0].metrics for one in results)
