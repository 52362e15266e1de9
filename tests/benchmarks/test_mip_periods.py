"""Decision time of the joint models at t > 1: the aggregated form against the printed one with CBC, and the paper's.

`make bench` measures and holds the bars; both sides are timed in one run on the same periods.
"""

from __future__ import annotations

import time
from itertools import product
from statistics import mean, median
from typing import Any

import numpy as np
import pytest
from attrs import evolve, frozen

import rmfs_core
from rmfs_rules.mip import Integrated, SplitAmongStations, SplitOverTime
from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.solution import Model, Solution

RULES = {
    Model.INTEGRATED: Integrated,
    Model.SPLIT_AMONG_STATIONS: SplitAmongStations,
    Model.SPLIT_OVER_TIME: SplitOverTime,
}
PAPER_S_PER_ORDER = {Model.INTEGRATED: 0.48, Model.SPLIT_AMONG_STATIONS: 1.06, Model.SPLIT_OVER_TIME: 1.34}
PAPER_PERCENT_OF_SIMULATED = {Model.INTEGRATED: 3.39, Model.SPLIT_AMONG_STATIONS: 9.67, Model.SPLIT_OVER_TIME: 14.67}
FASTER = {Model.INTEGRATED: 20, Model.SPLIT_AMONG_STATIONS: 20, Model.SPLIT_OVER_TIME: 500}
ORDERS_250 = list(product((20, 100), (50, 100), (2, 3)))


@frozen
class Recorded:
    """The periods t > 1 of a whole run and the seconds that each decision took."""

    periods: list[Period]
    seconds: list[float]

    def some(self, number: int) -> list[Period]:
        """About so many of the periods, as they were before anything was derived from them."""
        return [evolve(period) for period in self.periods[:: max(len(self.periods) // number, 1)]]


def run(model: Model, skus: int, pods: int, alpha: int) -> rmfs_core.Result:
    """Run an instance with 250 orders; other robots are ignored, because their paths are not measured here."""
    numbers = {"skus": skus, "pods": pods, "skus_per_pod": alpha}
    overrides = [f"instance.{key}={number}" for key, number in numbers.items()]
    result = rmfs_core.run(f"paper-250-{model}", overrides=[*overrides, "rules.pp=free-flow"])
    assert result.status == "complete"
    return result


@pytest.fixture(scope="module")
def recorded() -> dict[Model, Recorded]:
    """Record a run of each model on an instance with 100 SKUs, 100 pods, 3 SKUs per pod."""
    runs = {}
    for model, rule in RULES.items():
        solve = rule.solve
        periods: list[Period] = []
        seconds: list[float] = []

        def record(
            rule: Any,
            period: Period,
            packing: int | None = None,
            *,
            solve: Any = solve,
            periods: list = periods,
            seconds: list = seconds,
        ) -> Any:
            start = time.perf_counter()
            solution = solve(rule, period, packing)
            seconds.append(time.perf_counter() - start)
            periods.append(evolve(period))
            return solution

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(rule, "solve", record)
            run(model, 100, 100, 3)
        runs[model] = Recorded(periods[1:], seconds[1:])
    return runs


def timed(rule: Any, periods: list[Period]) -> tuple[list[float], list[Solution]]:
    """Return the seconds that a rule takes for each period, model building and check included, and what it finds."""
    seconds, solutions = [], []
    for period in periods:
        start = time.perf_counter()
        solutions.append(rule.solve(period))
        seconds.append(time.perf_counter() - start)
    return seconds, solutions


@pytest.mark.slow
@pytest.mark.parametrize("model", Model)
def test_later_periods(benchmark: Any, recorded: dict[Model, Recorded], model: Model, capsys: Any) -> None:
    """Periods t > 1 against the printed form with CBC: median and 95th percentile."""
    taken = recorded[model]
    number = 60 if benchmark.enabled else 5
    ours, fast = timed(RULES[model](), taken.some(number))
    printed, slow = timed(RULES[model](formulation="paper", solver="cbc"), taken.some(number))
    assert [solution.objective for solution in fast] == [solution.objective for solution in slow]
    tail = float(np.quantile(taken.seconds, 0.95))
    with capsys.disabled():
        print(
            f"\n{model}: median {median(ours) * 1e3:.3f} ms against {median(printed) * 1e3:.1f} ms printed with CBC "
            f"({median(printed) / median(ours):.0f} times); in the run: median {median(taken.seconds) * 1e3:.3f} ms, "
            f"95th percentile {tail * 1e3:.1f} ms"
        )
    benchmark.pedantic(RULES[model]().solve, args=(taken.some(1)[0],), rounds=1)
    if benchmark.enabled:
        assert median(printed) / median(ours) >= FASTER[model]
        assert median(taken.seconds) < 0.005
        assert tail < 0.03


@pytest.mark.slow
@pytest.mark.parametrize("model", Model)
def test_whole_runs(benchmark: Any, model: Model, capsys: Any) -> None:
    """Seconds per order and share of simulated time at t > 1, means of the 250-order set: a fiftieth of the paper's."""
    instances = ORDERS_250 if benchmark.enabled else ORDERS_250[-1:]
    results = benchmark.pedantic(lambda: [run(model, *instance) for instance in instances], rounds=1)
    per_order = mean(result.timing["decision_s_per_order"] for result in results)
    percent = mean(result.timing["decision_percent_of_simulated"] for result in results)
    with capsys.disabled():
        print(
            f"\n{model}: {per_order:.4f} s per order (paper {PAPER_S_PER_ORDER[model]}), "
            f"{percent:.4f} % of simulated time (paper {PAPER_PERCENT_OF_SIMULATED[model]} %)"
        )
    if benchmark.enabled:
        assert per_order <= PAPER_S_PER_ORDER[model] / 50
        assert percent <= PAPER_PERCENT_OF_SIMULATED[model] / 50
