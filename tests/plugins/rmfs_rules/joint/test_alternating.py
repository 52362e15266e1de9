"""Joint rule alternating."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import pytest

from rmfs_commands.testing import check_rule, small_world
from rmfs_core import JointDecision
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.joint import Alternating
from rmfs_rules.joint.alternating import improving
from rmfs_rules.joint.choosing import Period

Put = Callable[[Warehouse, int, int], None]
Hold = Callable[[Callable[[WarehouseView, int], JointDecision]], list[float]]


def decide(world: Warehouse, **parameters: float) -> tuple[list[tuple[str, int]], list[tuple[str, int]]]:
    """Return (order's name, station) of each assignment, and (pod's name, station) of each trip, by name."""
    decision = Alternating(**parameters).assign_orders_and_pods(WarehouseView(world))  # type: ignore[arg-type]
    return (
        sorted((world.orders[one.order].name, one.station) for one in decision.assignments),
        sorted((world.pods[one.pod].name, one.station) for one in decision.trips),
    )


def improvable() -> Warehouse:
    """Six places, two orders of three items for them.

    The oldest comes first, and lacks as much as any other. p, which brings most of it, and q together have all of 3.
    """
    orders = {"1": ["a", "b", "c"], "2": ["d", "e", "f"], "3": ["a", "b", "x"]}
    return small_world(orders, {"p": ["a", "b"], "q": ["c", "x"], "r": ["d", "e"], "s": ["f"]}, capacities=[6])


def test_it_conforms() -> None:
    """With parameters other than the defaults, in every trial world: finite stock, order capacity, later arrivals."""
    check_rule(Alternating(rounds=1, max_wait_s=60, unused_capacity_weight=0.5))


def test_orders_for_pods_and_pods_for_orders_by_hand() -> None:
    """Order 1 lacks p and q, and then 3 lacks x alone of its three lines, 2 all of them. p and q bring what both want.

    Orders 1 and 3 fill the places with two visits; 1 and 2 would take four.
    """
    assert decide(improvable()) == ([("1", 0), ("3", 0)], [("p", 0), ("q", 0)])


def test_the_second_time_orders_go_by_the_pods_that_are_sent() -> None:
    """Four places. Order 1 takes two and has to have x brought, hence 3 lacks one of two lines, and 2 both of them.

    1 and 3 take three pods. But p, sent for a, has all of 2 as well: with the three there, no order lacks anything, the
    oldest go, and 1 and 2 take two.
    """
    orders, pods = {"1": ["a", "x"], "2": ["c", "d"], "3": ["x", "b"]}, {"p": ["a", "c", "d"], "q": ["x"], "r": ["b"]}
    first = decide(small_world(orders, pods, capacities=[4]), rounds=1)
    assert first == ([("1", 0), ("3", 0)], [("p", 0), ("q", 0), ("r", 0)])
    assert decide(small_world(orders, pods, capacities=[4])) == ([("1", 0), ("2", 0)], [("p", 0), ("q", 0)])


def test_what_is_there_goes_first(put_at_station: Put) -> None:
    """The older order would need a pod, the younger one is on the pod that is there."""
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[1])
    put_at_station(world, 1, 0)
    assert decide(world) == ([("2", 0)], [])


def test_the_cost_falls_from_choice_to_choice_and_is_never_below_the_optimum(held_against_the_optimum: Hold) -> None:
    """On random periods; some are improved, and most are decided as well as the model does."""
    improved = 0

    def best(view: WarehouseView, seed: int) -> JointDecision:
        nonlocal improved
        rule = Alternating()
        costs = [cost for cost, _, _ in improving(Period(view, None), 10, 2.0)]
        assert all(later < earlier for earlier, later in pairwise(costs))
        decision = rule.assign_orders_and_pods(view)
        assert decision.report is None or decision.report.objective == costs[-1]
        improved += len(costs) > 1
        return decision

    missed = held_against_the_optimum(best)
    assert min(missed) == 0
    assert sum(missed) / len(missed) < 1
    assert improved


@pytest.mark.parametrize("wrong", [{"rounds": 0}, {"unused_capacity_weight": 0}, {"max_wait_s": -1}])
def test_bad_parameters(wrong: dict[str, float]) -> None:
    """They are refused."""
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Alternating(**wrong)  # type: ignore[arg-type]
