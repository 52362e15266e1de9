"""Five days with replenishment, and the grocery day under each rule set: complete, possible, fast.

`make bench` holds the bars. CPU time is that of one core, without start-up and without a trace.
"""

import time
import tomllib
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from rmfs_commands.validation import validate_trace

LEAST_SPEED = 500
"""Simulated seconds that a CPU second shall bring."""


def timed(benchmark: Any, scenario: str, overrides: list[str]) -> tuple[Any, float]:
    """Run a scenario; return its result, and the simulated seconds per CPU second."""
    rmfs_core.run(scenario, overrides=[*overrides, "run.until_s=22000"])  # what is compiled once is loaded
    taken = []

    def run() -> Any:
        start = time.process_time()
        result = rmfs_core.run(scenario, overrides=overrides)
        taken.append(time.process_time() - start)
        return result

    result = benchmark.pedantic(run, rounds=1)
    assert result.status == "complete"
    return result, result.metrics["simulated_s"] / taken[0]


def traced(benchmark: Any, scenario: str, overrides: list[str], out: Path) -> Any:
    """Run a scenario where nothing is timed; what the run reported is what its trace amounts to."""
    options = {"overrides": overrides, "out": out, "record": ["trace"]}
    result = benchmark.pedantic(rmfs_core.run, args=(scenario,), kwargs=options, rounds=1)
    assert validate_trace(out) == []
    return result


def test_five_days(benchmark: Any, tmp_path: Path) -> None:
    """Every order is complete, though most of what is picked was not there at first.

    Where nothing is timed, the first day: the validator follows every item and every pod's capacity through it.
    """
    if not benchmark.enabled:
        result = traced(benchmark, "multi-day", ["instance.orders=4008"], tmp_path)
        assert (result.status, result.metrics["bundles_stored"] > 100) == ("complete", True)
        return
    result, speed = timed(benchmark, "multi-day", [])
    assert result.metrics["items_stored"] > 2 * result.metrics["items_in_stock_mean"]
    benchmark.extra_info.update(simulated_s_per_cpu_s=speed)
    assert speed >= LEAST_SPEED


SCENARIOS = Path(__file__).resolve().parents[2] / "scenarios"
EXPERIMENT = tomllib.loads((SCENARIOS / "experiments" / "grocery-day.toml").read_text(encoding="utf-8"))
RULES = {
    entry["name"]: [f"rules.{role}={rule}" for role, rule in entry["rules"].items()]
    for entry in EXPERIMENT["rule_sets"]
}


@pytest.mark.parametrize("name", RULES)
def test_the_whole_day(benchmark: Any, name: str, tmp_path: Path) -> None:
    """Every order is complete; bars: simulated seconds per CPU second, and no decision takes longer than 5 s.

    Where nothing is timed, the day until nine, about 80 orders, or seven under the models.
    """
    if not benchmark.enabled:
        end_s = 32400 if name in ("sequential", "pod-index") else 25200
        result = traced(benchmark, "grocery-day", [*RULES[name], f"run.until_s={end_s}"], tmp_path)
        assert result.metrics["orders_completed"] > 0
        return
    result, speed = timed(benchmark, "grocery-day", RULES[name])
    assert result.metrics["orders_completed"] == 560
    longest = max(period["seconds"] for period in result.periods)
    benchmark.extra_info.update(simulated_s_per_cpu_s=speed, longest_period_s=longest)
    assert speed >= (1000 if name == "sequential" else 150)
    assert longest <= 5.0
