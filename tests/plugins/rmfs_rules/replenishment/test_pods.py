"""RPS rules by hand, and what they keep from call to call."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rmfs_core
from rmfs_commands.testing import small_world
from rmfs_core import hookimpl
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_core.warehouse import Pod, Station, Warehouse, WarehouseView
from rmfs_rules.random import Random
from rmfs_rules.replenishment import (
    Correlated,
    EmptiestPod,
    LeastDemand,
    NearestPodWithRoom,
    SameSku,
    SpreadSku,
    TurnoverPod,
)
from rmfs_rules.replenishment.pods import POD_RULES

Make = Callable[[int], Warehouse]


def ticks(world: Warehouse, pod: Pod, station: Station) -> int:
    """Driving time with a pod to a station."""
    return int(world.travel.times_to(station.cell, True)[pod.cell].min())


@pytest.mark.parametrize("seed", range(20))
def test_random_draws_pods_that_can_take_the_bundles(seed: int, midway: Make) -> None:
    """Whatever is drawn can be carried out; every bundle gets a pod that could have one."""
    world = midway(seed)
    rng = np.random.default_rng(seed)
    for chosen in Random().select_replenishment_pods(WarehouseView(world), 9, rng):
        bundle = next(b for station in world.storing for b in station.bundles if b.id == chosen.bundle)
        assert world.pods[chosen.pod].free_space >= bundle.size
        world.bind_bundle(bundle, world.pods[chosen.pod])
    room = max(pod.free_space for pod in world.pods)
    assert all(b.size > room for station in world.storing for b in station.bundles if b.pod is None)


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        (EmptiestPod(), "D"),  # 9 of 10 free
        (NearestPodWithRoom(), "A"),
        (SameSku(), "C"),  # 4 of SKU a
        (SpreadSku(), "A"),  # none, as D, but A is nearer
        (Correlated(), "D"),  # has SKU c, which two orders want together with a; b is wanted with it once
        (LeastDemand(), "A"),  # nobody wants SKU d
        (TurnoverPod(borders=(0.25, 1.0)), "B"),  # a is the fastest SKU, and B the fastest pod
    ],
    ids=lambda value: type(value).__name__ if not isinstance(value, str) else value,
)
def test_by_hand(rule: Any, expected: str) -> None:
    """One bundle of SKU a, four pods; the first in the row is the nearest to the station."""
    orders = {"1": {"a": 3, "c": 1}, "2": {"a": 3, "c": 1}, "3": {"a": 1, "b": 2}}
    pods = {"A": {"d": 3}, "B": {"a": 1, "b": 3}, "C": {"a": 4}, "D": {"c": 1}}
    world = small_world(orders, pods, bundle_capacity=2, pod_capacity=10)
    station = world.stations[0]
    assert min(world.pods, key=lambda pod: ticks(world, pod, station)).name == "A"
    world.assign_bundle(world.bundle_arrives(1, 2), station)  # SKUs are d, a, b, c
    (chosen,) = rule.select_replenishment_pods(WarehouseView(world), 1)
    assert world.pods[chosen.pod].name == expected


def test_a_used_rule_forgets_the_run_before() -> None:
    """Orders of another run count for nothing."""
    pods = {"A": {"a": 1}, "B": {"b": 1}, "C": {"c": 1}}
    rule = Correlated()
    for partner in "bc":
        world = small_world({"1": {"a": 1, partner: 1}}, pods, bundle_capacity=1)
        world.assign_bundle(world.bundle_arrives(0, 1), world.stations[0])
        (chosen,) = rule.select_replenishment_pods(WarehouseView(world), 1)
        assert world.pods[chosen.pod].name == partner.upper()


@pytest.mark.parametrize("borders", [(), (0.3,), (0.5, 0.4, 1.0), (0.0, 1.0)])
def test_borders_rise_to_one(borders: tuple[float, ...]) -> None:
    """Any other are refused."""
    with pytest.raises(ValueError, match="expected shares above 0 that rise to 1"):
        TurnoverPod(borders=borders)


class Doubter:
    """Observer that has each choice made once more, by a rule that remembers nothing."""

    def __init__(self, rule: type[Any]) -> None:
        self.rule, self.lots, self.stores = rule, np.random.default_rng(), 0

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        """Note which lots will be drawn."""
        if question.decides is Role.RPS and question.rng is not None:
            self.lots.bit_generator.state = question.rng.bit_generator.state

    @hookimpl
    def rule_answered(self, question: Question, answer: Any) -> None:
        """Compare."""
        if question.decides is Role.RPS:
            given = (self.lots,) if self.rule is Random else ()
            most = question.arguments["max_fetches"]
            assert list(answer) == list(self.rule().select_replenishment_pods(question.warehouse, most, *given))
            self.stores += len(answer)


@pytest.mark.parametrize("rule", [*POD_RULES.values(), Random])
def test_what_is_kept_decides_as_what_is_read_anew(rule: type[Any]) -> None:
    """In whole runs: pods come and go, and are given SKUs that they never held."""
    doubter = Doubter(rule)
    overrides = ["run.until_s=3000", "rules.pp=free-flow"]
    rmfs_core.run("examples/replenished", overrides=overrides, rules={"rps": rule()}, observers=[doubter])
    assert doubter.stores > 10
