"""Pods that run out: both formulations have the optimum that trying everything finds, and runs of all models end."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from attrs import evolve
from hypothesis import given, settings
from hypothesis import strategies as st

import rmfs_core
from rmfs_commands.testing import small_world
from rmfs_commands.validation import validate_trace
from rmfs_core.simulation.applying import apply_assignments
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.mip import Integrated, SplitAmongStations, SplitOverTime
from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.models import solve_printed
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.steps import by_nothing, by_solver, proof_of

LIMITS = Limits()


def _agree(periods: list[Period], model: Model, brute_force: Callable[..., float], room: int | None) -> int:
    """Hold both formulations against trying everything; return how many periods had a scarce SKU."""
    scarce = 0
    for seed, period in enumerate(periods):
        capacity = None if room is None else period.split_open + room
        splits = None if model is Model.INTEGRATED else room
        best = brute_force(period, model, 2, splits)
        printed = solve_printed(period, model, 2, LIMITS, capacity)
        proof = proof_of(period, model, 2, LIMITS, capacity)
        aggregated = proof.run()
        by_program = proof_of(period, model, 2, LIMITS, capacity, steps=(by_nothing, by_solver)).run()
        for solution in (printed, aggregated, by_program):
            assert solution.objective == solution.bound == best, seed
            assert violation(period, solution, model, 2, capacity) is None, seed
        scarce += len(proof.reduced.scarce) > 0
    return scarce


@pytest.mark.parametrize("room", [None, 0, 1], ids=lambda room: f"packing capacity {room}")
@pytest.mark.parametrize("model", Model)
def test_both_formulations_have_the_optimum(scarce_periods, brute_force_from_stock, model, room):
    """With and without a limit on split orders: a quick sample."""
    if model is Model.INTEGRATED and room is not None:
        return
    some = scarce_periods[:16] if room is None else scarce_periods[40::2]
    assert _agree(some, model, brute_force_from_stock, room) > len(some) / 3


@pytest.mark.slow
@pytest.mark.parametrize("room", [None, 0, 1, 2], ids=lambda room: f"packing capacity {room}")
@pytest.mark.parametrize("model", Model)
def test_both_formulations_have_the_optimum_on_many_periods(scarce_period, brute_force_from_stock, model, room):
    """On 320 periods without that limit, on 100 with."""
    if model is Model.INTEGRATED and room is not None:
        return
    periods = [scarce_period(seed) for seed in (range(60, 380) if room is None else range(380, 480))]
    assert _agree(periods, model, brute_force_from_stock, room) > len(periods) / 3


@pytest.mark.parametrize("weight", [0.5, 1.0, 1.5, 4.0])
def test_other_weights(scarce_periods, brute_force_from_stock, weight):
    """W_u may be anything, also where a free place is cheaper than a visit."""
    for period in scarce_periods[::8]:
        for model in Model:
            found = proof_of(period, model, weight, LIMITS).run().objective
            assert found == pytest.approx(brute_force_from_stock(period, model, weight))


@pytest.mark.parametrize("model", Model)
def test_plentiful_stock_is_unlimited_stock(periods, model):
    """Where each pod has as much as the period can take from it, the solution is the same to the last visit."""
    for period in periods[::3]:
        most = sum(period.capacities)
        stock = Stock.counted([dict.fromkeys(skus, most) for skus in period.stock.contents], period.stock.n_skus)
        plentiful = evolve(period, stock=stock)
        assert not len(Reduced(plentiful, model).scarce)
        assert proof_of(plentiful, model, 2, LIMITS).run() == proof_of(period, model, 2, LIMITS).run()


def test_propositions_hold(scarce_periods):
    """There is always a solution; splitting among stations never costs more, splitting over time never more than that.

    Nor does more stock.
    """
    dearer = 0
    for period in scarce_periods:
        values = [proof_of(period, model, 2, LIMITS).run().objective for model in Model]
        assert values == sorted(values, reverse=True)
        unlimited = evolve(period, stock=Stock(period.stock.pods, period.stock.contents, period.stock.n_skus))
        for model, value in zip(Model, values, strict=True):
            least = proof_of(unlimited, model, 2, LIMITS).run().objective
            assert least <= value
            dearer += least < value
    assert dearer > 10


def test_a_line_is_served_from_several_pods():
    """Three items of one line from two pods at one station: both are sent."""
    line = np.array([[0, 0, 3]]).T
    period = Period(Stock.counted([{0: 2}, {0: 1}, {0: 1}], 1), (0,), (3,), ((),), (0,), *line)
    for model in Model:
        solution = proof_of(period, model, 2, LIMITS).run()
        assert solution.objective == 2
        assert len(solution.visits) == 2
        assert (0, 0) in solution.visits


def test_a_pod_shares_its_items_among_stations():
    """One pod with two items at two stations of two places: two orders, wherever they go; the third has to wait."""
    lines = np.array([[order, 0, 1] for order in range(3)]).T
    period = Period(Stock.counted([{0: 2}], 1), (0, 1), (2, 2), ((0,), (0,)), (0, 1, 2), *lines)
    for model in Model:
        solution = proof_of(period, model, 2, LIMITS).run()
        assert (solution.objective, len(solution.parts)) == (6, 2)


@given(
    held=st.lists(st.dictionaries(st.sampled_from("abc"), st.integers(1, 3), min_size=1), min_size=1, max_size=4),
    wanted=st.lists(st.dictionaries(st.sampled_from("abc"), st.integers(1, 2), min_size=1), min_size=1, max_size=6),
    bound=st.lists(st.tuples(st.integers(0, 3), st.integers(0, 1)), max_size=4, unique=True),
    rule=st.sampled_from([Integrated(), SplitAmongStations(), SplitOverTime(), SplitOverTime(formulation="paper")]),
)
@settings(deadline=None, max_examples=60)
def test_what_a_model_decides_can_be_carried_out(held, wanted, bound, rule):
    """Period after period, with pods bound for several stations: the kernel finds promises for every decision."""
    world = small_world(
        {str(i): skus for i, skus in enumerate(wanted)},
        {str(i): skus for i, skus in enumerate(held)},
        capacities=[4, 3],
        robots=4,
    )
    for pod, station in bound:
        if pod < len(held):
            world.bind(world.pods[pod], world.stations[station])
    for period in (1, 2, 3):
        decision = rule.assign_orders_and_pods(WarehouseView(world), np.random.default_rng(0))
        assert decision.report is None or decision.report.status == "optimal"  # None: an order alone
        apply_assignments(
            world, decision, joint=True, shown=None, period=period, packing_capacity=None, keep=lambda event: None
        )
        for station in world.stations:
            for request in station.open_requests[::2]:
                world.fulfil(request, next(pod for pod in world.pods if request in promised(world, pod)))


def promised(world, pod):
    """Return the requests that a pod promised an item to."""
    return [r for station in world.stations for r in station.open_requests if r.pod is pod]


SMALL = [f"instance.{key}" for key in ("orders=30", "pods=30", "skus=15", "skus_per_pod=2")]
SMALL += [f"layout.{key}" for key in ("block_rows=5", "block_columns=3", "stations_east=2")]
NAMES = [str(model) for model in Model]


@pytest.mark.parametrize("items", [2, 5])
@pytest.mark.parametrize("rule", NAMES)
def test_runs_with_finite_stock_end_complete(rule, items, tmp_path):
    """A whole run completes every order, each period at its optimum, and its trace is valid."""
    overrides = [*SMALL, f"instance.items_per_sku={items}"]
    result = rmfs_core.run(f"paper-250-{rule}", overrides=overrides, out=tmp_path, record=["trace"])
    assert result.status == "complete"
    assert result.metrics["solves_stopped_early"] == 0
    assert validate_trace(tmp_path) == []


@pytest.mark.slow
@pytest.mark.parametrize("rule", NAMES)
def test_runs_of_the_printed_form(rule):
    """As printed, a run ends complete, too."""
    overrides = [*SMALL, "instance.items_per_sku=2", "rules.poa_pps.formulation=paper", "rules.pp=free-flow"]
    assert rmfs_core.run(f"paper-250-{rule}", overrides=overrides).status == "complete"
