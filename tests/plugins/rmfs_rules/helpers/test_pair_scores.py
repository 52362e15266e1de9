"""Scores that are kept from call to call lead to the same decisions as scores that are made anew for each."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rmfs_core
from rmfs_commands.testing import small_world
from rmfs_core import hookimpl
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.common_lines import CommonLines
from rmfs_rules.demand import Demand
from rmfs_rules.due import EarliestDue, LeastSlack
from rmfs_rules.first_come import FirstCome
from rmfs_rules.helpers.pair_scores import PairScores
from rmfs_rules.near_best_pod import NearBestPod
from rmfs_rules.pod_match import PodMatch
from rmfs_rules.workload import Workload

NAMES: dict[type[Any], str] = {
    PodMatch: "pod-match",
    CommonLines: "common-lines",
    FirstCome: "first-come",
    NearBestPod: "near-best-pod",
    Workload: "workload",
    EarliestDue: "earliest-due",
    LeastSlack: "least-slack",
}
OF_ORDERS = (EarliestDue, LeastSlack)
"""Rules that draw no lots and have no ties to break."""
OPTIONS: tuple[dict[str, Any], ...] = (
    {},
    {"max_wait_s": 300},
    {"fast_lane": 1},
    {"tie_break": "due"},
    {"tie_break": "random"},
    {"late_first": True},
    {"late_first": True, "tie_break": "random"},
    {"max_wait_s": 500, "fast_lane": 2, "tie_break": "due", "late_first": True},
)
WORLDS: tuple[tuple[str, ...], ...] = (
    (),  # items are unlimited, stations count items
    ("instance.items_per_sku=3",),  # orders take from each other
    ("stations.order_capacity=4",),
    ("stations.order_capacity=4", "instance.items_per_sku=3"),
    ("instance.due={allowance_s=500,spread_s=400}",),
    ("stations.item_capacity=4",),  # some orders are larger than any station
    ("instance.arrivals.process=refill", "instance.arrivals.backlog=20"),
    ('stations.open={"1"=[["08:00","18:00"]],"2"=[["00:00","00:05"],["00:08","00:00"]]}',),
)


def decided(rule: Any, view: WarehouseView, rng: np.random.Generator) -> list[Any]:
    """Return a rule's assignments."""
    return list(rule.assign_orders(view) if isinstance(rule, OF_ORDERS) else rule.assign_orders(view, rng))


def plainly(rule: Any, view: WarehouseView, rng: np.random.Generator) -> list[Any]:
    """Return the assignments of a rule that keeps nothing: it does so where filters choose what it is shown."""
    return decided(rule, view.showing(view.backlog), rng)


class Doubter:
    """Observer that has each decision made once more, by rules that remember nothing."""

    def __init__(self, rule: type[Any] = PodMatch, **parameters: Any) -> None:
        self.orders = self.pods = 0
        self.rule, self.parameters = rule, parameters
        self.lots: Any = None  # what the rule of the run draws from, as it was before

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        """Keep the random numbers."""
        if question.decides is Role.POA:
            self.lots = deepcopy(question.rng)

    @hookimpl
    def rule_answered(self, question: Question, answer: Any) -> None:
        """Compare."""
        view = question.warehouse
        if question.decides is Role.POA:
            assert list(answer) == plainly(self.rule(**self.parameters), view, self.lots)
            self.orders += len(answer)
        if question.decides is Role.PPS:
            assert list(answer) == Demand().select_pods(view, **question.arguments)
            self.pods += len(answer)


def doubt(rule: type[Any], parameters: dict[str, Any], overrides: tuple[str, ...]) -> Doubter:
    """Doubt every decision of a run."""
    doubter = Doubter(rule, **parameters)
    given = [f"rules.poa.{name}={str(value).lower()}" for name, value in parameters.items()]
    choice = [f"rules.poa.rule={NAMES[rule]}", *given]
    always = ["instance.orders=120", "rules.pp=free-flow", "run.until_s=900"]
    rmfs_core.run("paper-250", overrides=[*always, *overrides, *choice], observers=[doubter])
    return doubter


