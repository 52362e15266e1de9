"""Rule `pod-first`."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rmfs_commands.testing import small_world
from rmfs_core import BundleAssignment, BundleDecision, StoreBundle
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.replenishment import PodFirst

Make = Callable[[int], Warehouse]


def ticks(world: Warehouse, pod: int, station: int) -> int:
    """Driving time with a pod to a station."""
    return int(world.travel.times_to(world.stations[station].cell, True)[world.pods[pod].cell].min())


def test_bundles_of_a_pod_meet_at_the_station_next_to_it() -> None:
    """Both go onto the emptiest pod, and so to one station; the third has no room left there."""
    world = small_world({}, {"A": {"a": 8}, "B": {"a": 1}}, capacities=(9, 9), bundle_capacity=3, pod_capacity=10)
    near = min((0, 1), key=lambda station: ticks(world, 1, station))
    far = min((0, 1), key=lambda station: ticks(world, 0, station))
    for size in (4, 5, 2):
        world.bundle_arrives(0, size)
    expected = BundleDecision(
        [BundleAssignment(0, near), BundleAssignment(1, near), BundleAssignment(2, far)],
        [StoreBundle(0, 1), StoreBundle(1, 1), StoreBundle(2, 0)],
    )
    assert PodFirst().assign_bundles_and_pods(WarehouseView(world), 2) == expected


def test_a_pod_on_its_way_is_met_where_it_goes() -> None:
    """The pod is bound for the station that is farther from it."""
    world = small_world({}, {"A": {"a": 1}}, capacities=(9, 9), bundle_capacity=1)
    far = max((0, 1), key=lambda station: ticks(world, 0, station))
    world.bind(world.pods[0], world.stations[far])
    world.bundle_arrives(0, 1)
    decision = PodFirst().assign_bundles_and_pods(WarehouseView(world), 0)
    assert decision == BundleDecision([BundleAssignment(0, far)], [StoreBundle(0, 0)])


def test_of_stations_that_a_pod_visits_the_nearest_is_taken() -> None:
    """It is bound for both, for the farther one by the bundle that waits there."""
    world = small_world({}, {"A": {"a": 1}}, capacities=(9, 9), bundle_capacity=2)
    near, far = sorted((0, 1), key=lambda station: ticks(world, 0, station))
    world.bind(world.pods[0], world.stations[near])
    world.assign_bundle(world.bundle_arrives(0, 1), world.stations[far])
    world.bundle_arrives(0, 1)
    decision = PodFirst().assign_bundles_and_pods(WarehouseView(world), 0)
    assert decision == BundleDecision([BundleAssignment(1, near)], [StoreBundle(0, 0), StoreBundle(1, 0)])


def test_a_bundle_that_no_pod_can_take_waits_where_it_takes_no_place() -> None:
    """It stays in front of the stations, and the next one passes it; no robot, and it is the same."""
    world = small_world({}, {"A": {"a": 8}}, bundle_capacity=1, pod_capacity=10)
    for size in (3, 2):
        world.bundle_arrives(0, size)
    view = WarehouseView(world)
    assert PodFirst().assign_bundles_and_pods(view, 1) == BundleDecision([BundleAssignment(1, 0)], [StoreBundle(1, 0)])
    assert PodFirst().assign_bundles_and_pods(view, 0) == BundleDecision([], [])


def test_it_chooses_pods_as_another_rule_does() -> None:
    """By default the emptiest, else as the rule that is named; one that is none is refused."""
    world = small_world({}, {"A": {"a": 1}, "B": {"b": 9}}, bundle_capacity=1, pod_capacity=20)
    world.bundle_arrives(1, 1)
    for pod, expected in (("emptiest-pod", 0), ("same-sku", 1)):
        decision = PodFirst(pod=pod).assign_bundles_and_pods(WarehouseView(world), 1)
        assert [chosen.pod for chosen in decision.stores] == [expected]
    with pytest.raises(ValueError, match="first-come"):
        PodFirst(pod="first-come")


@pytest.mark.parametrize("seed", range(40))
@pytest.mark.parametrize("max_fetches", [0, 1, 9])
def test_whatever_it_decides_is_possible(seed: int, max_fetches: int, midway: Make) -> None:
    """No place, no space and no robot is used twice; what is left over finds no pod, or no place."""
    world = midway(seed)
    decision = PodFirst().assign_bundles_and_pods(WarehouseView(world), max_fetches)
    bundles = {bundle.id: bundle for bundle in world.bundles.values()}
    bundles |= {bundle.id: bundle for station in world.stations for bundle in station.bundles}
    for given in decision.assignments:
        assert world.stations[given.station].free_bundle_capacity > 0
        world.assign_bundle(bundles[given.bundle], world.stations[given.station])
    for chosen in decision.stores:
        pod, bundle = world.pods[chosen.pod], bundles[chosen.bundle]
        assert pod.free_space >= bundle.size
        max_fetches -= not pod.bound_for
        world.bind_bundle(bundle, pod)
    assert max_fetches >= 0
    able = [pod.free_space for pod in world.pods if pod.bound_for or max_fetches]
    places = any(station.free_bundle_capacity for station in world.stations)
    left = [b for b in bundles.values() if b.pod is None and (b.station is not None or places)]
    assert all(bundle.size > max(able, default=0) for bundle in left)
