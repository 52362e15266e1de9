"""How quick the engine is when rules take next to no time. `make bench` measures."""

from __future__ import annotations

from typing import Any

import pytest

from rmfs_commands.bench.worlds import world_with
from rmfs_core.results.running import run
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice

QUICK = ["rules.pps=nearest-pod", "rules.pr=fixed"]


@pytest.mark.parametrize("world", ["small", "250", pytest.param("2000", marks=pytest.mark.slow)])
def test_a_run_with_quick_rules(benchmark: Any, world: str) -> None:
    """A whole run; `engine_s` is what is left of it without the rules' own time, `picks_per_s` what that comes to."""
    scenario = world_with(world, Role.POA, RuleChoice("first-come"), QUICK)
    result = benchmark(run, scenario)
    assert result.status == "complete"
    engine_s = result.timing["wall_s"] - sum(result.timing["hook_s"].values())
    benchmark.extra_info.update(engine_s=engine_s, picks_per_s=result.metrics["picks"] / engine_s)
