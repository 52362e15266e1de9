"""How long every shipped rule takes per call, in the middle of a run, on three sizes of world. `make bench` measures.

A run is stopped where the rule is asked for the first time after `MIDDLE_S` seconds, and asked again and again there,
with the view, and for path planners the traffic, that it has then.
"""

from collections.abc import Callable
from importlib.metadata import entry_points
from typing import Any

import pytest

from rmfs.testing import rule_benchmark  # noqa: F401 (a fixture)
from rmfs_commands.bench.worlds import WORLDS
from rmfs_core.roles import Role
from rmfs_core.rules.hooks import roles_of
from rmfs_core.scenario import RuleChoice

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
"""The paper's prefilter for 2000 orders."""

SHIPPED = sorted(
    (entry.name, role)
    for entry in entry_points(group="rmfs.rules")
    if entry.dist is not None and entry.dist.name == "rmfs" and entry.name != "remote"
    for role in roles_of(entry.load())
    if role is not Role.OBSERVER  # a rule that is told when a run begins decides nothing then
)
"""Each rule, once for each decision that it makes."""


@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.parametrize(("name", "role"), SHIPPED)
def test_one_call(
    rule_benchmark: Callable[..., Any],  # noqa: F811 (how pytest hands over a fixture)
    benchmark: Any,
    name: str,
    role: Role,
    world: str,
) -> None:
    overrides = [PREFILTER] if role is Role.POA_PPS and world == "2000" else []
    choice = RuleChoice(name, PARAMETERS.get(name, {}))
    rule_benchmark(choice, decides=role.label, world=world, overrides=overrides, at_s=MIDDLE_S)
    benchmark.group = world  # as in the history of releases
