"""Period t = 1 of the paper's 24 instances: solved to proven optimality within the bar of each model, on one core.

`make bench` holds the bars in seconds, too.
"""

from __future__ import annotations

import time
from itertools import product
from typing import Any

import pytest

from rmfs_core.scenario import load_scenario
from rmfs_core.simulation.setup import open_warehouse
from rmfs_core.warehouse import WarehouseView
from rmfs_core.world import make_instance, make_layout
from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.solution import Model
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.steps import proof_of

BARS_S = {Model.SPLIT_OVER_TIME: 2.0, Model.SPLIT_AMONG_STATIONS: 30.0, Model.INTEGRATED: 120.0}
INSTANCES = list(product((50, 150, 250), (20, 100), (50, 100), (2, 3)))


def first_period(orders: int, skus: int, pods: int, alpha: int) -> Period:
    """Return period t = 1 of an instance: all orders in the backlog, no pod at any station."""
    numbers = {"orders": orders, "skus": skus, "pods": pods, "skus_per_pod": alpha}
    scenario = load_scenario("paper-250", [f"instance.{key}={number}" for key, number in numbers.items()])
    warehouse = open_warehouse(scenario, make_instance(scenario), make_layout(scenario)).warehouse
    for order in warehouse.orders:
        warehouse.order_arrives(order)
    view = WarehouseView(warehouse)
    return Period.of(view, Stock.of(view.pods, view.n_skus))


@pytest.fixture(scope="module", autouse=True)
def compiled() -> None:
    """Compile the searches, which happens once after an installation."""
    for model in Model:
        for instance in ((50, 20, 50, 2), (150, 20, 50, 2)):
            proof_of(first_period(*instance), model, 2, Limits()).run()


@pytest.mark.slow
@pytest.mark.parametrize("instance", INSTANCES, ids=lambda instance: "-".join(map(str, instance)))
@pytest.mark.parametrize("model", Model)
def test_first_period(benchmark: Any, model: Model, instance: tuple[int, int, int, int]) -> None:
    """Proven within the bar: 2 s (split-over-time), 30 s (split-among-stations), 120 s (integrated)."""
    period = first_period(*instance)
    solution = benchmark.pedantic(lambda: proof_of(period, model, 2, Limits()).run(), rounds=1)
    assert solution.bound == solution.objective
    assert not solution.stopped_early
    if benchmark.enabled:
        benchmark.extra_info.update(objective=solution.objective, how=solution.how)
        assert benchmark.stats.stats.max <= BARS_S[model]


@pytest.mark.slow
@pytest.mark.parametrize("instance", INSTANCES[-8:], ids=lambda instance: "-".join(map(str, instance)))
def test_first_period_with_packing_capacity(benchmark: Any, instance: tuple[int, int, int, int]) -> None:
    """Split-among-stations with room for ten split orders, 250 orders: proven within 10 s."""
    period = first_period(*instance)
    proof = proof_of(period, Model.SPLIT_AMONG_STATIONS, 2, Limits(), packing_capacity=10)
    solution = benchmark.pedantic(proof.run, rounds=1)
    assert solution.bound == solution.objective
    assert not solution.stopped_early
    if benchmark.enabled:
        benchmark.extra_info.update(objective=solution.objective, how=solution.how)
        assert benchmark.stats.stats.max <= 10


@pytest.mark.slow
@pytest.mark.parametrize("orders", [28, 30])
def test_first_period_of_few_orders(benchmark: Any, orders: int) -> None:
    """Integrated with hardly more to assign than places: proven within 1 s of CPU."""
    period = first_period(orders, 100, 100, 3)
    start = time.process_time()
    solution = benchmark.pedantic(lambda: proof_of(period, Model.INTEGRATED, 2, Limits()).run(), rounds=1)
    seconds = time.process_time() - start
    assert solution.bound == solution.objective
    assert not solution.stopped_early
    if benchmark.enabled:
        benchmark.extra_info.update(cpu_s=seconds)
        assert seconds <= 1
