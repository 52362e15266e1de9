"""Rules for bundles: which station, which pod, or both at once; by hand and against their definitions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest

import rmfs_core
from replenished import replenished_world
from rmfs_commands.testing import small_world
from rmfs_core import BundleAssignment, BundleDecision, StoreBundle, hookimpl
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_core.warehouse import Bundle, Pod, Station, Warehouse, WarehouseView
from rmfs_rules.random import Random
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
from rmfs_rules.replenishment.pods import POD_RULES

SKUS = "abcdef"


@pytest.fixture
def midway() -> Callable[[int], Warehouse]:
    """Return a function that makes a random world: two stations, bundles everywhere, pods stored and on their way."""

    def make(seed: int) -> Warehouse:
        rng = np.random.default_rng(seed)

        def some(most: int) -> dict[str, int]:
            skus = rng.choice(list(SKUS), int(rng.integers(1, 4)), replace=False)
            return {str(sku): int(rng.integers(1, most)) for sku in skus}

        pods = {"all": dict.fromkeys(SKUS, 1)} | {str(i): some(6) for i in range(int(rng.integers(2, 12)))}
        orders = {str(i): some(2) for i in range(int(rng.integers(0, 9)))}
        capacity = None if rng.random() < 0.2 else int(rng.integers(15, 22))
        world = small_world(orders, pods, capacities=(9, 9), robots=4, bundle_capacity=4, pod_capacity=capacity)
        for pod in rng.permutation(len(world.pods))[: int(rng.integers(0, 4))].tolist():
            world.bind(world.pods[pod], world.stations[int(rng.integers(2))])
        for _ in range(int(rng.integers(1, 9))):
            bundle = world.bundle_arrives(int(rng.integers(len(SKUS))), int(rng.integers(1, 9)))
            station = world.stations[int(rng.integers(2))]
            if rng.random() < 0.7 and station.free_bundle_capacity:
                world.assign_bundle(bundle, station)
                fitting = [pod for pod in world.pods if pod.free_space >= bundle.size]
                if rng.random() < 0.3 and fitting:
                    world.bind_bundle(bundle, fitting[int(rng.integers(len(fitting)))])
        return world

    return make


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
    warehouse = with_bundles(1, 1, 1, assigned=False, capacity=2)
    assert FirstBundle().assign_bundles(WarehouseView(warehouse)) == [BundleAssignment(0, 1), BundleAssignment(1, 1)]


def test_emptiest_pod_counts_the_space_that_it_gives_away() -> None:
    chosen = EmptiestPod().select_replenishment_pods(WarehouseView(with_bundles(5, 4, 6)), 9)
    assert chosen == [StoreBundle(0, 1), StoreBundle(1, 0)]


def test_emptiest_pod_without_robots() -> None:
    warehouse = with_bundles(1, 5)
    warehouse.bind(warehouse.pods[2], warehouse.stations[0])
    assert EmptiestPod().select_replenishment_pods(WarehouseView(warehouse), 0) == [StoreBundle(0, 2)]


def test_emptiest_pod_needs_one_robot_a_pod() -> None:
    warehouse = with_bundles(4, 4)
    assert EmptiestPod().select_replenishment_pods(WarehouseView(warehouse), 1) == [
        StoreBundle(0, 1),
        StoreBundle(1, 1),
    ]


Make = Callable[[int], Warehouse]


def world_with(*sizes: int, **pods: dict[str, int]) -> Warehouse:
    """Return a world with two stations, pods that hold ten items, and bundles of these sizes that wait."""
    world = small_world({}, pods, capacities=(9, 9), bundle_capacity=3, pod_capacity=10)
    for size in sizes:
        world.bundle_arrives(0, size)
    return world


def stations(answer: list[BundleAssignment]) -> list[int]:
    """Return the stations of the bundles, which are assigned oldest first."""
    assert [given.bundle for given in answer] == list(range(len(answer)))
    return [given.station for given in answer]


def test_first_bundle_takes_turns() -> None:
    assert stations([*FirstBundle().assign_bundles(WarehouseView(world_with(*[1] * 9, A={"a": 1})))]) == [0, 1] * 3


def test_same_pod_fills_a_pod() -> None:
    world = world_with(5, 3, 6, 2, 7, A={"a": 2}, B={"a": 4})
    assert stations([*SamePod().assign_bundles(WarehouseView(world))]) == [0, 0, 1, 1, 0]


def test_same_pod_uses_a_pod_that_comes_anyway() -> None:
    world = world_with(4, 6, 6, A={"a": 1}, B={"a": 0})
    world.bind(world.pods[1], world.stations[1])
    assert stations([*SamePod().assign_bundles(WarehouseView(world))]) == [1, 1, 0]


def test_same_pod_counts_bundles_without_a_pod() -> None:
    world = world_with(6, A={"a": 1})
    world.assign_bundle(world.bundles[0], world.stations[0])
    world.bundle_arrives(0, 4)
    assert SamePod().assign_bundles(WarehouseView(world)) == [BundleAssignment(1, 1)]


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("rule", [FirstBundle(), SamePod(), Random()], ids=lambda rule: type(rule).__name__)
def test_every_place_is_used(rule: FirstBundle | SamePod | Random, seed: int, midway: Make) -> None:
    world = midway(seed)
    arguments = (np.random.default_rng(seed),) if isinstance(rule, Random) else ()
    for given in rule.assign_bundles(WarehouseView(world), *arguments):
        assert world.stations[given.station].free_bundle_capacity > 0
        world.assign_bundle(world.bundles[given.bundle], world.stations[given.station])
    assert not world.bundles or not any(station.free_bundle_capacity for station in world.stations)


Cost = Callable[[Warehouse, Pod, Bundle], float]


def ticks(world: Warehouse, pod: Pod, station: Station) -> int:
    """Driving time with a pod to a station."""
    return int(world.travel.times_to(station.cell, True)[pod.cell].min())


def items(pod: Pod, sku: int) -> int:
    """Items of a SKU on a pod that are promised to nobody, and of bundles to come."""
    return pod.free_items(sku) + sum(bundle.items for bundle in pod.bundles if bundle.sku == sku)


def skus(world: Warehouse, pod: Pod) -> Iterable[int]:
    """SKUs that a pod has, or is to have."""
    return [sku for sku in range(world.n_skus) if items(pod, sku)]


def ordered(world: Warehouse, sku: int) -> int:
    """Items ordered of a SKU."""
    return sum(line.quantity for order in world.orders for line in order.lines if line.sku == sku)


def together(world: Warehouse, pod: Pod, bundle: Bundle) -> int:
    """For all SKUs of a pod, the orders with the bundle's SKU and it."""
    lines = [{line.sku for line in order.lines} for order in world.orders]
    return sum({bundle.sku, sku} <= wanted for sku in skus(world, pod) if sku != bundle.sku for wanted in lines)


