"""Stations that count orders: both formulations have the optimum that trying everything finds, and runs end."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import rmfs_core
from rmfs_commands.testing import small_world
from rmfs_commands.validation import validate_trace
from rmfs_core.errors import InputError
from rmfs_core.results.result import Result
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.mip import Integrated, SplitAmongStations, SplitOverTime
from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.solution import Model
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.models import solve_printed
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.parts import with_joining_lines
from rmfs_rules.mip.proof.steps import by_nothing, by_solver, proof_of
from rmfs_rules.mip.proof.ties import break_ties

LIMITS = Limits()
ROOMS = pytest.mark.parametrize("room", [None, 0, 1], ids=lambda room: f"packing capacity {room}")


def agree(period: Period, model: Model, brute_force: Callable[..., float], room: int | None) -> bool:
    """Hold both formulations against trying everything; return whether no solver was needed."""
    capacity = None if room is None else period.split_open + room
    best = brute_force(period, model, 2, None if model is Model.INTEGRATED else room)
    printed = solve_printed(period, model, 2, LIMITS, capacity)
    aggregated = proof_of(period, model, 2, LIMITS, capacity).run()
    by_program = proof_of(period, model, 2, LIMITS, capacity, steps=(by_nothing, by_solver)).run()
    for solution in (printed, aggregated, by_program):
        assert solution.objective == solution.bound == best
        assert violation(period, solution, model, 2, capacity) is None
        joined = with_joining_lines(period, solution, model)
        assert joined.objective == best
        assert violation(period, joined, model, 2, capacity) is None
    return aggregated.how == "bounds"


@ROOMS
@pytest.mark.parametrize("model", Model)
def test_both_formulations_have_the_optimum(putwall_period, brute_force_from_stock, model, room):
    """With and without a limit on split orders, orders that have a place already, stations of both kinds: a sample."""
    if model is not Model.INTEGRATED or room is None:
        proven = [agree(putwall_period(seed), model, brute_force_from_stock, room) for seed in range(16)]
        assert 0 < sum(proven) < len(proven)


@pytest.mark.slow
@ROOMS
@pytest.mark.parametrize("model", Model)
def test_both_formulations_have_the_optimum_on_many_periods(putwall_period, brute_force_from_stock, model, room):
    """On 320 periods without that limit, on 100 with."""
    if model is not Model.INTEGRATED or room is None:
        for seed in range(20, 340) if room is None else range(340, 440):
            agree(putwall_period(seed), model, brute_force_from_stock, room)


@pytest.mark.parametrize("model", Model)
def test_tie_breaks_keep_the_optimum(putwall_period, model):
    """Also where parts of orders are told apart."""
    for seed in range(20):
        period = putwall_period(seed)
        for tie_break in ("oldest", "demand"):
            proof = proof_of(period, model, 2, LIMITS)
            first = proof.run()
            preferred = break_ties(proof, tie_break)
            assert preferred.objective == first.objective
            assert violation(period, preferred, model, 2) is None


def test_a_place_is_filled_whatever_its_order_costs():
    """Six lines on six pods: with W_u = 2 a place for an item would not be worth them, one for the order is."""
    world = small_world({"1": "abcdef"}, {sku: sku for sku in "abcdef"}, capacities=[1], counts_orders=True)
    for rule in (Integrated(), SplitAmongStations()):
        decision = rule.assign_orders_and_pods(WarehouseView(world), np.random.default_rng(0))
        assert (len(decision.assignments), len(decision.trips), decision.report.objective) == (1, 6, 6)


def test_lines_join_the_place_of_their_order():
    """Over time, what the pods at the station have of an order goes there too: it takes no further place."""
    world = small_world({"1": "abc", "2": "ab"}, {"p": "ab", "q": "c"}, capacities=[2], counts_orders=True)
    world.bind(world.pods[0], world.stations[0])
    world.assign(world.orders[0], world.stations[0], [0])
    decision = SplitOverTime().assign_orders_and_pods(WarehouseView(world), np.random.default_rng(0))
    assert sorted((one.order, one.skus) for one in decision.assignments) == [(0, (1,)), (1, (0, 1))]
    assert decision.trips == ()


SMALL = [f"instance.{key}" for key in ("orders=24", "pods=30", "skus=15", "skus_per_pod=2")]
SMALL += [f"layout.{key}" for key in ("block_rows=5", "block_columns=3", "stations_east=2")]
SMALL += ["rules.pp=free-flow"]


def run(rule: Model, folder: Path, *overrides: str) -> Result:
    """Run a small scenario, and hold its trace against everything that must be true."""
    result = rmfs_core.run(f"paper-250-{rule}", overrides=[*SMALL, *overrides], out=folder, record=["trace"])
    assert validate_trace(folder) == []
    return result


@pytest.mark.parametrize("stock", ["instance.items_per_sku=5", "instance.items_per_sku="])
@pytest.mark.parametrize("rule", Model)
def test_runs_with_order_capacity_end_complete(rule, stock, tmp_path):
    """Whole runs, each period at its optimum."""
    result = run(rule, tmp_path, "stations.order_capacity=3", stock)
    assert result.status == "complete"
    assert result.metrics["solves_stopped_early"] == 0


@pytest.mark.parametrize("items", [1, 3])
@pytest.mark.parametrize("rule", Model)
def test_runs_with_orders_too_large_for_the_stations_end_complete(rule, items, tmp_path):
    """Some orders are larger than a station, with one item each than both together: they get one of their own."""
    result = run(rule, tmp_path, f"stations.item_capacity={items}", "rules.poa_pps.max_wait_s=100")
    assert result.status == "complete"


def test_a_line_too_large_for_the_stations_is_not_split():
    """Five items of one SKU for three places: all models give the order an empty station, from two pods."""
    for rule in (Integrated(), SplitAmongStations(), SplitOverTime()):
        world = small_world({"1": {"a": 5}}, {"p": {"a": 4}, "q": {"a": 1}}, capacities=[3, 3])
        decision = rule.assign_orders_and_pods(WarehouseView(world), np.random.default_rng(0))
        assert [(one.order, one.station, one.skus) for one in decision.assignments] == [(0, 0, (0,))]
        assert {trip.pod for trip in decision.trips} == {0, 1}


def test_orders_too_large_are_refused_where_the_scenario_says_so(tmp_path):
    """Of the three rules, `integrated` alone cannot do without."""
    refusing = "stations.item_capacity=3", "stations.oversize=refuse"
    with pytest.raises(InputError, match=r"items, more than any station takes at a time \(3\)"):
        run(Model.INTEGRATED, tmp_path, *refusing)
    assert run(Model.SPLIT_OVER_TIME, tmp_path, *refusing).status == "complete"
