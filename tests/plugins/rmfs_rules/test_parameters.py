"""Parameters of rules: values that are refused, and rules that conform with others than by default."""

import math
from importlib.metadata import entry_points
from typing import Any

import pytest
from attrs import fields, has

from cases import cases
from rmfs_commands.testing import check_rule
from rmfs_rules.activation import BacklogThreshold
from rmfs_rules.assignment import Assignment
from rmfs_rules.balanced import Balanced
from rmfs_rules.classes import Cache, Utility
from rmfs_rules.due import LeastSlack
from rmfs_rules.idle import ChargeWhenLow
from rmfs_rules.joint import Alternating, LargeNeighborhoodSearch, TwoStage
from rmfs_rules.mip import SplitOverTime
from rmfs_rules.most_covered import MostCovered
from rmfs_rules.pod_index import PodIndex
from rmfs_rules.pod_match import PodMatch
from rmfs_rules.replenishment import PodFirst, TurnoverPod
from rmfs_rules.scorers import Completes, Lexicographic, WorkAmount
from rmfs_rules.sipp import Pbs
from rmfs_rules.station_queue import StationQueue
from rmfs_rules.whca import WhcaN
from rmfs_rules.workload import Workload

RISE = "expected shares above 0 that rise to 1"


@cases(
    "rule wrong problem",
    (PodMatch, {"tie_break": "newest"}, "'tie_break' must be in"),
    (PodMatch, {"fast_lane": -1}, "'fast_lane' must be >= 0"),
    (PodMatch, {"spread": -1.0}, "'spread' must be >= 0"),
    (Workload, {"prefer": "least"}, "'prefer' must be in"),
    (LeastSlack, {"item_s": -1}, "'item_s' must be >= 0"),
    (StationQueue, {"queue_length": 0}, "'queue_length' must be >= 1"),
    (StationQueue, {"urgent_s": -1}, "'urgent_s' must be >= 0"),
    (StationQueue, {"fast_lane": -1}, "'fast_lane' must be >= 0"),
    (MostCovered, {"n": 0}, "'n' must be >= 1"),  # a filter that keeps nothing would stop the run
    (MostCovered, {"n": 1, "lines": "some"}, "'lines' must be in"),
    (Lexicographic, {"scores": ()}, "Length of 'scores' must be >= 1"),
    (Lexicographic, {"scores": ("completes", "far")}, "'scores' must be in"),
    (Lexicographic, {"scores": ("picks", "picks")}, "expected each score once"),
    (Cache, {"share": 1.5}, "'share' must be <= 1"),
    (Cache, {"threshold": -1}, "'threshold' must be >= 0"),
    (Utility, {"corridor": 0}, "'corridor' must be >= 1"),
    (Utility, {"buffer": -0.1}, "'buffer' must be >= 0"),
    (Utility, {"weight_speed": -1}, "'weight_speed' must be >= 0"),
    *((TurnoverPod, {"borders": borders}, RISE) for borders in ((), (0.5,), (0.3, 0.3, 1.0), (0.5, 0.4, 1.0), (0, 1))),
    (PodFirst, {"pod": "first-come"}, "first-come"),
    (Assignment, {"defer_s": -1}, "'defer_s' must be >= 0"),
    *((Balanced, {"reallocation_s": value}, "must be >= 0|a finite number") for value in (-1.0, math.inf, math.nan)),
    (ChargeWhenLow, {"low": 0.5, "full": 0.5}, "expected low below full"),
    (ChargeWhenLow, {"low": 0.1, "full": 1.5}, "'full' must be <= 1"),
    (ChargeWhenLow, {"low": -0.1, "full": 0.5}, "'low' must be >= 0"),
    *((WhcaN, {"window_s": value}, "'window_s' must be > 0") for value in (0.0, math.nan)),
    *((WhcaN, {"wait_s": value}, r"'wait_s' must be >= 0\.001|a finite number") for value in (0.0, math.inf)),
    (WhcaN, {"max_nodes": 0}, "'max_nodes' must be >= 1"),
    (Pbs, {"most_nodes": -1}, "'most_nodes' must be >= 0"),
    (Alternating, {"rounds": 0}, "'rounds' must be >= 1"),
    (Alternating, {"unused_capacity_weight": 0}, "'unused_capacity_weight' must be > 0"),
    (Alternating, {"max_wait_s": -1}, "'max_wait_s' must be >= 0"),
    *((TwoStage, {"first_share": share}, "'first_share' must be") for share in (0, 1.5)),
    (TwoStage, {"first_orders": "best"}, "'first_orders' must be in"),
    (LargeNeighborhoodSearch, {"iterations": -1}, "'iterations' must be >= 0"),
    *((LargeNeighborhoodSearch, {"share": share}, "'share' must be") for share in (0, 1.1)),
    (LargeNeighborhoodSearch, {"unused_capacity_weight": 0}, "'unused_capacity_weight' must be > 0"),
    (SplitOverTime, {"formulation": "short"}, "'formulation' must be in"),
    (SplitOverTime, {"solver": "glpk"}, "'solver' must be in"),
    (SplitOverTime, {"threads": 0}, "'threads' must be >= 1"),
    (SplitOverTime, {"max_seconds": 0}, "'max_seconds' must be > 0"),
    (SplitOverTime, {"gap": -0.1}, "'gap' must be >= 0"),
    (SplitOverTime, {"unused_capacity_weight": 0}, "'unused_capacity_weight' must be > 0"),
    (SplitOverTime, {"tie_break": "youngest"}, "'tie_break' must be in"),
    (SplitOverTime, {"preferred_pods": "far"}, "'preferred_pods' must be in"),
    (SplitOverTime, {"packing_capacity": -1}, "'packing_capacity' must be >= 0"),
    (SplitOverTime, {"effort": -1}, "'effort' must be >= 0"),
    # The printed form leaves ties to the solver
    *(
        (SplitOverTime, {"formulation": "paper", name: value}, name)
        for name, value in {"tie_break": "oldest", "preferred_pods": "random", "effort": 5}.items()
    ),
)
def test_values_that_mean_nothing_are_refused(rule: type[Any], wrong: dict[str, Any], problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        rule(**wrong)


@cases(
    "rule",
    PodMatch(tie_break="random", late_first=True, fast_lane=2),
    StationQueue(queue_length=1),
    Completes(count_backlog=True),
    WorkAmount(value="age"),
    WorkAmount(value="lateness"),
    Cache(share=1.0, threshold=0.1),
    Assignment(defer_s=0.0),
    Alternating(rounds=1, max_wait_s=60, unused_capacity_weight=0.5),
    TwoStage(first_share=0.2, max_wait_s=60),
    TwoStage(first_orders="oldest"),
    LargeNeighborhoodSearch(max_wait_s=60, share=1.0, iterations=5, unused_capacity_weight=0.5),
    PodIndex(packing_capacity=1),
    PodIndex(urge_s=0, most_pods=1, elsewhere=0),
    pytest.param(BacklogThreshold(open_above=2, timeout_s=10), marks=pytest.mark.slow),
    ids=lambda rule: str(rule)[:60],
)
def test_rules_conform_with_other_parameters(rule: object) -> None:
    assert check_rule(rule).findings == ()


def test_what_a_rule_remembers_is_no_parameter() -> None:
    """It cannot be set, is not shown, and makes no difference between two rules."""
    entries = (entry for entry in entry_points(group="rmfs.rules") if entry.value.startswith("rmfs_rules."))
    rules = filter(has, (entry.load() for entry in entries))
    kept = [field for rule in rules for field in fields(rule) if field.name.startswith("_")]
    assert len(kept) > 9
    assert not any(field.init or field.repr or field.eq for field in kept)
