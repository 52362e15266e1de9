"""Joint rule lns."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from rmfs_commands.testing import check_rule, small_world
from rmfs_core import JointDecision
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.joint import Alternating, LargeNeighborhoodSearch, lns

Hold = Callable[[Callable[[WarehouseView, int], JointDecision]], list[float]]


def decide(world: Warehouse, seed: int = 0, **parameters: Any) -> tuple[list[tuple[str, int]], list[tuple[str, int]]]:
    """Return (order's name, station) of each assignment, and (pod's name, station) of each trip, by name."""
    rule = LargeNeighborhoodSearch(**parameters)
    decision = rule.assign_orders_and_pods(WarehouseView(world), np.random.default_rng(seed))
    return (
        sorted((world.orders[one.order].name, one.station) for one in decision.assignments),
        sorted((world.pods[one.pod].name, one.station) for one in decision.trips),
    )


def test_it_conforms() -> None:
    """With parameters other than the defaults, in every trial world: finite stock, order capacity, later arrivals."""
    check_rule(LargeNeighborhoodSearch(max_wait_s=60, share=1.0, iterations=5, unused_capacity_weight=0.5))


@pytest.mark.parametrize("seed", range(5))
def test_by_hand(seed: int) -> None:
    """Two places. The two oldest orders take two pods, 2 and 3 one: whoever takes order 1 back finds 3 on the pod of 2.

    Choosing in turn does not find that: each order has its pod as soon as it is chosen, and the oldest go.
    """
    orders, pods = {"1": ["a"], "2": ["b"], "3": ["c"]}, {"p": ["a"], "q": ["b", "c"]}
    assert decide(small_world(orders, pods, capacities=[2]), iterations=0) == (
        [("1", 0), ("2", 0)],
        [("p", 0), ("q", 0)],
    )
    assert decide(small_world(orders, pods, capacities=[2]), seed) == ([("2", 0), ("3", 0)], [("q", 0)])


@pytest.mark.parametrize("seed", range(5))
def test_of_equal_costs_the_oldest_orders_go(seed: int) -> None:
    """Each order needs a pod of its own: nothing is better than the two oldest."""
    orders, pods = {str(i): "abcdef"[i] for i in range(6)}, {f"p{sku}": [sku] for sku in "abcdef"}
    assert decide(small_world(orders, pods, capacities=[2]), seed)[0] == [("0", 0), ("1", 0)]


def test_orders_that_have_waited_too_long_stay() -> None:
    """As by hand, but order 1 has waited since 0 s, the others are as late and order 3 is left: nothing is improved."""
    orders, pods = {"1": ["a"], "2": ["b"], "3": ["c"]}, {"p": ["a"], "q": ["b", "c"]}
    world = small_world(orders, pods, capacities=[2])
    world.now = 60_000
    assert decide(world, max_wait_s=60)[0] == [("1", 0), ("2", 0)]
    assert decide(world, max_wait_s=61)[0] == [("2", 0), ("3", 0)]


def test_the_cost_falls_with_the_iterations_and_is_never_below_the_optimum(held_against_the_optimum: Hold) -> None:
    """On random periods, where the kernel would take each decision; with none it is that of alternating."""

    def after(iterations: int) -> Callable[[WarehouseView, int], JointDecision]:
        rule = LargeNeighborhoodSearch(iterations=iterations)
        return lambda view, seed: rule.assign_orders_and_pods(view, np.random.default_rng(seed))

    missed = [held_against_the_optimum(after(iterations)) for iterations in (0, 5, 50)]
    assert missed[0] == held_against_the_optimum(lambda view, seed: Alternating().assign_orders_and_pods(view))
    for fewer, more in pairwise(missed):
        assert all(later <= earlier for earlier, later in zip(fewer, more, strict=True))
        assert sum(more) < sum(fewer)
    assert min(missed[-1]) == 0
    assert missed[-1].count(0) >= 54


def test_few_of_many_orders(monkeypatch: pytest.MonkeyPatch, held_against_the_optimum: Hold) -> None:
    """Where it looks at two orders besides those that are chosen, it is no worse than alternating, sometimes better."""
    start = held_against_the_optimum(lambda view, seed: Alternating().assign_orders_and_pods(view))
    monkeypatch.setattr(lns, "MOST_ORDERS", 2)
    rule = LargeNeighborhoodSearch()
    few = held_against_the_optimum(lambda view, seed: rule.assign_orders_and_pods(view, np.random.default_rng(seed)))
    assert all(later <= earlier for earlier, later in zip(start, few, strict=True))
    assert sum(few) < sum(start)


def test_the_same_seed_gives_the_same_decision() -> None:
    """Nothing but the random numbers that it is given is random."""
    rng = np.random.default_rng(3)
    orders = {str(i): [str(sku) for sku in rng.choice(12, 3, False)] for i in range(30)}
    pods = {f"p{i}": [str(sku) for sku in rng.choice(12, 3, False)] for i in range(9)} | {
        "all": [str(i) for i in range(12)]
    }

    def taken(seed: int) -> tuple[list[tuple[str, int]], list[tuple[str, int]]]:
        return decide(small_world(orders, pods, capacities=[12, 12]), seed)

    assert taken(1) == taken(1)


@pytest.mark.parametrize("wrong", [{"iterations": -1}, {"share": 0}, {"share": 1.1}, {"unused_capacity_weight": 0}])
def test_bad_parameters(wrong: dict[str, Any]) -> None:
    """They are refused."""
    with pytest.raises(ValueError, match=next(iter(wrong))):
        LargeNeighborhoodSearch(**wrong)
