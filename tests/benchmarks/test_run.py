"""How long a whole run takes, and the command line's start. `make bench` measures; the bars are asserted there only."""

import os
import subprocess
import sys
from statistics import median
from typing import Any

import pytest

import rmfs_core


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
