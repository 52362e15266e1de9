"""The joint rules in the kernel: parameters, refusals, whole runs."""

from __future__ import annotations

import numpy as np
import pytest

import rmfs_core
from rmfs_commands.testing import small_world
from rmfs_commands.validation import validate_trace
from rmfs_core import JointDecision, OrderAssignment
from rmfs_core.errors import InputError
from rmfs_core.simulation.applying import apply_assignments
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.mip import Integrated, SplitAmongStations, SplitOverTime

RNG = np.random.default_rng(0)
RULES = (Integrated, SplitAmongStations, SplitOverTime)
SMALL = [f"instance.{key}" for key in ("orders=20", "pods=30")]
SMALL += [f"layout.{key}" for key in ("block_rows=5", "block_columns=3", "stations_east=2")]


@pytest.mark.parametrize("rule", RULES)
def test_nothing_to_do(rule):
    """Orders that no pod can serve, or none at all: nothing is decided, and that is optimal."""
    for orders in ({"1": ["nowhere"]}, {}):
        world = small_world(orders, {"p": ["a"]})
        decision = rule().assign_orders_and_pods(WarehouseView(world), RNG)
        assert (decision.assignments, decision.trips) == ((), ())
        assert decision.report.status == "optimal"
        assert decision.report.objective == decision.report.bound == 2 * 15


def test_a_split_needs_fewer_visits():
    """Example 1: two visits, each station one SKU of both orders."""
    world = small_world({"1": ["a", "b"], "2": ["a", "b"]}, {"p": ["a"], "q": ["b"]}, capacities=(2, 2))
    assert len(Integrated().assign_orders_and_pods(WarehouseView(world), RNG).trips) == 4
    decision = SplitAmongStations().assign_orders_and_pods(WarehouseView(world), RNG)
    assert isinstance(decision, JointDecision)
    assert len(decision.trips) == 2
    assert {(a.order, len(a.skus)) for a in decision.assignments} == {(0, 1), (1, 1)}


def test_a_pod_that_is_there_costs_nothing():
    """A pod bound for the station is no new trip; the oldest order that it serves is taken first."""
    world = small_world({"1": ["b"], "2": ["a"], "3": ["a"]}, {"p": ["a"], "q": ["b"]}, capacities=(1,))
    world.bind(world.pods[0], world.stations[0])
    for rule in RULES:
        decision = rule().assign_orders_and_pods(WarehouseView(world), RNG)
        assert decision.assignments == (OrderAssignment(1, 0, (world.orders[1].lines[0].sku,)),)
        assert decision.trips == ()


@pytest.mark.parametrize(
    "wrong",
    [
        {"formulation": "short"},
        {"solver": "glpk"},
        {"threads": 0},
        {"max_seconds": 0},
        {"gap": -0.1},
        {"unused_capacity_weight": 0},
        {"tie_break": "youngest"},
        {"formulation": "paper", "tie_break": "oldest"},  # the printed form leaves ties to the solver
        {"preferred_pods": "far"},
        {"formulation": "paper", "preferred_pods": "random"},
        {"packing_capacity": -1},
        {"effort": -1},
        {"formulation": "paper", "effort": 5},
    ],
    ids=str,
)
def test_wrong_parameters(wrong):
    """A bad value is refused when the rule is created."""
    with pytest.raises(ValueError, match=list(wrong)[-1]):
        SplitOverTime(**wrong)


def test_a_solver_that_is_not_installed_is_said_before_the_run(monkeypatch):
    """Also by the aggregated form, which often needs no solver."""
    monkeypatch.setattr("mip.gurobi.has_gurobi", False)
    with pytest.raises(InputError, match='solver = "gurobi" needs an installed Gurobi'):
        rmfs_core.run("paper-250-integrated", overrides=[*SMALL, "rules.poa_pps.solver=gurobi"])


