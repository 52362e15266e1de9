"""Rules for bundles: which station, which pod, or both at once; by hand and against their definitions."""

from typing import Any

import pytest

from cases import cases
from replenished import replenished_world
from rmfs_commands.testing import small_world
from rmfs_core import BundleAssignment, BundleDecision, StoreBundle
from rmfs_core.warehouse import Pod, Station, Warehouse, WarehouseView
from rmfs_rules.replenishment import (
    Correlated,
    EmptiestPod,
    FirstBundle,
    LeastDemand,
    NearestPodWithRoom,
    PodFirst,
    SamePod,
    SameSku,
    SpreadSku,
    TurnoverPod,
)


def test_rules_for_bundles_by_hand() -> None:
    warehouse = replenished_world({}, {"p": {"a": 4}, "q": {"b": 2}, "r": {"a": 8}}, pod_capacity=10, bundle_capacity=9)
    for number in (5, 4, 6):
        warehouse.assign_bundle(warehouse.bundle_arrives(0, number), warehouse.stations[1])
    chosen = EmptiestPod().select_replenishment_pods(WarehouseView(warehouse), 9)
    assert chosen == [StoreBundle(0, 1), StoreBundle(1, 0)]
    assert stations([*FirstBundle().assign_bundles(WarehouseView(world_with(*[1] * 9, A={"a": 1})))]) == [0, 1] * 3
    world = world_with(5, 3, 6, 2, 7, A={"a": 2}, B={"a": 4})
    assert stations([*SamePod().assign_bundles(WarehouseView(world))]) == [0, 0, 1, 1, 0]


def world_with(*sizes: int, **pods: dict[str, int]) -> Warehouse:
    """Return a world with two stations, pods that hold ten items, and bundles of these sizes that wait."""
    world = small_world({}, pods, capacities=(9, 9), bundle_capacity=3, pod_capacity=10)
    for size in sizes:
        world.bundle_arrives(0, size)
    return world


def stations(answer: list[BundleAssignment]) -> list[int]:
    assert [given.bundle for given in answer] == list(range(len(answer)))
    return [given.station for given in answer]


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


@pytest.mark.parametrize("borders", [(), (0.3,), (0.5, 0.4, 1.0), (0.0, 1.0)])
def test_borders_rise_to_one(borders: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="expected shares above 0 that rise to 1"):
        TurnoverPod(borders=borders)


def test_bundles_of_a_pod_meet_at_the_station_next_to_it() -> None:
    world = small_world({}, {"A": {"a": 8}, "B": {"a": 1}}, capacities=(9, 9), bundle_capacity=3, pod_capacity=10)
    near, far = (min(world.picking, key=lambda station: ticks(world, pod, station)).id for pod in world.pods[::-1])
    for size in (4, 5, 2):
        world.bundle_arrives(0, size)
    expected = BundleDecision(
        [BundleAssignment(0, near), BundleAssignment(1, near), BundleAssignment(2, far)],
        [StoreBundle(0, 1), StoreBundle(1, 1), StoreBundle(2, 0)],
    )
    assert PodFirst().assign_bundles_and_pods(WarehouseView(world), 2) == expected


def test_it_chooses_pods_as_another_rule_does() -> None:
    """By default the emptiest, else as the rule that is named; one that is none is refused."""
    world = small_world({}, {"A": {"a": 1}, "B": {"b": 9}}, bundle_capacity=1, pod_capacity=20)
    world.bundle_arrives(1, 1)
    for pod, expected in (("emptiest-pod", 0), ("same-sku", 1)):
        decision = PodFirst(pod=pod).assign_bundles_and_pods(WarehouseView(world), 1)
        assert [chosen.pod for chosen in decision.stores] == [expected]
    with pytest.raises(ValueError, match="first-come"):
        PodFirst(pod="first-come")
