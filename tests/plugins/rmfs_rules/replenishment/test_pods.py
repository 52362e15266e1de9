"""RPS rules, by hand and against their definitions in plain Python."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest

import rmfs_core
from rmfs_commands.testing import small_world
from rmfs_core import StoreBundle, hookimpl
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_core.warehouse import Bundle, Pod, Station, Warehouse, WarehouseView
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
    """Each rule chooses what its definition says, one bundle after the other."""
    used = rule()
    for seed in range(30):
        found = used.select_replenishment_pods(WarehouseView(midway(seed)), max_fetches)
        assert found == literal(midway(seed), max_fetches, cost), seed


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
