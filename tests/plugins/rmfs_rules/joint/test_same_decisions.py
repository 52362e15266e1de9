"""Joint rules that keep accounts from call to call decide as plain ones do that make everything anew."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import deepcopy
from typing import Any

import numpy as np
import pytest
from attrs import define
from hypothesis import given, settings
from hypothesis import strategies as st

import plain_joint
import rmfs_core
from rmfs_commands.testing import small_world
from rmfs_core import JointDecision, hookimpl
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_core.warehouse import Order, Warehouse, WarehouseView
from rmfs_rules.joint import Alternating, LargeNeighborhoodSearch, TwoStage

RULES: dict[str, tuple[type[Any], Callable[..., JointDecision]]] = {
    "alternating": (Alternating, plain_joint.alternating),
    "two-stage": (TwoStage, plain_joint.two_stage),
    "lns": (LargeNeighborhoodSearch, plain_joint.lns),
}
OPTIONS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("alternating", {}),
    ("alternating", {"max_wait_s": 300, "unused_capacity_weight": 0.5}),
    ("two-stage", {}),
    ("two-stage", {"first_orders": "oldest", "max_wait_s": 300}),
    ("two-stage", {"first_share": 0.3}),
    ("lns", {"iterations": 4}),
    ("lns", {"iterations": 4, "share": 1.0, "max_wait_s": 300}),
)
WORLDS: tuple[tuple[str, ...], ...] = (
    (),  # items are unlimited, stations count items
    ("instance.items_per_sku=3",),  # orders take from each other
    ("stations.order_capacity=4",),
    ("stations.order_capacity=4", "instance.items_per_sku=3"),
    ("stations.item_capacity=4",),  # some orders are larger than any station
    ("instance.arrivals.process=refill", "instance.arrivals.backlog=20"),
    ("instance.skus=1000", "instance.skus_per_pod=12", "instance.arrivals={process='refill',backlog=80}"),
    ('stations.open={"1"=[["08:00","18:00"]],"2"=[["00:00","00:05"],["00:08","00:00"]]}',),
)


def decided(rule: Any, view: WarehouseView, rng: np.random.Generator) -> JointDecision:
    """Return a rule's decision; lns alone draws."""
    draws = isinstance(rule, LargeNeighborhoodSearch)
    decision: JointDecision = rule.assign_orders_and_pods(*(view, rng) if draws else (view,))
    return decision


class Doubter:
    """Observer that has each decision made once more, by a rule that keeps nothing."""

    def __init__(self, name: str, **parameters: Any) -> None:
        self.plain, self.parameters, self.orders, self.calls = RULES[name][1], parameters, 0, 0

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        """Keep the random numbers."""
        if question.decides is Role.POA_PPS:
            self.lots = deepcopy(question.rng)

    @hookimpl
    def rule_answered(self, question: Question, answer: Any) -> None:
        """Compare."""
        if question.decides is Role.POA_PPS:
            assert answer == self.plain(question.warehouse, self.lots, **self.parameters)
            self.orders += len(answer.assignments)
            self.calls += 1


@define
class OfEvenId:
    """Filter that shows every other order."""

    @hookimpl
    def filter_backlog(self, orders: Sequence[Order]) -> Sequence[Order]:
        """Leave out those with an odd id."""
        return [order for order in orders if order.id % 2 == 0]


def doubt(name: str, parameters: dict[str, Any], overrides: Sequence[str], scenario: str = "paper-250") -> Doubter:
    """Doubt every decision of a run."""
    doubter = Doubter(name, **parameters)
    given = [f"rules.poa_pps.{parameter}={value}" for parameter, value in parameters.items()]
    always = ["rules.pp=free-flow", "run.until_s=900", f"rules.poa_pps.rule={name}"]
    rmfs_core.run(scenario, overrides=[*always, *overrides, *given], observers=[doubter])
    return doubter


@pytest.mark.parametrize("overrides", WORLDS, ids=", ".join)
@pytest.mark.parametrize("name", list(RULES))
def test_every_decision_of_a_run(name: str, overrides: tuple[str, ...]) -> None:
    """All decide as if each call were their first."""
    parameters = {"iterations": 2} if name == "lns" else {}
    assert doubt(name, parameters, ["instance.orders=120", "run.until_s=600", *overrides]).orders > 12


