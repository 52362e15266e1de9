"""Rules for bundles: which pod, by hand; test_oracles.py has all of them on random worlds."""

from typing import Any

import pytest

from cases import cases
from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Pod, Station, Warehouse, WarehouseView
from rmfs_rules.replenishment import (
    Correlated,
    EmptiestPod,
    LeastDemand,
    NearestPodWithRoom,
    PodFirst,
    SameSku,
    SpreadSku,
    TurnoverPod,
)


def ticks(world: Warehouse, pod: Pod, station: Station) -> int:
    return int(world.travel.times_to(station.cell, True)[pod.cell].min())


@cases(
    "rule expected",
    (EmptiestPod(), "D"),  # 9 of 10 free
    (NearestPodWithRoom(), "A"),
    (SameSku(), "C"),  # 4 of SKU a
    (SpreadSku(), "A"),  # none, as D, but A is nearer
    (Correlated(), "D"),  # has SKU c, which two orders want together with a; b is wanted with it once
    (LeastDemand(), "A"),  # nobody wants SKU d
    (TurnoverPod(borders=(0.25, 1.0)), "B"),  # a is the fastest SKU, and B the fastest pod
    ids=lambda value: type(value).__name__ if not isinstance(value, str) else value,
)
def test_by_hand(rule: Any, expected: str) -> None:
    orders = {"1": {"a": 3, "c": 1}, "2": {"a": 3, "c": 1}, "3": {"a": 1, "b": 2}}
    pods = {"A": {"d": 3}, "B": {"a": 1, "b": 3}, "C": {"a": 4}, "D": {"c": 1}}
    world = small_world(orders, pods, bundle_capacity=2, pod_capacity=10)
    station = world.stations[0]
    assert min(world.pods, key=lambda pod: ticks(world, pod, station)).name == "A"
    world.assign_bundle(world.bundle_arrives(1, 2), station)  # SKUs are d, a, b, c
    (chosen,) = rule.select_replenishment_pods(WarehouseView(world), 1)
    assert world.pods[chosen.pod].name == expected


@cases(
    "rule wrong problem",
    (TurnoverPod, {"borders": (0.5, 0.4, 1.0)}, "expected shares above 0 that rise to 1"),
    (PodFirst, {"pod": "first-come"}, "first-come"),
)
def test_wrong_parameters_are_refused(rule: type[Any], wrong: dict[str, Any], problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        rule(**wrong)