def classed(worth: list[int]) -> list[int]:
    """Class of each thing: 10 %, 20 % and 70 % of them, those that are worth most first."""
    ranked = sorted(range(len(worth)), key=lambda i: (-worth[i], i))
    ends = [math.floor(0.1 * len(worth)), math.floor(0.3 * len(worth))]
    return [sum(ranked.index(i) >= end for end in ends) for i in range(len(worth))]


def turn(world: Warehouse, pod: Pod, bundle: Bundle) -> int:
    """When a pod's class is looked at: the bundle's, one down, one up, two down, two up."""
    of_skus = classed([ordered(world, sku) for sku in range(world.n_skus)])
    of_pods = classed([sum(ordered(world, sku) for sku in skus(world, other)) for other in world.pods])
    return [0, 1, -1, 2, -2].index(of_pods[pod.id] - of_skus[bundle.sku])


RULES: list[tuple[Any, Cost]] = [
    (EmptiestPod, lambda _world, pod, _bundle: -pod.free_space),
    (NearestPodWithRoom, lambda _world, _pod, _bundle: 0),
    (SameSku, lambda _world, pod, bundle: -items(pod, bundle.sku)),
    (SpreadSku, lambda _world, pod, bundle: items(pod, bundle.sku)),
    (Correlated, lambda world, pod, bundle: -together(world, pod, bundle)),
    (LeastDemand, lambda world, pod, _bundle: sum(int(world.open_demand[sku]) for sku in skus(world, pod))),
    (TurnoverPod, turn),
]


def literal(world: Warehouse, max_fetches: int, cost: Cost) -> list[StoreBundle]:
    """Choose one pod after another by the definition, and carry each choice out before the next one."""
    chosen = []
    for station in world.storing:
        for bundle in [bundle for bundle in station.bundles if bundle.pod is None]:
            able = [
                pod
                for pod in world.pods
                if pod.free_space >= bundle.size and (pod.bound_for or (max_fetches > 0 and pod.location is not None))
            ]
            if able:
                best = min(able, key=lambda pod: (cost(world, pod, bundle), ticks(world, pod, station), pod.id))
                max_fetches -= not best.bound_for
                world.bind_bundle(bundle, best)
                chosen.append(StoreBundle(bundle.id, best.id))
    return chosen


@pytest.mark.parametrize(("rule", "cost"), RULES, ids=lambda value: getattr(value, "__name__", ""))
@pytest.mark.parametrize("max_fetches", [0, 1, 9])
def test_random_worlds(rule: Any, cost: Cost, max_fetches: int, midway: Make) -> None:
    used = rule()
    for seed in range(30):
        found = used.select_replenishment_pods(WarehouseView(midway(seed)), max_fetches)
        assert found == literal(midway(seed), max_fetches, cost), seed


