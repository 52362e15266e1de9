"""What orders lack at stations, as it is kept."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.joint.choosing import Kept, Period
from rmfs_rules.joint.covering import Sent
from rmfs_rules.joint.lacking import Lacking
from rmfs_rules.joint.lacking_search import BLOCKS, OUT, WHERE


def period(world: Warehouse, sent: Sent = ()) -> Period:
    """Return a decision in which pods are sent."""
    begun = Kept().period(WarehouseView(world), None)
    begun.orders.let(begun.pods.available(sent))
    return begun


def lacks(orders: Lacking) -> list[list[int]]:
    """Return the missing lines of each order of the backlog at each station."""
    kept = orders.kept
    rows: list[list[int]] = kept.lacks[:-1, kept.orders[WHERE, orders.places]].tolist()
    return rows


def test_lines_are_missing_until_an_order_has_them_brought() -> None:
    """p is bound for station 0 and has a; b is missing everywhere, until order 2, chosen for station 0, wants it."""
    world = small_world({"1": ["a", "b"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[5, 5])
    world.bind(world.pods[0], world.stations[0])
    now = period(world)
    assert lacks(now.orders) == [[1, 1], [2, 1]]
    now.take(1, 0, now.empty.copy())
    assert lacks(now.orders) == [[0, OUT], [2, OUT + 1]]


def test_pods_that_are_sent_count() -> None:
    """q to station 1."""
    world = small_world({"1": ["a", "b"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[5, 5])
    assert lacks(period(world, [(1, 1)]).orders) == [[2, 1], [1, 0]]


def test_finite_stock_runs_out() -> None:
    """p has two items at the station: enough for 1 or for 2, and once one of them is chosen no pod has any for 3."""
    orders = {"1": {"a": 2}, "2": {"a": 1}, "3": {"a": 1, "b": 1}}
    world = small_world(orders, {"p": {"a": 2}, "q": {"b": 1}})
    world.bind(world.pods[0], world.stations[0])
    now = period(world)
    assert lacks(now.orders) == [[0, 0, 1]]
    now.take(0, 0, now.empty.copy())
    assert [missing >= OUT for missing in lacks(now.orders)[0]] == [True, True, True]
    now.orders.let(now.pods.available(()))
    assert lacks(now.orders) == [[0, 0, 1]]


def test_orders_join_and_leave() -> None:
    """Places stay; sizes, what is wanted, and whether an order is there in part are of those that are left."""
    world = small_world({"1": {"a": 2}, "2": {"a": 1, "b": 3}, "3": {"b": 1}}, {"p": ["a", "b"]}, capacities=[9])
    orders = Lacking()
    orders.update(WarehouseView(world))
    assert (orders.number, orders.most_items, orders.whole) == (3, 4, True)
    assert [*orders.larger_than(1)] == [0, 1]
    world.assign(world.orders[1], world.stations[0], [0])
    orders.update(WarehouseView(world))
    assert (orders.number, orders.whole) == (3, False)
    world.assign(world.orders[1], world.stations[0], [1])
    orders.update(WarehouseView(world))
    assert (orders.places.tolist(), orders.most_items, orders.whole) == ([0, 2], 2, True)
    assert orders.kept.wanted.tolist() == [2, 1]
    assert orders.lines_of([2, 0]) == [(0, 1, 1), (1, 0, 2)]
    assert orders.id_of(2) == world.orders[2].id


def test_blocks_of_orders_that_left_are_used_again() -> None:
    """Twenty thousand orders come and go, one stays: there are few blocks, and it lacks what it lacked."""
    orders = Lacking()
    orders.begin(np.zeros(1, np.bool_), 30, 8)
    orders.join(np.array([[0, 0], [0, 1], [1, 1]]))
    for first in range(2, 20_002, 40):
        lines = np.arange(first, first + 40)
        orders.join(np.stack([lines, lines % 30, 1 + lines % 7]))
        orders.leave(lines.tolist())
    assert orders.places.tolist() == [0]
    assert orders.kept.counts[BLOCKS] < 30
    orders.let(np.array([[0] * 30, [1] * 30]))
    assert lacks(orders) == [[2]]
    orders.let(np.array([[1] + [0] * 29, [1] * 30]))
    assert lacks(orders) == [[1]]
    orders.let(np.zeros((2, 30), np.int64))
    assert lacks(orders) == [[2 + OUT]]
    orders.leave([0, 1])
    assert not orders.number