@pytest.mark.parametrize("overrides", WORLDS, ids=", ".join)
def test_every_decision_of_a_run(overrides: tuple[str, ...]) -> None:
    """Pod-match and demand decide as if each call were their first."""
    doubter = doubt(PodMatch, {}, overrides)
    assert doubter.orders > 15
    assert doubter.pods > 5


@pytest.mark.slow
@pytest.mark.parametrize("overrides", WORLDS, ids=", ".join)
@pytest.mark.parametrize("parameters", OPTIONS, ids=str)
@pytest.mark.parametrize("rule", list(NAMES))
def test_every_decision_of_every_rule(rule: type[Any], parameters: dict[str, Any], overrides: tuple[str, ...]) -> None:
    """So do all rules that keep scores, with each of their parameters."""
    if rule in OF_ORDERS and {"tie_break", "late_first"} & set(parameters):
        parameters = {"max_wait_s": 500, "fast_lane": 2}
    assert doubt(rule, parameters, overrides).orders > 10


@st.composite
def worlds(draw: st.DrawFn) -> dict[str, Any]:
    """Draw orders, pods and stations."""
    skus = "abcdef"
    lines = st.dictionaries(st.sampled_from(skus), st.integers(1, 4), min_size=1, max_size=5)
    orders = {str(i): held for i, held in enumerate(draw(st.lists(lines, min_size=1, max_size=14)))}
    unlimited = draw(st.booleans())
    some = st.lists(st.sampled_from(skus), min_size=1, max_size=4, unique=True)
    pods: dict[str, Any] = {f"p{i}": held for i, held in enumerate(draw(st.lists(some, min_size=1, max_size=4)))}
    if not unlimited:
        pods = {name: {sku: draw(st.integers(1, 6)) for sku in held} for name, held in pods.items()}
    pods["rest"] = list(skus) if unlimited else dict.fromkeys(skus, 99)
    due = {name: draw(st.integers(0, 900)) for name in orders if draw(st.booleans())}
    capacities = draw(st.lists(st.integers(1, 9), min_size=1, max_size=3))
    return {
        "orders": orders,
        "pods": pods,
        "due_s": due,
        "capacities": capacities,
        "counts_orders": draw(st.booleans()),
    }


@settings(max_examples=60)
@given(worlds(), st.sampled_from(list(NAMES)), st.sampled_from(OPTIONS), st.data())
def test_whatever_happens_between_two_decisions(
    told: dict[str, Any], rule: type[Any], parameters: dict[str, Any], data: st.DataObject
) -> None:
    """Pods are bound for stations, time goes by, stations close, and what is decided is carried out."""
    if rule in OF_ORDERS:
        parameters = {name: value for name, value in parameters.items() if name in ("max_wait_s", "fast_lane")}
    world = small_world(told.pop("orders"), told.pop("pods"), **told)
    view = WarehouseView(world)
    keeping, seed = rule(**parameters), data.draw(st.integers(0, 99))
    for _ in range(4):
        answer = decided(keeping, view, np.random.default_rng(seed))
        assert answer == plainly(rule(**parameters), view, np.random.default_rng(seed))
        for one in answer[: data.draw(st.integers(0, len(answer)))]:
            order = world.orders[one.order]
            world.assign(order, world.stations[one.station], [line.sku for line in order.open_lines])
        for pod in world.pods:
            at = data.draw(st.integers(-1, len(world.stations) - 1))
            if at >= 0 and at not in pod.bound_for:
                world.bind(pod, world.stations[at])
        for station in world.stations:
            world.activate(station, data.draw(st.integers(0, 4)) > 0)
        world.advance(world.now + data.draw(st.integers(0, 400_000)))


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


def test_orders_that_a_pod_completes() -> None:
    """Of all their lines the pod has enough; places are counted from the oldest order."""
    world = small_world({"1": {"a": 2, "b": 1}, "2": {"a": 3}, "3": {"b": 1}}, {"p": {"a": 9, "b": 9}})
    scores = PairScores()
    scores.update(WarehouseView(world))
    assert sorted(scores.completed(np.array([2, 1]))) == [0, 2]
    assert [scores.order_at(place) for place in range(3)] == [0, 1, 2]
    assert list(scores.lines_of(0)) == [(0, 2), (1, 1)]
