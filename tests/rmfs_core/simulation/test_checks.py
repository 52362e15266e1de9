"""What makes a decision impossible: each ends the run with one sentence."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bad_rules import prepare_bad, what_ends
from rmfs_core.errors import RuleError
from rmfs_core.events import OrderAssigned

WRONG = [
    # POA
    ("poa", "return [3]", "returned a sequence with int 3 in it; expected OrderAssignment only"),
    ("poa", "return [OrderAssignment(9, 0)]", "named order 9, which does not exist; ids are 0 to 2"),
    ("poa", "return [OrderAssignment('1', 0)]", "named order '1'; expected a whole number"),
    ("poa", "return [OrderAssignment(0, 5)]", "named station 5, which does not exist; ids are 0 to 0"),
    (
        "poa",
        "return [OrderAssignment(1, 0)]",
        "assigned order two (id 1) to station 1 (id 0): it takes 3 items, but only 2 of 2 are free",
    ),
    (
        "poa",
        "return [OrderAssignment(0, 0), OrderAssignment(0, 0)]",
        "assigned order one (id 0) to station 1 (id 0), but the order has no open line left",
    ),
    (
        "poa",
        "return [OrderAssignment(0, 0, skus=(2,))]",
        "assigned SKU id 2 of order one (id 0), which is no open line of it",
    ),
    (
        "poa",
        "return [OrderAssignment(0, 0, skus=())]",
        "assigned SKUs () of order one (id 0); expected one or more, each once",
    ),
    (
        "poa",
        "return [OrderAssignment(2, 0)]",
        "assigned order late (id 2) to station 1 (id 0), but the order was not in the backlog it was shown",
    ),
    ("poa", "return [OrderAssignment(0.0, 0)]", "named order 0.0; expected a whole number"),
    ("poa", "return [OrderAssignment(True, 0)]", "named order True; expected a whole number"),
    (
        "poa",
        "return [OrderAssignment(0, 0, skus=5)]",
        "assigned SKUs 5 of order one (id 0); expected a sequence of ids",
    ),
    ("poa", "return [OrderAssignment(0, 0, skus=(0.0,))]", "named SKU id 0.0; expected a whole number"),
    # PPS
    ("pps", "return [PodTrip(9, 0)]", "named pod 9, which does not exist; ids are 0 to 2"),
    (
        "pps",
        "return [PodTrip(0, 0), PodTrip(0, 0)]",
        "sent pod p (id 0) to station 1 (id 0), where it already is or is bound for",
    ),
    (
        "pps",
        "return [PodTrip(2, 0)]",
        "sent pod r (id 2) to station 1 (id 0), but it holds no item of any request uncovered there",
    ),
    (
        "pps",
        "return [PodTrip(0, 0), PodTrip(1, 0)] if max_fetches == 1 else []",
        "sent 2 stored pods on their way; at most 1 robots can start",
    ),
    # POA and PPS together
    ("poa_pps", "return []", "returned list []; expected JointDecision"),
    (
        "poa_pps",
        "return JointDecision([OrderAssignment(0, 0)], [])",
        "assigned order one (id 0) to station 1 (id 0), but no pod there or bound for it has an item of SKU id 0 left",
    ),
    ("poa_pps", "return JointDecision([], [PodTrip(0, 7)])", "named station 7, which does not exist; ids are 0 to 0"),
    ("poa_pps", "return JointDecision([OrderAssignment(1, 0)], [PodTrip(0, 0)])", "it takes 3 items, but only 2 of 2"),
    (
        "poa_pps",
        "return JointDecision([], [PodTrip(2, 0)])",
        "sent pod r (id 2) to station 1 (id 0), but it holds no item of any request open there",
    ),
    ("poa_pps", "return JointDecision([], [], report='fine')", "returned str 'fine'; expected SolveReport"),
    ("poa_pps", "return JointDecision([], [], SolveReport('optimal', objective='x'))", "objective is 'x'; expected a"),
    # PR
    ("pr", "return 2.5", "named cell 2.5; expected a whole number"),
    ("pr", "return -1", "stores pod p (id 0) at cell -1, which is not on the grid"),
    ("pr", "return warehouse.stations[0].cell", "which is no storage location"),
    ("pr", "return warehouse.home(warehouse.pods[1])", "which is taken"),
    # TA
    ("ta", "return [TaskAssignment(4, 0)]", "named robot 4, which does not exist; ids are 0 to 0"),
    (
        "ta",
        "return [TaskAssignment(0, 2)]",
        "gave pod r (id 2) to robot 1 (id 0), but the pod does not wait for a robot",
    ),
    ("ta", "return [TaskAssignment(0, 0), TaskAssignment(0, 1)]", "gave pod q (id 1) to robot 1 (id 0), which is busy"),
    # PP
    ("pp", "return Path()", "gave robot 1 (id 0) an empty path to "),
    ("pp", "return Path([Leg(-5)])", "sent robot 1 (id 0) to cell -5, which is not on the grid"),
    ("pp", "return Path([Leg(robot.cell)])", "gave robot 1 (id 0) a leg that waits 0 ticks and goes nowhere"),
    ("pp", "return Path([Leg(robot.cell, 10**14)])", "gave robot 1 (id 0) a leg that waits 100000000000000 ticks"),
    ("pp", "return Path([Leg(robot.cell, 0.5)])", "named wait_ticks 0.5; expected a whole number"),
    ("pp", "return Path([Leg(None)])", "named cell None; expected a whole number"),
    ("pp", "return Path([Leg(robot.cell, 60000)])", "without arriving (run.standstill_s)"),
    ("pp", "return Path([3])", "returned a path with int 3 in it; expected Leg only"),
    ("pp", "return Path([Leg(warehouse.stations[0].cell)])", "gave robot 1 (id 0) an impossible path: "),
    # Filter
    ("filters", "return orders + orders[:1] + (warehouse.orders[0],) + tuple('x')", "in it; expected Order only"),
]


@pytest.mark.parametrize(("role", "body", "message"), WRONG)
def test_a_wrong_decision_ends_the_run_with_its_reason(
    tiny_run: Callable[..., Any], tmp_path: Path, role: str, body: str, message: str
) -> None:
    """The error names the rule with its distribution and version, the hook, the simulated time, and what was wrong."""
    assert message in what_ends(prepare_bad(tiny_run, tmp_path, role, body), role)


def test_numpy_integers_are_ids_too(tiny_run: Callable[..., Any], tmp_path: Path) -> None:
    """A rule that finds its answer with argmax need not convert it."""
    body = "import numpy as np; return [OrderAssignment(np.int64(o.id), np.int64(0)) for o in warehouse.backlog[:1]]"
    run = prepare_bad(tiny_run, tmp_path, "poa", body)
    with pytest.raises(RuleError, match="it takes 3 items"):  # only because the order is too large
        run.simulation.run()
    assert len(run.recorder.of(OrderAssigned)) >= 1
