"""Random small periods, and what must hold of a decision on each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rmfs_commands.testing import small_world
from rmfs_core import JointDecision
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.mip import Integrated


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
    world = small_world(orders, held, capacities=capacities.tolist(), counts_orders=seed % 5 == 0)  # type: ignore[arg-type]
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


@pytest.fixture(scope="package")
def held_against_the_optimum() -> Callable[[Callable[[WarehouseView, int], JointDecision]], list[float]]:
    """Return a function that decides random periods, (view, seed), and returns by how much each misses the optimum.

    The objective that a decision reports is worked out anew: visits, and two for every free place.
    """

    def hold(decide: Callable[[WarehouseView, int], JointDecision]) -> list[float]:
        missed = []
        for seed in range(60):
            world = random_world(seed)
            visits = sum(len(station.inbound_pods) for station in world.stations)
            exact = Integrated(formulation="paper").assign_orders_and_pods(
                WarehouseView(world), np.random.default_rng()
            )
            decision = decide(WarehouseView(world), seed)
            largest = max(order.items for order in world.orders) if world.stations[0].counts_orders else 1
            apply(world, decision)
            free = sum(station.free_capacity for station in world.stations)
            assert exact.report is not None
            assert exact.report.objective is not None
            objective = visits + len(decision.trips) + 2 * largest * free
            assert decision.report is None or decision.report.objective == objective
            missed.append(objective - exact.report.objective)
        return missed

    return hold