@pytest.mark.parametrize("rule", ["integrated", "split-among-stations", "split-over-time"])
@pytest.mark.parametrize(
    "setting",
    [
        "formulation=aggregated",
        "formulation=paper",
        "preferred_pods=bound",
        "preferred_pods=any",
        "preferred_pods=random",
    ],
)
def test_runs_end_complete_and_repeat(rule, setting):
    """A whole run completes every order, each period at its optimum; a second one measures the same."""
    overrides = [*SMALL, f"rules.poa_pps.{setting}"]
    first, second = (rmfs_core.run(f"paper-250-{rule}", overrides=overrides) for _ in range(2))
    assert first.status == "complete"
    assert first.metrics == second.metrics
    assert first.metrics["solves_stopped_early"] == 0


@pytest.mark.parametrize("rule", ["split-among-stations", "split-over-time"])
@pytest.mark.parametrize("room", [0, 2])
def test_packing_capacity_holds_in_a_run(rule, room):
    """Never more split orders are open than the packing stations have room for."""
    overrides = [*SMALL, f"rules.poa_pps.packing_capacity={room}"]
    result = rmfs_core.run(f"paper-250-{rule}", overrides=overrides)
    assert result.status == "complete"
    assert result.metrics["split_orders_open_max"] <= room


@pytest.mark.parametrize("tie_break", ["oldest", "demand"])
def test_tie_breaks_in_a_run(tie_break):
    """Runs with the other tie-breaks complete every order, too."""
    result = rmfs_core.run("paper-250-integrated", overrides=[*SMALL, f"rules.poa_pps.tie_break={tie_break}"])
    assert result.status == "complete"


def test_a_limit_is_reported():
    """A run whose solves are cut short says how many were."""
    overrides = [*SMALL, "instance.skus=60", "rules.poa_pps.max_seconds=1e-6"]
    assert rmfs_core.run("paper-250-integrated", overrides=overrides).metrics["solves_stopped_early"] > 0


@pytest.mark.parametrize("rule", ["integrated", "split-among-stations", "split-over-time"])
def test_a_run_without_effort(rule, tmp_path):
    """Every period has a decision at once; it says that its effort ended it, with a bound, and repeats."""
    overrides = [*SMALL, "rules.poa_pps.effort=0"]
    first, second = (rmfs_core.run(f"paper-250-{rule}", overrides=overrides, out=tmp_path) for _ in range(2))
    assert first.status == "complete"
    assert first.metrics == second.metrics
    early = [row for row in first.periods if row["status"] == "effort"]
    assert len(early) == first.metrics["solves_stopped_early"]
    assert all(row["bound"] < row["objective"] for row in early)
    assert early or rule == "split-over-time"


def test_more_split_orders_open_than_there_is_room_for():
    """What others have left so is no fault of a decision that splits no order newly."""
    world = small_world({"1": ["a", "b"], "2": ["a"]}, {"p": ["a", "b"]}, capacities=(1, 5))
    world.assign(world.orders[0], world.stations[0], [world.orders[0].lines[0].sku], 1)
    world.bind(world.pods[0], world.stations[0])
    assert world.split_orders_open == 1
    decision = SplitOverTime(packing_capacity=0).assign_orders_and_pods(WarehouseView(world), RNG)
    kept = apply_assignments(
        world, decision, joint=True, shown=None, period=2, packing_capacity=0, keep=lambda event: None
    )
    assert len(kept.assignments) == 2


@pytest.mark.parametrize("rule", ["integrated", "split-among-stations", "split-over-time"])
def test_the_example_with_finite_stock(rule, tmp_path):
    """It runs with each of the models to its end, and what it records is valid."""
    overrides = [f"rules.poa_pps={rule}", "rules.poa=", "rules.pps="]
    result = rmfs_core.run("examples/from-csv", overrides=overrides, out=tmp_path, record=["trace"])
    assert result.status == "complete"
    assert validate_trace(tmp_path) == []
