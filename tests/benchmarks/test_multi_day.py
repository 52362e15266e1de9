"""Five days with replenishment: complete, possible, fast. `make bench` holds the bars.

CPU time is that of one core, without start-up and without a trace.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from rmfs_commands.validation import validate_trace

LEAST_SPEED = 500
"""Simulated seconds that a CPU second shall bring."""


@pytest.mark.slow
def test_five_days(benchmark: Any) -> None:
    """Every order is complete, though most of what is picked was not there at first.

    Where nothing is timed, the first hours will do.
    """
    overrides = [] if benchmark.enabled else ["run.until_s=25200"]
    rmfs_core.run("multi-day", overrides=["run.until_s=60"])  # what is compiled once is loaded
    taken = []

    def run() -> Any:
        start = time.process_time()
        result = rmfs_core.run("multi-day", overrides=overrides)
        taken.append(time.process_time() - start)
        return result

    result = benchmark.pedantic(run, rounds=1)
    assert result.metrics["items_stored"] > 0
    if benchmark.enabled:
        assert result.status == "complete"
        assert result.metrics["items_stored"] > 2 * result.metrics["items_in_stock_mean"]
        speed = result.metrics["simulated_s"] / taken[0]
        benchmark.extra_info.update(simulated_s_per_cpu_s=speed)
        assert speed >= LEAST_SPEED


@pytest.mark.slow
def test_a_day_of_it_has_no_fault(tmp_path: Path) -> None:
    """The validator follows every item and every pod's capacity through the orders of the first day."""
    result = rmfs_core.run("multi-day", overrides=["instance.orders=4008"], out=tmp_path, record=["trace"])
    assert result.status == "complete"
    assert result.metrics["bundles_stored"] > 100
    assert validate_trace(tmp_path) == []
