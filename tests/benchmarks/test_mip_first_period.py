"""Periods of the paper's instances: t = 1 proven optimal within the bar of each model, on one core; t > 1 against CBC.

Then real size: an answer within seconds, with its gap, and corners where the proof takes long. `make bench` holds the
bars in seconds, too.
"""

import time
from itertools import product
from statistics import mean, median
from typing import Any

import numpy as np
import pytest
from attrs import evolve

import rmfs_core
from mip_periods import holding
from rmfs_core.scenario import load_scenario
from rmfs_core.simulation.setup import open_warehouse
from rmfs_core.warehouse import WarehouseView
from rmfs_core.world import make_instance, make_layout
from rmfs_rules.mip import Integrated, SplitAmongStations, SplitOverTime
from rmfs_rules.mip.period.effort import Effort
from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.solution import Model, Solution
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.steps import proof_of

BARS_S = {Model.SPLIT_OVER_TIME: 2.0, Model.SPLIT_AMONG_STATIONS: 30.0, Model.INTEGRATED: 120.0}
INSTANCES = list(product((50, 150, 250), (20, 100), (50, 100), (2, 3)))


def first_period(*overrides: str, packing: bool = True) -> Period:
    """Return period t = 1 of the paper's generator: all orders in the backlog, no pod at any station."""
    scenario = load_scenario("paper-250", overrides)
    warehouse = open_warehouse(scenario, make_instance(scenario), make_layout(scenario)).warehouse
    for order in warehouse.orders:
        warehouse.order_arrives(order)
    view = WarehouseView(warehouse)
    return Period.of(view, Stock.of(view), packing=packing)


def of_size(orders: int, skus: int, pods: int, alpha: int) -> list[str]:
    numbers = {"orders": orders, "skus": skus, "pods": pods, "skus_per_pod": alpha}
    return [f"instance.{key}={number}" for key, number in numbers.items()]


@pytest.fixture(scope="module", autouse=True)
def compiled() -> None:
    """Compile the searches, which happens once after an installation."""
    for model in Model:
        for instance in ((50, 20, 50, 2), (150, 20, 50, 2)):
            proof_of(first_period(*of_size(*instance), packing=False), model, 2, Limits()).run()
        solved(first_period("instance.orders=20"), model)


FIRST = [
    *((model, size, BARS_S[model], None) for model in Model for size in INSTANCES),
    *((Model.SPLIT_AMONG_STATIONS, size, 10.0, 10) for size in INSTANCES[-8:]),
    *((Model.INTEGRATED, (orders, 100, 100, 3), 1.0, None) for orders in (28, 30)),  # hardly more orders than places
]
"""Models, orders, SKUs, pods and SKUs on each, seconds of CPU time for the proof, and packing capacity."""


@pytest.mark.parametrize(
    ("model", "size", "most_s", "capacity"),
    FIRST,
    ids=[f"{model}-{'-'.join(map(str, size))}-{capacity}" for model, size, _, capacity in FIRST],
)
def test_first_period(benchmark: Any, model: Model, size: Any, most_s: float, capacity: int | None) -> None:
    """Bar: the optimum is proven within so many seconds."""
    proof = proof_of(first_period(*of_size(*size), packing=False), model, 2, Limits(), capacity)
    start = time.process_time()
    solution = benchmark.pedantic(proof.run, rounds=1)
    cpu_s = time.process_time() - start
    assert (solution.bound, solution.stopped_early) == (solution.objective, False)
    if benchmark.enabled:
        benchmark.extra_info.update(objective=solution.objective, how=solution.how, cpu_s=cpu_s)
        assert cpu_s <= most_s


RULES = {
    Model.INTEGRATED: Integrated,
    Model.SPLIT_AMONG_STATIONS: SplitAmongStations,
    Model.SPLIT_OVER_TIME: SplitOverTime,
}
REAL_SIZE = ("instance.skus=1000", "instance.pods=428", "instance.skus_per_pod=12")
GAPS = {Model.INTEGRATED: 0.1, Model.SPLIT_AMONG_STATIONS: 0.3, Model.SPLIT_OVER_TIME: 0.0}
CORNERS = {
    "half-weight": (Model.INTEGRATED, 1.5, None, (50, 100, 50, 2), 21),
    "half-weight-150": (Model.INTEGRATED, 1.5, None, (150, 100, 50, 2), 21),
    "packing-10": (Model.SPLIT_OVER_TIME, 2, 10, (150, 100, 100, 3), 31),
    "packing-3": (Model.SPLIT_OVER_TIME, 2, 3, (50, 100, 50, 2), 33),
    "packing-3-among": (Model.SPLIT_AMONG_STATIONS, 2, 3, (50, 100, 50, 2), 33),
}


