"""One decision: orders for stations, and what that costs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import plain_joint
from rmfs_commands.testing import small_world
from rmfs_core import JointDecision, OrderAssignment, PodTrip, SolveReport
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.helpers import ticks_to_station
from rmfs_rules.joint import Alternating, LargeNeighborhoodSearch, TwoStage
from rmfs_rules.joint.choosing import Period


def period(world: Warehouse, max_wait_s: float | None = None) -> Period:
    """Return a decision."""
    return Period(WarehouseView(world), max_wait_s)


def test_orders_go_by_places() -> None:
    """One line missing for three items is better than one for two; where orders are counted, both take one place."""
    orders = {"1": {"b": 2}, "2": {"b": 3}, "3": {"a": 1}}
    for counts_orders, expected in ((False, [2, 1]), (True, [2, 0, 1])):
        world = small_world(orders, {"p": ["a"], "q": ["b"]}, capacities=[4], counts_orders=counts_orders)
        world.bind(world.pods[0], world.stations[0])
        assert period(world).filled([]) == [(place, 0) for place in expected]


def test_an_order_in_part() -> None:
    """What is left of it is in question; at a station that counts orders, where it has a place, it takes none."""
    world = small_world({"1": ["a", "b"], "2": ["a"]}, {"p": ["a", "b"]}, capacities=[1, 1], counts_orders=True)
    world.assign(world.orders[0], world.stations[0], [0])
    assert period(world).filled([(0, 0)]) == [(0, 0), (1, 1)]


def test_few_orders() -> None:
    """Those that are chosen and those that lack least."""
    orders = {"1": ["b"], "2": ["b", "c"], "3": ["a"], "4": ["c"], "5": ["a"]}
    world = small_world(orders, {"p": ["a"], "q": ["b", "c"]}, capacities=[2])
    world.bind(world.pods[0], world.stations[0])
    assert period(world).foremost(2, [(1, 0)], []).tolist() == [1, 2, 4]
    assert period(world).foremost(5, [(1, 0)], []).tolist() == [0, 1, 2, 3, 4]


@pytest.mark.parametrize(("counts_orders", "expected"), [(False, 2 + 1.5 * 6), (True, 2 + 1.5 * 3 * 8)])
def test_the_cost(counts_orders: bool, expected: float) -> None:
    """One visit is under way, one is new; of 9 places the order takes three, or one where stations count orders.

    There a free place counts three times, for the order of three items.
    """
    world = small_world({"1": {"a": 2, "b": 1}}, {"p": ["a"], "q": ["b"]}, capacities=[9], counts_orders=counts_orders)
    world.bind(world.pods[0], world.stations[0])
    assert period(world).cost([(0, 0)], [(1, 0)], 1.5) == expected


def test_the_decision() -> None:
    """Ids, not places; nothing chosen is no decision."""
    world = small_world({"1": ["a"], "2": ["a"]}, {"p": ["a"]})
    world.assign(world.orders[0], world.stations[0], [0])
    now = Period(WarehouseView(world).showing(world.orders[1:]), None)
    given = now.decision([(0, 0)], [(0, 0)], 2.0)
    assert given.assignments == (OrderAssignment(1, 0),)
    assert given.trips == (PodTrip(0, 0),)
    assert given.report == SolveReport("heuristic", 2.0)
    assert now.decision([], [], 2.0).report is None


def test_pods_that_later_ones_make_needless_stay() -> None:
    """p has most, four of six; then q and r have one of the two others each, and together all that p was sent for."""
    world = small_world({"1": ["a", "b", "c", "d", "e", "f"]}, {"p": "abcd", "q": "abe", "r": "cdf"})
    assert sorted(period(world).pods_for([(0, 0)])) == [(1, 0), (2, 0)]


def test_a_pod_goes_to_two_stations_and_its_items_are_shared() -> None:
    """Of finite stock: p has three, two go to station 0, one to station 1, and q brings what is lacking there."""
    world = small_world({"1": {"a": 2}, "2": {"a": 2}}, {"p": {"a": 3}, "q": {"a": 1}}, capacities=[5, 5])
    assert sorted(period(world).pods_for([(0, 0), (1, 1)])) == [(0, 0), (0, 1), (1, 1)]


def test_equal_pods() -> None:
    """The one that is bound for no station goes, then the one with most that is wanted, then the nearest."""
    held = {str(i): ["a", "b"] if i == 4 else ["a"] for i in range(9)}
    world = small_world({"1": ["a"], "2": ["b"]}, held, capacities=[5, 5])
    view = WarehouseView(world)
    nearest = min(world.pods, key=lambda pod: (ticks_to_station(view, pod, world.stations[0]), pod.id)).id
    assert nearest != 4
    assert period(world).pods_for([(0, 0)]) == [(nearest, 0)]
    assert period(world).pods_for([(0, 0)], by_worth=True) == [(4, 0)]
    world.bind(world.pods[4], world.stations[1])
    assert period(world).pods_for([(0, 0)], by_worth=True) == [(nearest, 0)]


def test_what_stations_and_all_pods_have() -> None:
    """p is bound for station 0, q is sent to station 1; all pods together have what nothing was promised of."""
    world = small_world({"1": {"a": 1}}, {"p": {"a": 3}, "q": {"a": 2, "b": 5}}, capacities=[5, 5])
    world.bind(world.pods[0], world.stations[0])
    choice = period(world).choice([(1, 1)], [])
    assert (choice.at.tolist(), choice.supply.tolist()) == ([[3, 0], [2, 5]], [5, 5])
    world.assign(world.orders[0], world.stations[0], [0])
    choice = period(world).choice([], [])
    assert (choice.at.tolist(), choice.supply.tolist()) == ([[2, 0], [0, 0]], [4, 5])


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


def decided(rule: Any, view: WarehouseView, rng: np.random.Generator) -> JointDecision:
    """Return a rule's decision; lns alone draws."""
    draws = isinstance(rule, LargeNeighborhoodSearch)
    decision: JointDecision = rule.assign_orders_and_pods(*(view, rng) if draws else (view,))
    return decision


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
    for _ in range(3):
        answer = decided(rule(**parameters), view, np.random.default_rng(seed))
        assert answer == plain(view, np.random.default_rng(seed), **parameters)
        shown = [order for order in view.backlog if data.draw(st.booleans())]
        few = view.showing(shown)
        assert decided(rule(**parameters), few, np.random.default_rng(seed)) == plain(
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
