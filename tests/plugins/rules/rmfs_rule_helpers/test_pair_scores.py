"""Scores that are kept from call to call lead to the same decisions as scores that are made anew for each."""

from __future__ import annotations

from typing import Any

import pytest

import rmfs_core
from rmfs_common_lines import CommonLines
from rmfs_core import hookimpl
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_core.warehouse import WarehouseView
from rmfs_demand import Demand
from rmfs_first_come import FirstCome
from rmfs_near_best_pod import NearBestPod
from rmfs_pod_match import PodMatch
from rmfs_rule_helpers.pair_scores import KeptPairs
from rmfs_testing import small_world


class Doubter:
    """Observer that has each decision made once more, by rules that remember nothing."""

    def __init__(self, rule: type[KeptPairs] = PodMatch) -> None:
        self.orders = self.pods = 0
        self.rule = rule

    @hookimpl
    def rule_answered(self, question: Question, answer: Any) -> None:
        """Compare."""
        view = question.warehouse
        if question.decides is Role.POA:
            every: Any = self.rule(late_first=True)  # none is ever late, but all orders are looked through one by one
            assert list(answer) == every.assign_orders(view, question.rng)
            self.orders += len(answer)
        if question.decides is Role.PPS:
            assert list(answer) == Demand().select_pods(view, **question.arguments)
            self.pods += len(answer)


@pytest.mark.parametrize(
    "overrides",
    [
        [],  # items are unlimited, stations count items
        ["instance.items_per_sku=3"],  # orders take from each other
        ["stations.order_capacity=4"],
        ["instance.arrivals.process=refill", "instance.arrivals.backlog=20"],
        ["stations.item_capacity=4"],  # some orders are larger than any station
    ],
    ids=", ".join,
)
def test_every_decision_of_a_run(overrides: list[str]) -> None:
    """Pod-match and demand decide as if each call were their first."""
    doubter = Doubter()
    always = ["instance.orders=120", "rules.pp=free-flow", "run.until_s=900"]
    rmfs_core.run("paper-250", overrides=[*always, *overrides], observers=[doubter])
    assert doubter.orders > 15
    assert doubter.pods > 5


@pytest.mark.parametrize("counts", ["stations.order_capacity=4", "stations.item_capacity=15"])
@pytest.mark.parametrize("rule", [CommonLines, FirstCome, NearBestPod])
def test_other_rules_that_keep_scores(rule: type[KeptPairs], counts: str) -> None:
    """They decide as if each call were their first, too."""
    doubter = Doubter(rule)
    overrides = ["instance.orders=90", "rules.pp=free-flow", "run.until_s=600", counts]
    name = {CommonLines: "common-lines", FirstCome: "first-come", NearBestPod: "near-best-pod"}[rule]
    rmfs_core.run("paper-250", overrides=[*overrides, f"rules.poa={name}"], observers=[doubter])
    assert doubter.orders > 15


def test_a_rule_forgets_another_warehouse() -> None:
    """What a rule remembers of one warehouse is of no matter in the next."""
    rule = PodMatch()
    for wanted, station in (("a", 0), ("b", 1)):
        world = small_world({"order": [wanted]}, {"p": ["a"], "q": ["b"]}, capacities=[1, 1])
        world.bind(world.pods[0], world.stations[0])
        world.bind(world.pods[1], world.stations[1])
        (chosen,) = rule.assign_orders(WarehouseView(world), None)  # type: ignore[arg-type]
        assert chosen.station == station


def test_pods_that_are_filled_again() -> None:
    """A bundle that is stored changes what a pod holds, and what is wanted of it."""
    doubter = Doubter()
    result = rmfs_core.run(
        "examples/replenished", overrides=["rules.pps=demand", "rules.poa=pod-match"], observers=[doubter]
    )
    assert result.metrics["picks"] > 0
    assert doubter.pods > 5
