"""ROA and RPS rules."""

from __future__ import annotations

from replenished import replenished_world
from rmfs_core import BundleAssignment, StoreBundle
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.replenishment import EmptiestPod, FirstBundle


def with_bundles(*items: int, assigned: bool = True, capacity: int = 9) -> Warehouse:
    """Return a warehouse with pods that have 6, 8 and 2 of 10 free, and bundles of SKU a."""
    pods = {"p": {"a": 4}, "q": {"b": 2}, "r": {"a": 8}}
    warehouse = replenished_world({}, pods, pod_capacity=10, bundle_capacity=capacity)
    for number in items:
        bundle = warehouse.bundle_arrives(0, number)
        if assigned:
            warehouse.assign_bundle(bundle, warehouse.stations[1])
    return warehouse


def test_first_bundle_fills_the_places_with_the_oldest() -> None:
    """Two places: the third bundle waits."""
    warehouse = with_bundles(1, 1, 1, assigned=False, capacity=2)
    assert FirstBundle().assign_bundles(WarehouseView(warehouse)) == [BundleAssignment(0, 1), BundleAssignment(1, 1)]


def test_emptiest_pod_counts_the_space_that_it_gives_away() -> None:
    """8 free on q, then 3, less than the 6 of p; the last one fits nowhere."""
    chosen = EmptiestPod().select_replenishment_pods(WarehouseView(with_bundles(5, 4, 6)), 9)
    assert chosen == [StoreBundle(0, 1), StoreBundle(1, 0)]


def test_emptiest_pod_without_robots() -> None:
    """Only pods that are bound for a station already can come, however full."""
    warehouse = with_bundles(1, 5)
    warehouse.bind(warehouse.pods[2], warehouse.stations[0])
    assert EmptiestPod().select_replenishment_pods(WarehouseView(warehouse), 0) == [StoreBundle(0, 2)]


def test_emptiest_pod_needs_one_robot_a_pod() -> None:
    """Both bundles go to the pod that one robot fetches."""
    warehouse = with_bundles(4, 4)
    assert EmptiestPod().select_replenishment_pods(WarehouseView(warehouse), 1) == [
        StoreBundle(0, 1),
        StoreBundle(1, 1),
    ]
