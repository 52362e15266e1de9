"""How long every shipped rule takes per call, in the middle of a run, on three sizes of world. `make bench` measures.

A run is stopped where the rule is asked for the first time after `MIDDLE_S` seconds, and asked again and again there,
with the view, and for path planners the traffic, that it has then.
"""

from __future__ import annotations

from importlib.metadata import entry_points
from typing import Any

import pluggy
import pytest

from rmfs_commands.bench.worlds import WORLDS, world_with
from rmfs_core.results.running import run
from rmfs_core.roles import Role
from rmfs_core.rules import BoundRule
from rmfs_core.rules.hooks import roles_of
from rmfs_core.scenario import RuleChoice
from rmfs_core.simulation.asking import Asker

MIDDLE_S = 300
PARAMETERS: dict[str, dict[str, Any]] = {
    "most-covered": {"n": 10},
    "switch": {"cases": [{"rule": "random"}]},
    # Only later periods are measured here; tests/benchmarks/test_mip_first_period.py has the first.
    "integrated": {"max_seconds": 1.0},
    "split-among-stations": {"max_seconds": 1.0},
    "split-over-time": {"max_seconds": 1.0},
}
PREFILTER = 'rules.filters=[{rule="most-covered",n=10}]'
"""What the paper puts before its models where there are 2000 orders."""

SHIPPED = sorted(
    (entry.name, role)
    for entry in entry_points(group="rmfs.rules")
    if entry.dist is not None and entry.dist.name == "rmfs"
    for role in roles_of(entry.load())
    if role is not Role.OBSERVER  # a rule that is told when a run begins decides nothing then
)
"""Each rule, once for each decision that it makes."""
LONG = [pytest.mark.slow]
NAMES = [pytest.param(name, role, marks=LONG if name == "integrated" else []) for name, role in SHIPPED]
SIZES = [world if world == "small" else pytest.param(world, marks=pytest.mark.slow) for world in WORLDS]


class _MeasuredError(Exception):
    """The run has served its purpose."""


@pytest.mark.parametrize("world", SIZES)
@pytest.mark.parametrize(("name", "role"), NAMES)
def test_one_call(benchmark: Any, monkeypatch: pytest.MonkeyPatch, name: str, role: Role, world: str) -> None:
    """Median of a call in the middle of a run."""
    overrides = [PREFILTER] if role is Role.POA_PPS and world == "2000" else []
    scenario = world_with(world, role, RuleChoice(name, PARAMETERS.get(name, {})), overrides)
    asked = Asker.ask

    benchmark.group = world

    def ask(asker: Asker, rule: BoundRule, arguments: dict[str, Any], hook: pluggy.HookCaller | None = None) -> Any:
        if hook is None and rule.role is role and arguments["warehouse"].now_tick >= MIDDLE_S * 1000:
            benchmark.extra_info["backlog"] = len(arguments["warehouse"].backlog)
            benchmark(rule.hook, **arguments)
            raise _MeasuredError
        return asked(asker, rule, arguments, hook)

    monkeypatch.setattr(Asker, "ask", ask)
    with pytest.raises(_MeasuredError):
        run(scenario)