@pytest.mark.parametrize("seed", range(20))
def test_random_draws_pods_that_can_take_the_bundles(seed: int, midway: Make) -> None:
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
    orders = {"1": {"a": 3, "c": 1}, "2": {"a": 3, "c": 1}, "3": {"a": 1, "b": 2}}
    pods = {"A": {"d": 3}, "B": {"a": 1, "b": 3}, "C": {"a": 4}, "D": {"c": 1}}
    world = small_world(orders, pods, bundle_capacity=2, pod_capacity=10)
    station = world.stations[0]
    assert min(world.pods, key=lambda pod: ticks(world, pod, station)).name == "A"
    world.assign_bundle(world.bundle_arrives(1, 2), station)  # SKUs are d, a, b, c
    (chosen,) = rule.select_replenishment_pods(WarehouseView(world), 1)
    assert world.pods[chosen.pod].name == expected


def test_a_used_rule_forgets_the_run_before() -> None:
    pods = {"A": {"a": 1}, "B": {"b": 1}, "C": {"c": 1}}
    rule = Correlated()
    for partner in "bc":
        world = small_world({"1": {"a": 1, partner: 1}}, pods, bundle_capacity=1)
        world.assign_bundle(world.bundle_arrives(0, 1), world.stations[0])
        (chosen,) = rule.select_replenishment_pods(WarehouseView(world), 1)
        assert world.pods[chosen.pod].name == partner.upper()


@pytest.mark.parametrize("borders", [(), (0.3,), (0.5, 0.4, 1.0), (0.0, 1.0)])
def test_borders_rise_to_one(borders: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="expected shares above 0 that rise to 1"):
        TurnoverPod(borders=borders)


class Doubter:
    """Observer that has each choice made once more, by a rule that remembers nothing."""

    def __init__(self, rule: type[Any]) -> None:
        self.rule, self.lots, self.stores = rule, np.random.default_rng(), 0

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        if question.decides is Role.RPS and question.rng is not None:
            self.lots.bit_generator.state = question.rng.bit_generator.state

    @hookimpl
    def rule_answered(self, question: Question, answer: Any) -> None:
        if question.decides is Role.RPS:
            given = (self.lots,) if self.rule is Random else ()
            most = question.arguments["max_fetches"]
            assert list(answer) == list(self.rule().select_replenishment_pods(question.warehouse, most, *given))
            self.stores += len(answer)


@pytest.mark.parametrize("rule", [*POD_RULES.values(), Random])
def test_what_is_kept_decides_as_what_is_read_anew(rule: type[Any]) -> None:
    doubter = Doubter(rule)
    overrides = ["run.until_s=3000", "rules.pp=free-flow"]
    rmfs_core.run("examples/replenished", overrides=overrides, rules={"rps": rule()}, observers=[doubter])
    assert doubter.stores > 10


def ticks_to(world: Warehouse, pod: int, station: int) -> int:
    """Driving time with a pod to a station."""
    return int(world.travel.times_to(world.stations[station].cell, True)[world.pods[pod].cell].min())


def test_bundles_of_a_pod_meet_at_the_station_next_to_it() -> None:
    world = small_world({}, {"A": {"a": 8}, "B": {"a": 1}}, capacities=(9, 9), bundle_capacity=3, pod_capacity=10)
    near = min((0, 1), key=lambda station: ticks_to(world, 1, station))
    far = min((0, 1), key=lambda station: ticks_to(world, 0, station))
    for size in (4, 5, 2):
        world.bundle_arrives(0, size)
    expected = BundleDecision(
        [BundleAssignment(0, near), BundleAssignment(1, near), BundleAssignment(2, far)],
        [StoreBundle(0, 1), StoreBundle(1, 1), StoreBundle(2, 0)],
    )
    assert PodFirst().assign_bundles_and_pods(WarehouseView(world), 2) == expected


def test_a_pod_on_its_way_is_met_where_it_goes() -> None:
    world = small_world({}, {"A": {"a": 1}}, capacities=(9, 9), bundle_capacity=1)
    far = max((0, 1), key=lambda station: ticks_to(world, 0, station))
    world.bind(world.pods[0], world.stations[far])
    world.bundle_arrives(0, 1)
    decision = PodFirst().assign_bundles_and_pods(WarehouseView(world), 0)
    assert decision == BundleDecision([BundleAssignment(0, far)], [StoreBundle(0, 0)])


def test_of_stations_that_a_pod_visits_the_nearest_is_taken() -> None:
    """It is bound for both, for the farther one by the bundle that waits there."""
    world = small_world({}, {"A": {"a": 1}}, capacities=(9, 9), bundle_capacity=2)
    near, far = sorted((0, 1), key=lambda station: ticks_to(world, 0, station))
    world.bind(world.pods[0], world.stations[near])
    world.assign_bundle(world.bundle_arrives(0, 1), world.stations[far])
    world.bundle_arrives(0, 1)
    decision = PodFirst().assign_bundles_and_pods(WarehouseView(world), 0)
    assert decision == BundleDecision([BundleAssignment(1, near)], [StoreBundle(0, 0), StoreBundle(1, 0)])


def test_a_bundle_that_no_pod_can_take_waits_where_it_takes_no_place() -> None:
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