def made_period(orders: int, skus: int, pods: int, per_pod: int, stations: int) -> Period:
    """Return a period with popular and rare SKUs, too large for the kernel to set up quickly."""
    rng = np.random.default_rng(1)
    popularity = np.exp(-5 * np.arange(skus) / skus)
    popularity /= popularity.sum()
    contents = tuple(tuple(sorted(set(rng.choice(skus, per_pod, p=popularity).tolist()))) for _ in range(pods))
    order = np.repeat(np.arange(orders), rng.geometric(0.4, orders))
    line = np.unique(order * skus + rng.choice(skus, len(order), p=popularity))
    stock = holding(contents, skus)
    every, none = tuple(range(orders)), ((),) * stations
    table = (line // skus, line % skus, np.ones(len(line), dtype=np.int64))
    return Period(stock, tuple(range(stations)), (15,) * stations, none, every, *table)


def later(period: Period, seed: int) -> Period:
    """Return a later period of it: one station has a few places free, and three pods are on their way there."""
    rng = np.random.default_rng(seed)
    pods = tuple(sorted(rng.choice(len(period.stock.pods), 3, replace=False).tolist()))
    lines = (period.line_order, period.line_sku, period.line_quantity)
    return Period(period.stock, (0,), (int(rng.integers(1, 4)),), (pods,), period.orders, *lines, busy=pods)


def solved(period: Period, model: Model, weight: float = 2, capacity: int | None = None) -> tuple[float, Solution]:
    """Return CPU seconds and solution with the default effort."""
    start = time.process_time()
    proof = proof_of(period, model, weight, Limits(), capacity)
    proof.limits = Limits(effort=Effort.for_period(period, None, hard=proof.hard))
    solution = proof.run()
    seconds = time.process_time() - start
    assert violation(period, solution, model, weight, capacity) is None
    return seconds, solution


def seconds_of(rule: Any, monkeypatch: pytest.MonkeyPatch, periods: list[Period] | None = None) -> list[float]:
    """Return a list to which each period that a rule solves from now on adds its CPU seconds; ``periods`` get it."""
    taken: list[float] = []
    solve = rule.solve

    def timed(rule: Any, period: Period, *capacity: int | None) -> Solution:
        start = time.process_time()
        solution: Solution = solve(rule, period, *capacity)
        taken.append(time.process_time() - start)
        if periods is not None:
            periods.append(evolve(period))  # as it was before anything was derived from it
        return solution

    monkeypatch.setattr(rule, "solve", timed)
    return taken


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("model", Model)
def test_first_period_of_real_size(benchmark: Any, model: Model, seed: int) -> None:
    """1,000 SKUs, 428 pods with 12 each, 250 orders: answered within 2 s, with a gap as in `GAPS` at most."""
    period = first_period(*REAL_SIZE, f"seed={seed}")
    seconds, solution = benchmark.pedantic(lambda: solved(period, model), rounds=1)
    assert solution.objective - solution.bound <= GAPS[model] * solution.objective
    if benchmark.enabled:
        benchmark.extra_info.update(objective=solution.objective, bound=solution.bound, cpu_s=seconds)
        assert seconds <= 2


@pytest.mark.parametrize("model", Model)
def test_later_periods_of_real_size(benchmark: Any, model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    """There, the median of the later periods is under 5 ms."""
    taken = seconds_of(RULES[model], monkeypatch)
    overrides = [*REAL_SIZE, "rules.pp=free-flow", "run.until_s=600"]
    benchmark.pedantic(lambda: rmfs_core.run(f"paper-250-{model}", overrides=overrides), rounds=1)
    assert len(taken) > 1
    if benchmark.enabled:
        assert median(taken[1:]) < 0.005


@pytest.mark.parametrize("model", Model)
def test_periods_with_finite_stock(benchmark: Any, model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    """250 orders, 100 SKUs, 100 pods with 3 items of each SKU: each proven; median 5 ms, 95th percentile 50 ms."""
    taken = seconds_of(RULES[model], monkeypatch)
    overrides = ["instance.items_per_sku=3", "rules.pp=free-flow"]
    result = benchmark.pedantic(lambda: rmfs_core.run(f"paper-250-{model}", overrides=overrides), rounds=1)
    assert result.status == "complete"
    assert result.metrics["solves_stopped_early"] == 0
    if benchmark.enabled:
        assert taken[0] <= 5
        assert median(taken[1:]) <= 0.005
        assert np.quantile(taken[1:], 0.95) <= 0.05


@pytest.mark.parametrize(
    ("size", "most_s", "most_later_s"),
    [((10_000, 10_000, 1000, 50, 20), 5.0, 0.02), ((50_000, 1000, 428, 12, 4), 5.0, 0.02)],
    ids=["twenty-stations", "long-backlog"],
)
@pytest.mark.parametrize("model", Model)
def test_long_backlogs(benchmark: Any, model: Model, size: Any, most_s: float, most_later_s: float) -> None:
    """10,000 orders of 10,000 SKUs at 20 stations, and 50,000 orders: the first period, and the later ones' median."""
    period = made_period(*size)
    first, solution = benchmark.pedantic(lambda: solved(period, model), rounds=1)
    assert solution.objective - solution.bound <= 0.1 * solution.objective
    seconds = [solved(later(period, seed), model)[0] for seed in range(9)]
    if benchmark.enabled:
        assert first <= most_s
        assert median(seconds) <= most_later_s


@pytest.mark.parametrize("name", CORNERS)
def test_corners(benchmark: Any, name: str) -> None:
    """A weight that is not whole, or few split orders, at t = 1: within 10 s there is an answer with its gap."""
    model, weight, capacity, size, seed = CORNERS[name]
    period = first_period(*of_size(*size), f"seed={seed}")
    seconds, solution = benchmark.pedantic(lambda: solved(period, model, weight, capacity), rounds=1)
    assert (solution.how == "effort") == (solution.bound < solution.objective)
    if benchmark.enabled:
        benchmark.extra_info.update(objective=solution.objective, bound=solution.bound, cpu_s=seconds)
        assert seconds <= 10


PAPER_S_PER_ORDER = {Model.INTEGRATED: 0.48, Model.SPLIT_AMONG_STATIONS: 1.06, Model.SPLIT_OVER_TIME: 1.34}
PAPER_PERCENT_OF_SIMULATED = {Model.INTEGRATED: 3.39, Model.SPLIT_AMONG_STATIONS: 9.67, Model.SPLIT_OVER_TIME: 14.67}
FASTER = {Model.INTEGRATED: 20, Model.SPLIT_AMONG_STATIONS: 20, Model.SPLIT_OVER_TIME: 500}
ORDERS_250 = list(product((20, 100), (50, 100), (2, 3)))


def run(model: Model, skus: int, pods: int, alpha: int) -> rmfs_core.Result:
    """Run an instance with 250 orders; other robots are ignored, because their paths are not measured here."""
    overrides = [*of_size(250, skus, pods, alpha), "rules.pp=free-flow"]
    result = rmfs_core.run(f"paper-250-{model}", overrides=overrides)
    assert result.status == "complete"
    return result


def timed(rule: Any, periods: list[Period]) -> tuple[list[float], list[Solution]]:
    """Return the seconds that a rule takes for each period, model building and check included, and what it finds."""
    seconds, solutions = [], []
    for period in periods:
        start = time.perf_counter()
        solutions.append(rule.solve(period))
        seconds.append(time.perf_counter() - start)
    return seconds, solutions


@pytest.mark.parametrize("model", Model)
def test_later_periods(benchmark: Any, model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    """Periods t > 1 of a run against the printed form with CBC: median and 95th percentile."""
    periods: list[Period] = []
    with monkeypatch.context() as patch:
        in_run = seconds_of(RULES[model], patch, periods)
        run(model, 100, 100, 3)
    del in_run[0], periods[0]
    some = periods[:: max(len(periods) // (60 if benchmark.enabled else 5), 1)]
    ours, fast = timed(RULES[model](), [*map(evolve, some)])
    printed, slow = timed(RULES[model](formulation="paper", solver="cbc"), [*map(evolve, some)])
    assert [solution.objective for solution in fast] == [solution.objective for solution in slow]
    tail = float(np.quantile(in_run, 0.95))
    benchmark.extra_info.update(ours_s=median(ours), printed_s=median(printed), in_run_s=median(in_run), tail_s=tail)
    benchmark.pedantic(RULES[model]().solve, args=(evolve(periods[0]),), rounds=1)
    if benchmark.enabled:
        assert median(printed) / median(ours) >= FASTER[model]
        assert median(in_run) < 0.005
        assert tail < 0.03


@pytest.mark.parametrize("model", Model)
def test_whole_runs(benchmark: Any, model: Model) -> None:
    """Seconds per order and share of simulated time at t > 1, means of the 250-order set: a fiftieth of the paper's."""
    instances = ORDERS_250 if benchmark.enabled else ORDERS_250[-1:]
    results = benchmark.pedantic(lambda: [run(model, *instance) for instance in instances], rounds=1)
    per_order = mean(result.timing["decision_s_per_order"] for result in results)
    percent = mean(result.timing["decision_percent_of_simulated"] for result in results)
    benchmark.extra_info.update(s_per_order=per_order, percent_of_simulated=percent)
    if benchmark.enabled:
        assert per_order <= PAPER_S_PER_ORDER[model] / 50
        assert percent <= PAPER_PERCENT_OF_SIMULATED[model] / 50
