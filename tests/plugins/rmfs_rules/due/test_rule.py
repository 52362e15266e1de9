"""POA rules earliest-due and least-slack."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.due import EarliestDue, LeastSlack

ORDERS = {"never": {"a": 1}, "large": {"a": 4}, "small": {"a": 1}, "twin": {"a": 1}, "late": {"a": 1}}
DUE_S = {"large": 160, "small": 120, "twin": 120, "late": 5}


def decide(world: Warehouse, rule: EarliestDue | LeastSlack) -> list[tuple[str, int]]:
    """Return (order's name, station) of each assignment."""
    return [(world.orders[one.order].name, one.station) for one in rule.assign_orders(WarehouseView(world))]


def test_the_order_that_is_due_first_goes_first() -> None:
    """Each to the station with the lowest load: 1/0, 1/1, 2/1, and four items fit where five are free only."""
    world = small_world(ORDERS, {"p": ["a"]}, capacities=[6, 4], due_s=DUE_S)
    assert decide(world, EarliestDue()) == [("late", 0), ("small", 1), ("twin", 0), ("large", 0), ("never", 1)]


def test_the_order_with_least_time_to_spare_goes_first() -> None:
    """Slack: late -8, large 160 - 52 = 108, small and twin 107; with 15 s an item large has 100, they have 105."""
    world = small_world(ORDERS, {"p": ["a"]}, capacities=[20], due_s=DUE_S)
    assert [name for name, _ in decide(world, LeastSlack())] == ["late", "small", "twin", "large", "never"]
    assert [name for name, _ in decide(world, LeastSlack(item_s=15))] == ["late", "large", "small", "twin", "never"]


def test_only_open_items_take_time() -> None:
    """Of four items three are assigned: 160 - 15 is more than 120 - 15."""
    world = small_world({"1": {"a": 1, "b": 3}, "2": {"a": 1}}, {"p": ["a", "b"]}, due_s={"1": 160, "2": 120})
    assert decide(world, LeastSlack(item_s=15))[0] == ("1", 0)
    world.assign(world.orders[0], world.stations[0], [1])
    assert decide(world, LeastSlack(item_s=15))[0] == ("2", 0)


@pytest.mark.parametrize("seed", range(30))
def test_no_order_that_fits_has_to_wait_for_one_with_more_time(seed: int) -> None:
    """Step by step: of the orders that still fit anywhere, none has a lower rank than the one assigned."""
    rng = np.random.default_rng(seed)
    orders = {str(i): {"a": int(rng.integers(1, 6))} for i in range(12)}
    due_s = {str(i): float(rng.integers(0, 200)) for i in range(12) if rng.random() < 0.7}
    for rule, item_s in ((EarliestDue(), 0), (LeastSlack(item_s=20), 20)):
        world = small_world(orders, {"p": ["a"]}, capacities=[7, 9], due_s=due_s)

        def rank(name: str, item_s: int = item_s) -> tuple[float, int]:
            return due_s.get(name, np.inf) - item_s * orders[name]["a"], int(name)

        for name, station in decide(world, rule):
            open_orders = [(order, at) for order in world.backlog.orders for at in world.stations]
            fitting = {order.name for order, at in open_orders if world.size_at(order, at) <= at.free_capacity}
            assert name == min(fitting, key=rank)
            assert station == min((s.load, s.id) for s in world.stations if s.free_capacity >= orders[name]["a"])[1]
            world.assign(world.orders[int(name)], world.stations[station], [0])


def test_a_time_below_zero_is_refused() -> None:
    """No item takes less than no time."""
    with pytest.raises(ValueError, match="'item_s' must be >= 0"):
        LeastSlack(item_s=-1)
