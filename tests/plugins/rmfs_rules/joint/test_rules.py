"""Joint rules alternating, two-stage and lns: what they cost; test_oracles.py has what they decide."""

from collections.abc import Callable
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from cases import cases
from rmfs_commands.testing import check_rule, small_world
from rmfs_core import JointDecision
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.joint import Alternating, LargeNeighborhoodSearch, TwoStage
from rmfs_rules.mip import Integrated


@cases(
    "rule",
    Alternating(rounds=1, max_wait_s=60, unused_capacity_weight=0.5),
    TwoStage(first_share=0.2, max_wait_s=60),
    TwoStage(first_orders="oldest"),
    LargeNeighborhoodSearch(max_wait_s=60, share=1.0, iterations=5, unused_capacity_weight=0.5),
)
def test_it_conforms(rule: object) -> None:
    check_rule(rule)


@cases(
    "rule wrong",
    (Alternating, {"rounds": 0}),
    (Alternating, {"unused_capacity_weight": 0}),
    (Alternating, {"max_wait_s": -1}),
    (TwoStage, {"first_share": 0}),
    (TwoStage, {"first_share": 1.5}),
    (TwoStage, {"first_orders": "best"}),
    (LargeNeighborhoodSearch, {"iterations": -1}),
    (LargeNeighborhoodSearch, {"share": 0}),
    (LargeNeighborhoodSearch, {"share": 1.1}),
    (LargeNeighborhoodSearch, {"unused_capacity_weight": 0}),
)
def test_bad_parameters(rule: type[Any], wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        rule(**wrong)


def random_world(seed: int) -> Warehouse:
    """Return a small world in the middle of a run: pods bound for stations, some orders assigned, stock often scarce.

    Every order fits a station, and all pods together have what all orders want.
    """
    rng = np.random.default_rng(seed)
    skus, n_pods = "abcdef", int(rng.integers(2, 7))
    most, finite = (3 if seed % 3 == 0 else 1), seed % 2 == 0
    orders = {
        str(i): {str(sku): int(rng.integers(1, most + 1)) for sku in rng.choice([*skus], rng.integers(1, 4), False)}
        for i in range(int(rng.integers(1, 9)))
    }
    pods: dict[str, dict[str, int | None]] = {f"p{i}": {} for i in range(n_pods)}
    for sku in skus:
        holders = rng.choice(n_pods, rng.integers(1, min(n_pods, 3) + 1), False)
        wanted = sum(order.get(sku, 0) for order in orders.values())
        for number, pod in enumerate(holders.tolist()):
            pods[f"p{pod}"][sku] = (wanted + number) // len(holders) + 1 if finite else None
    capacities = rng.integers(9, 12, rng.integers(1, 4)) if most > 1 else rng.integers(3, 7, rng.integers(1, 4))
    held = {name: contents for name, contents in pods.items() if contents}
    world = small_world(orders, held, capacities=capacities.tolist(), counts_orders=seed % 5 == 0)
    for station in world.stations:
        for pod in rng.choice(len(held), rng.integers(0, min(len(held), 2) + 1), False).tolist():
            world.bind(world.pods[pod], station)
    return world


def apply(world: Warehouse, decision: JointDecision) -> None:
    """Carry a decision out; fail where the kernel would refuse it."""
    for trip in decision.trips:
        assert trip.station not in world.pods[trip.pod].bound_for
        world.bind(world.pods[trip.pod], world.stations[trip.station])
    for pair in decision.assignments:
        order, station = world.orders[pair.order], world.stations[pair.station]
        assert world.size_at(order, station) <= station.free_capacity
        world.assign(order, station, [line.sku for line in order.open_lines])
    for trip in decision.trips:
        wanted = {request.sku for request in world.stations[trip.station].open_requests}
        assert wanted & world.pods[trip.pod].contents.keys()
    assert not [request for station in world.stations for request in station.uncovered_requests]


def missed(decide: Callable[[WarehouseView, int], JointDecision]) -> list[float]:
    """Decide random periods, (view, seed); return by how much each misses the optimum.

    The objective that a decision reports is worked out anew: visits, and two for every free slot.
    """
    missed = []
    for seed in range(60):
        world = random_world(seed)
        visits = sum(len(station.inbound_pods) for station in world.stations)
        decision = decide(WarehouseView(world), seed)
        largest = max(order.items for order in world.orders) if world.stations[0].counts_orders else 1
        apply(world, decision)
        free = sum(station.free_capacity for station in world.stations)
        objective = visits + len(decision.trips) + 2 * largest * free
        assert decision.report is None or decision.report.objective == objective
        missed.append(objective - optimum(seed))
    return missed


@cache
def optimum(seed: int) -> float:
    """Return the least objective of a random period, by the model as it is printed."""
    rule = Integrated(formulation="paper")
    report = rule.assign_orders_and_pods(WarehouseView(random_world(seed)), np.random.default_rng()).report
    assert report.objective is not None
    return report.objective


def test_more_rounds_cost_no_more() -> None:
    """On random periods; some are improved, and most are decided as well as the model does."""
    one, more = (
        missed(lambda view, seed, rounds=rounds: Alternating(rounds=rounds).assign_orders_and_pods(view))
        for rounds in (1, 10)
    )
    assert all(later <= earlier for earlier, later in zip(one, more, strict=True))
    assert sum(more) < sum(one)
    assert min(more) == 0
    assert sum(more) / len(more) < 1


def test_two_stages_are_never_below_the_optimum() -> None:
    """On random periods, where the kernel would take each decision; with the whole capacity it is close."""
    whole, half = (
        missed(lambda view, seed, share=share: TwoStage(first_share=share).assign_orders_and_pods(view))
        for share in (1.0, 0.5)
    )
    assert min(whole) == min(half) == 0
    assert sum(whole) / len(whole) < 2


def test_it_costs_less_with_the_iterations_and_is_never_below_the_optimum() -> None:
    """On random periods, where the kernel would take each decision; with none it is that of alternating."""

    def after(iterations: int) -> list[float]:
        rule = LargeNeighborhoodSearch(iterations=iterations)
        return missed(lambda view, seed: rule.assign_orders_and_pods(view, np.random.default_rng(seed)))

    results = [after(iterations) for iterations in (0, 5, 50)]
    assert results[0] == missed(lambda view, seed: Alternating().assign_orders_and_pods(view))
    for fewer, more in pairwise(results):
        assert all(later <= earlier for earlier, later in zip(fewer, more, strict=True))
        assert sum(more) < sum(fewer)
    assert min(results[-1]) == 0
    assert results[-1].count(0) >= 54
