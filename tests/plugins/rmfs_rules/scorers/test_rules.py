"""PPS rules completes, work-amount and lexicographic."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rmfs_commands.testing import check_rule, small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.scorers import Completes, Lexicographic, WorkAmount

NINE_PODS = {"p0": ["a"], **{f"p{i}": ["z"] for i in range(1, 8)}, "p8": ["a"]}
"""Pods p0 and p8 hold `a`; p8, in the second row, is nearer to the station (14.9 s against 19.0 s)."""


def decide(world: Warehouse, rule: Any, max_fetches: int = 9) -> list[tuple[str, int]]:
    """Return (pod's name, station) of each trip."""
    given = rule.select_pods(WarehouseView(world), max_fetches, np.random.default_rng(1))
    return [(world.pods[one.pod].name, one.station) for one in given]


def assigned(orders: dict[str, Any], pods: dict[str, Any], *begun: int, **settings: Any) -> Warehouse:
    """Return a world with some of its orders, or else all, assigned to the first station."""
    world = small_world(orders, pods, **settings)
    for order in [world.orders[i] for i in begun] or world.orders:
        world.assign(order, world.stations[0], [line.sku for line in order.open_lines])
    return world


def test_orders_completed_come_before_picks() -> None:
    """`many` serves three requests and completes nothing, `whole` completes order 3 with two."""
    orders = {"1": ["a", "x"], "2": ["b", "x"], "3": ["c", "d"], "4": ["e", "x"]}
    world = assigned(orders, {"many": ["a", "b", "e"], "whole": ["c", "d"], "x": ["x"]})
    assert decide(world, Completes(), 1) == [("whole", 0)]


def test_then_most_picks_then_the_nearest() -> None:
    """Nobody completes the order of three; two picks beat one, and of equals p8 is nearer."""
    world = assigned({"1": ["a", "b", "c"]}, {"p": ["a"], "q": ["b", "c"]})
    assert decide(world, Completes(), 1) == [("q", 0)]
    assert decide(assigned({"1": ["a"]}, NINE_PODS), Completes()) == [("p8", 0)]


def test_what_inbound_pods_bring_need_not_be_on_the_pod() -> None:
    """Pod `there` has the `a` of order 1, so `q` completes it; `r` has two picks of order 2, which lacks a third."""
    pods = {"there": ["a"], "q": ["b"], "r": ["c", "d"], "s": ["e"]}
    world = assigned({"1": ["a", "b"], "2": ["c", "d", "e"]}, pods)
    world.bind(world.pods[0], world.stations[0])
    assert decide(world, Completes(), 1) == [("q", 0)]


def test_items_complete_one_order_only() -> None:
    """Three items complete one order of two; one of `b` and one of `c` complete two orders."""
    orders = {"1": {"a": 2}, "2": {"a": 2}, "3": {"b": 1}, "4": {"c": 1}}
    world = assigned(orders, {"p": {"a": 3}, "q": {"b": 1, "c": 1}, "r": {"a": 1}})
    assert decide(world, Completes(), 1) == [("q", 0)]


def test_the_next_pod_is_chosen_for_what_the_first_leaves() -> None:
    """After `p` has come for `a` and `b`, `r` completes nothing that is left; `q` does."""
    orders = {"1": ["a"], "2": ["b"], "3": ["c"]}
    world = assigned(orders, {"p": ["a", "b"], "r": ["a", "b", "z"], "q": ["c"]})
    assert decide(world, Completes()) == [("p", 0), ("q", 0)]


def test_orders_of_the_backlog_count_if_asked_for() -> None:
    """Both pods complete order 1; `q` alone completes the whole order 2 of the backlog, `p` half of order 3."""
    orders = {"1": ["a"], "2": ["b", "c"], "3": ["d", "e"]}
    world = assigned(orders, {"p": ["a", "d"], "q": ["a", "b", "c"], "r": ["e"]}, 0)
    assert decide(world, Completes()) == [("p", 0)]
    assert decide(world, Completes(count_backlog=True)) == [("q", 0)]


def test_items_left_for_the_backlog_are_those_the_station_leaves() -> None:
    """Of two items of `a` on `p` the station takes one; `q` has one of `b` besides, for the order of the backlog."""
    orders = {"1": {"a": 1}, "2": {"a": 2}, "3": {"b": 1}}
    world = assigned(orders, {"p": {"a": 2}, "q": {"a": 1, "b": 1}, "r": {"a": 1}}, 0)
    assert decide(world, Completes(count_backlog=True)) == [("q", 0)]


def test_items_of_the_backlog_complete_one_order_only() -> None:
    """Two items of `b` would serve either of two orders of two, one each of `b` and `c` serve two orders."""
    orders = {"1": {"a": 1}, "2": {"b": 2}, "3": {"b": 2}, "4": {"b": 1}, "5": {"c": 1}}
    pods = {"p": {"a": 1, "b": 2}, "q": {"a": 1, "b": 1, "c": 1}, "r": {"b": 9}}
    assert decide(assigned(orders, pods, 0), Completes(count_backlog=True)) == [("q", 0)]


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({"time_cost_per_s": 0, "completion_boost": 0, "backlog_weight": 0}, "many"),  # 2 against 1
        ({"time_cost_per_s": 0, "completion_boost": 2, "backlog_weight": 0}, "whole"),  # 2 against 1 + 2
        ({"time_cost_per_s": 0, "completion_boost": 0, "backlog_weight": 0.5}, "whole"),  # 2 against 1 + 0.5 * 3
        ({"time_cost_per_s": 1, "completion_boost": 0, "backlog_weight": 0}, "near"),  # 2 - 19 against 1 - 14.9
    ],
)
def test_work_is_weighed(settings: dict[str, float], expected: str) -> None:
    """`many` serves two requests of an order of three, `whole` completes one and has three items for the backlog."""
    orders = {"1": ["a", "b", "x"], "2": ["c"], "3": {"c": 3}}
    pods = {"many": ["a", "b"], "whole": ["c"], **{f"p{i}": ["z"] for i in range(6)}, "near": ["x"]}
    assert decide(assigned(orders, pods, 0, 1), WorkAmount(**settings), 1) == [(expected, 0)]