@pytest.mark.slow
@pytest.mark.parametrize("overrides", WORLDS, ids=", ".join)
@pytest.mark.parametrize(("name", "parameters"), OPTIONS, ids=str)
def test_every_decision_with_every_parameter(name: str, parameters: dict[str, Any], overrides: tuple[str, ...]) -> None:
    """So do they over longer runs."""
    assert doubt(name, parameters, overrides).orders > 12


@pytest.mark.parametrize("name", list(RULES))
def test_pods_that_are_filled_again(name: str) -> None:
    """Bundles that are stored change what pods have, SKUs that they never held among it."""
    parameters = {"iterations": 2} if name == "lns" else {}
    assert doubt(name, parameters, ["run.until_s=3600"], "examples/replenished").orders > 12


@pytest.mark.parametrize("name", list(RULES))
def test_what_a_filter_leaves(name: str) -> None:
    """Nothing is kept of what they are shown."""
    rule = RULES[name][0]
    parameters = {"iterations": 2} if name == "lns" else {}
    doubter = Doubter(name, **parameters)
    rmfs_core.run(
        "paper-250",
        overrides=["rules.pp=free-flow", "run.until_s=400", "instance.orders=80"],
        rules={"poa_pps": rule(**parameters), "filters": [OfEvenId()]},
        observers=[doubter],
    )
    assert doubter.orders > 12


@st.composite
def worlds(draw: st.DrawFn) -> dict[str, Any]:
    """Draw orders, pods and stations; all pods together have what all orders want."""
    skus = "abcdef"
    lines = st.dictionaries(st.sampled_from(skus), st.integers(1, 4), min_size=1, max_size=5)
    orders = {str(i): held for i, held in enumerate(draw(st.lists(lines, min_size=1, max_size=14)))}
    unlimited = draw(st.booleans())
    some = st.lists(st.sampled_from(skus), min_size=1, max_size=4, unique=True)
    pods: dict[str, Any] = {f"p{i}": held for i, held in enumerate(draw(st.lists(some, min_size=1, max_size=6)))}
    if not unlimited:
        pods = {name: {sku: draw(st.integers(1, 6)) for sku in held} for name, held in pods.items()}
    pods["rest"] = list(skus) if unlimited else dict.fromkeys(skus, 56)
    return {
        "orders": orders,
        "pods": pods,
        "capacities": draw(st.lists(st.integers(1, 12), min_size=1, max_size=3)),
        "counts_orders": draw(st.booleans()),
    }


@settings(max_examples=80)
@given(worlds(), st.sampled_from(OPTIONS), st.data())
def test_whatever_happens_between_two_decisions(
    told: dict[str, Any], option: tuple[str, dict[str, Any]], data: st.DataObject
) -> None:
    """Decisions are carried out, or in part, orders are split, pods bound, time goes by, and stations close."""
    name, parameters = option
    world = small_world(told.pop("orders"), told.pop("pods"), **told)
    (rule, plain), view, seed = RULES[name], WarehouseView(world), data.draw(st.integers(0, 99))
    keeping = rule(**parameters)
    for _ in range(3):
        answer = decided(keeping, view, np.random.default_rng(seed))
        assert answer == plain(view, np.random.default_rng(seed), **parameters)
        shown = [order for order in view.backlog if data.draw(st.booleans())]
        few = view.showing(shown)
        assert decided(keeping, few, np.random.default_rng(seed)) == plain(
            few, np.random.default_rng(seed), **parameters
        )
        carry_out(world, answer, data, in_part=parameters.get("max_wait_s") is None)
        for pod in world.pods:
            at = data.draw(st.integers(-1, len(world.stations) - 1))
            if at >= 0 and at not in pod.bound_for:
                world.bind(pod, world.stations[at])
        for station in world.stations:
            world.activate(station, data.draw(st.integers(0, 4)) > 0)
        world.advance(world.now + data.draw(st.integers(0, 400_000)))


def carry_out(world: Warehouse, decision: JointDecision, data: st.DataObject, in_part: bool) -> None:
    """Assign some of the orders that were chosen, perhaps in part, and send some of the pods."""
    for one in decision.assignments[: data.draw(st.integers(0, len(decision.assignments)))]:
        skus = [line.sku for line in world.orders[one.order].open_lines]
        number = data.draw(st.integers(1, len(skus))) if in_part else len(skus)
        world.assign(world.orders[one.order], world.stations[one.station], skus[:number])
    for trip in decision.trips[: data.draw(st.integers(0, len(decision.trips)))]:
        world.bind(world.pods[trip.pod], world.stations[trip.station])
