"""Decision time of the joint models: the aggregated form against the printed one with CBC, on the same periods.

`make bench` measures; both sides are timed in one run, reading the period, building the model and solving it included.
"""

from __future__ import annotations

import time
from statistics import median
from typing import Any

import numpy as np
import pytest
from attrs import frozen
from rmfs_mip import rules
from rmfs_mip.paper import solve_printed
from rmfs_mip.period import Period
from rmfs_mip.search import search_for
from rmfs_mip.solution import Model
from rmfs_mip.solver import Limits

import rmfs_core

INSTANCE = ["instance.skus=100", "instance.pods=100", "instance.skus_per_pod=3"]
PAPER_S_PER_ORDER = {
    Model.INTEGRATED: 0.48,
    Model.SPLIT_AMONG_STATIONS: 1.06,
    Model.SPLIT_OVER_TIME: 1.34,
}
FASTER = {Model.INTEGRATED: 20, Model.SPLIT_AMONG_STATIONS: 20, Model.SPLIT_OVER_TIME: 500}


@frozen
class Recorded:
    """The periods t > 1 of a whole run and the seconds that each decision took."""

    periods: list[Period]
    seconds: list[float]


@pytest.fixture(scope="module")
def recorded() -> dict[Model, Recorded]:
    """Record a run of each model on a 250-order instance; t = 1 is cut short, it is not measured here."""
    runs = {}
    solve = rules._Joint.solve
    for model in Model:
        periods: list[Period] = []
        seconds: list[float] = []

        def record(rule: Any, period: Period, periods: list = periods, seconds: list = seconds) -> Any:
            start = time.perf_counter()
            solution = solve(rule, period)
            seconds.append(time.perf_counter() - start)
            periods.append(Period.from_json(period.stock, period.to_json()))
            return solution

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(rules._Joint, "solve", record)
            limit = "rules.poa_pps.max_seconds=10"
            result = rmfs_core.run(f"paper-250-{model}", overrides=[*INSTANCE, limit])
        assert result.status == "complete"
        runs[model] = Recorded(periods[1:], seconds[1:])
    return runs


@pytest.mark.slow
@pytest.mark.parametrize("model", Model)
def test_later_periods(benchmark: Any, recorded: dict[Model, Recorded], model: Model, capsys: Any) -> None:
    """Periods t > 1 against the printed form with CBC: median, 95th percentile, seconds per order."""
    run = recorded[model]
    ours, printed = [], []
    for period in run.periods[:: max(len(run.periods) // 60, 1)]:
        again = Period.from_json(period.stock, period.to_json())
        start = time.perf_counter()
        fast = search_for(again, model, 2, Limits()).run()
        ours.append(time.perf_counter() - start)
        start = time.perf_counter()
        slow = solve_printed(period, model, 2, Limits("cbc"))
        printed.append(time.perf_counter() - start)
        assert fast.objective == slow.objective
    per_order = sum(run.seconds) / 250
    tail = float(np.quantile(run.seconds, 0.95))
    with capsys.disabled():
        print(
            f"\n{model}: median {median(ours) * 1e3:.2f} ms against {median(printed) * 1e3:.1f} ms printed with CBC "
            f"({median(printed) / median(ours):.0f} times); 95th percentile {tail * 1e3:.1f} ms; "
            f"{per_order:.4f} s per order (paper {PAPER_S_PER_ORDER[model]})"
        )
    benchmark.pedantic(search_for(run.periods[0], model, 2, Limits()).run, rounds=1)
    if benchmark.enabled:
        assert median(printed) / median(ours) >= FASTER[model]
        assert median(ours) < 0.005
        assert tail < 0.03
        assert per_order <= PAPER_S_PER_ORDER[model] / 50