def test_work_is_age_or_lateness() -> None:
    """Order 1 came 100 s before order 2, and has more items; each item has its share of its order's age."""
    world = assigned({"1": ["a", "b", "c", "d"], "2": ["e"]}, {"p": ["a", "b"], "q": ["e"], "r": ["c", "d"]})
    world.now = 100_000
    plain = {"time_cost_per_s": 0, "completion_boost": 0}
    assert decide(world, WorkAmount(**plain), 1) == [("p", 0)]
    assert decide(world, WorkAmount(value="age", **plain), 1) == [("q", 0)]  # 100 against 2 * 25
    assert decide(world, WorkAmount(value="lateness", **plain), 1) == [("p", 0)]  # nobody is late: the lowest id


def test_scores_decide_in_their_order() -> None:
    """By demand `wanted` comes first, by picks `many`, by lots now one, now the other."""
    orders = {"1": ["a", "b"], "2": ["c", "a"], "3": ["c"], "4": ["c"]}
    world = assigned(orders, {"many": ["a", "b"], "wanted": ["a", "c"]}, 0)
    assert decide(world, Lexicographic(("picks", "demand")), 1) == [("many", 0)]
    assert decide(world, Lexicographic(("demand", "picks")), 1) == [("wanted", 0)]
    view = WarehouseView(world)
    rng = np.random.default_rng(1)
    assert {Lexicographic(("random",)).select_pods(view, 1, rng)[0].pod for _ in range(20)} == {0, 1}


@pytest.mark.parametrize(
    ("scores", "problem"),
    [
        ((), "Length of 'scores' must be >= 1"),
        (("completes", "far"), "'scores' must be in"),
        (("picks", "picks"), "expected each score once"),
    ],
)
def test_scores_have_to_be_known_and_different(scores: tuple[str, ...], problem: str) -> None:
    """A score given twice would decide nothing."""
    with pytest.raises(ValueError, match=problem):
        Lexicographic(scores)


@pytest.mark.parametrize(
    "rule", [Completes(count_backlog=True), WorkAmount(value="age"), WorkAmount(value="lateness"), Lexicographic()]
)
def test_rules_conform_with_other_parameters(rule: object) -> None:
    """In the small worlds that all shipped rules are tried in."""
    assert check_rule(rule).findings == ()
