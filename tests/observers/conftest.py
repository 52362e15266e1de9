"""A tiny run to observe."""

from __future__ import annotations

import pytest

from rmfs_core.motion import Motion
from rmfs_core.scenario.model import RuleChoice, RulesSection, Scenario
from rmfs_core.simulation.info import RunInfo
from rmfs_core.testing import small_instance, small_layout, small_world
from rmfs_core.warehouse import WarehouseView


@pytest.fixture
def tiny() -> RunInfo:
    """Two stations, two robots; orders ``first`` (a, b) at 0 s, ``second`` (two of a) at 5 s; pods ``p`` and ``q``."""
    orders = {"first": ["a", "b"], "second": {"a": 2}}
    pods = {"p": {"a": 10, "b": 10}, "q": ["b"]}
    return RunInfo(
        scenario=Scenario(rules=RulesSection(poa=RuleChoice("first-come"), pps=RuleChoice("demand")), seed=7),
        instance=small_instance(orders, pods, arrivals_s={"second": 5.0}),
        layout=small_layout(2),
        motion=Motion(),
        warehouse=WarehouseView(small_world(orders, pods, capacities=(4, 4))),
    )
