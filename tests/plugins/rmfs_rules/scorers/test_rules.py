from typing import Any

import numpy as np
import pytest

from cases import cases
from rmfs_commands.testing import check_rule, small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.scorers import Completes, Lexicographic, WorkAmount


def decide(world: Warehouse, rule: Any, max_fetches: int = 9) -> list[tuple[str, int]]:
    given = rule.select_pods(WarehouseView(world), max_fetches, np.random.default_rng(1))
    return [(world.pods[one.pod].name, one.station) for one in given]


def assigned(orders: dict[str, Any], pods: dict[str, Any], *begun: int, **settings: Any) -> Warehouse:
    world = small_world(orders, pods, **settings)
    for order in [world.orders[i] for i in begun] or world.orders:
        world.assign(order, world.stations[0], [line.sku for line in order.open_lines])
    return world


def test_orders_completed_come_first() -> None:
    orders = {"1": ["a", "x"], "2": ["b", "x"], "3": ["c", "d"], "4": ["e", "x"]}
    world = assigned(orders, {"many": ["a", "b", "e"], "whole": ["c", "d"], "x": ["x"]})
    assert decide(world, Completes(), 1) == [("whole", 0)]
    orders = {"1": ["a"], "2": ["b", "c"], "3": ["d", "e"]}
    world = assigned(orders, {"p": ["a", "d"], "q": ["a", "b", "c"], "r": ["e"]}, 0)
    assert decide(world, Completes()) == [("p", 0)]
    assert decide(world, Completes(count_backlog=True)) == [("q", 0)]


@cases(
    "settings expected",
    ({"time_cost_per_s": 0, "completion_boost": 0, "backlog_weight": 0}, "many"),  # 2 against 1
    ({"time_cost_per_s": 0, "completion_boost": 2, "backlog_weight": 0}, "whole"),  # 2 against 1 + 2
    ({"time_cost_per_s": 0, "completion_boost": 0, "backlog_weight": 0.5}, "whole"),  # 2 against 1 + 0.5 * 3
    ({"time_cost_per_s": 1, "completion_boost": 0, "backlog_weight": 0}, "near"),  # 2 - 19 against 1 - 14.9
)
def test_work_is_weighed(settings: dict[str, float], expected: str) -> None:
    """`many` serves two requests of an order of three, `whole` completes one and has three items for the backlog."""
    orders = {"1": ["a", "b", "x"], "2": ["c"], "3": {"c": 3}}
    pods = {"many": ["a", "b"], "whole": ["c"], **{f"p{i}": ["z"] for i in range(6)}, "near": ["x"]}
    assert decide(assigned(orders, pods, 0, 1), WorkAmount(**settings), 1) == [(expected, 0)]


def test_scores_decide_in_their_order() -> None:
    """By demand `wanted` comes first, by picks `many`, by lots now one, now the other."""
    orders = {"1": ["a", "b"], "2": ["c", "a"], "3": ["c"], "4": ["c"]}
    world = assigned(orders, {"many": ["a", "b"], "wanted": ["a", "c"]}, 0)
    assert decide(world, Lexicographic(("picks", "demand")), 1) == [("many", 0)]
    assert decide(world, Lexicographic(("demand", "picks")), 1) == [("wanted", 0)]
    view = WarehouseView(world)
    rng = np.random.default_rng(1)
    assert {Lexicographic(("random",)).select_pods(view, 1, rng)[0].pod for _ in range(20)} == {0, 1}


@cases(
    "scores problem",
    ((), "Length of 'scores' must be >= 1"),
    (("completes", "far"), "'scores' must be in"),
    (("picks", "picks"), "expected each score once"),
)
def test_scores_have_to_be_known_and_different(scores: tuple[str, ...], problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        Lexicographic(scores)


@cases("rule", Completes(count_backlog=True), WorkAmount(value="age"), WorkAmount(value="lateness"), Lexicographic())
def test_rules_conform_with_other_parameters(rule: object) -> None:
    assert check_rule(rule).findings == ()
