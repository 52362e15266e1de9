"""The grocery day under each rule set of its experiment: complete, possible, fast. `make bench` holds the bars.

CPU time is that of one core, without start-up and without a trace.
"""

from __future__ import annotations

import time
import tomllib
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from rmfs_commands.validation import validate_trace

SCENARIOS = Path(__file__).resolve().parents[2] / "scenarios"
EXPERIMENT = tomllib.loads((SCENARIOS / "experiments" / "grocery-day.toml").read_text(encoding="utf-8"))
RULES = {
    entry["name"]: [f"rules.{role}={rule}" for role, rule in entry["rules"].items()]
    for entry in EXPERIMENT["rule_sets"]
}
MOST_PERIOD_S = 5.0


def least_speed(name: str) -> float:
    """Return the simulated seconds that a CPU second shall bring."""
    return 1000 if name == "sequential" else 150


@pytest.mark.slow
@pytest.mark.parametrize("name", RULES)
def test_the_whole_day(benchmark: Any, name: str) -> None:
    """Every order is complete; bars: simulated seconds per CPU second, and no decision takes longer than 5 s.

    Where nothing is timed, the first hours will do.
    """
    overrides = RULES[name] if benchmark.enabled else [*RULES[name], "run.until_s=25200"]
    rmfs_core.run("grocery-day", overrides=[*RULES[name], "run.until_s=22000"])  # what is compiled once is loaded
    taken = []

    def run() -> Any:
        start = time.process_time()
        result = rmfs_core.run("grocery-day", overrides=overrides)
        taken.append(time.process_time() - start)
        return result

    result = benchmark.pedantic(run, rounds=1)
    assert result.metrics["orders_completed"] > 0
    if benchmark.enabled:
        assert result.status == "complete"
        assert result.metrics["orders_completed"] == 560
        speed = result.metrics["simulated_s"] / taken[0]
        longest = max(period["seconds"] for period in result.periods)
        benchmark.extra_info.update(simulated_s_per_cpu_s=speed, longest_period_s=longest)
        assert speed >= least_speed(name)
        assert longest <= MOST_PERIOD_S


@pytest.mark.slow
@pytest.mark.parametrize("name", RULES)
def test_the_morning_can_have_happened(name: str, tmp_path: Path) -> None:
    """Until nine, about 80 orders, or seven under the models: what the run reported is what its trace amounts to."""
    end_s = 32400 if name in ("sequential", "pod-index") else 25200
    overrides = [*RULES[name], f"run.until_s={end_s}"]
    rmfs_core.run("grocery-day", overrides=overrides, out=tmp_path, record=["trace"])
    assert validate_trace(tmp_path) == []


def test_a_few_orders_of_the_day(tmp_path: Path) -> None:
    """In time, possible, and with the columns that due times bring."""
    result = rmfs_core.run("grocery-day", overrides=["instance.orders=6"], out=tmp_path, record=["trace"])
    assert result.status == "complete"
    assert result.metrics["late_orders"] == 0
    assert {"on_time_percent_priority_1", "waiting_for_room_per_visit_s"} <= result.metrics.keys()
    assert validate_trace(tmp_path) == []
