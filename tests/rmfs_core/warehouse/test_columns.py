"""What columns tell of a small warehouse."""

from __future__ import annotations

import math

import pytest
from attrs import evolve

from rmfs_commands.testing import small_instance, small_world
from rmfs_core.warehouse import BUSY, STORED, Warehouse, WarehouseView


def test_lines_of_two_orders_one_of_them_begun() -> None:
    """Orders are rows, oldest first; an assigned line has no items, and lists have open lines only."""
    world = small_world({"1": {"a": 2, "b": 1}, "2": {"a": 3}}, {"p": ["a", "b"]}, due_s={"2": 7.0})
    lines = WarehouseView(world).lines
    assert (lines.order_id.tolist(), lines.due_s.tolist(), lines.items.tolist()) == ([0, 1], [math.inf, 7.0], [3, 3])
    assert (lines.begin.tolist(), lines.order.tolist(), lines.sku.tolist()) == ([0, 2, 3], [0, 0, 1], [0, 1, 0])
    first = slice(lines.first[0], lines.first[0] + lines.number[0])
    assert (lines.listed_order[first].tolist(), lines.listed_items[first].tolist()) == ([0, 1], [2, 3])
    assert lines.begun.tolist() == []
    world.assign(world.orders[0], world.stations[0], [0])
    lines = WarehouseView(world).lines
    assert (lines.items.tolist(), lines.open_lines.tolist(), lines.quantity.tolist()) == ([1, 3], [1, 1], [0, 1, 3])
    assert (lines.begun.tolist(), lines.of_order(0), lines.number.tolist()) == ([0], [(1, 1)], [1, 1])
    with pytest.raises(ValueError, match="read-only"):
        lines.items[0] = 9


def test_orders_have_their_priority() -> None:
    """The second order is more urgent."""
    plain, instance = (
        small_world({"1": ["a"], "2": ["a"]}, {"p": ["a"]}),
        small_instance({"1": ["a"], "2": ["a"]}, {"p": ["a"]}),
    )
    orders = (instance.orders[0], evolve(instance.orders[1], priority=3))
    world = Warehouse(evolve(instance, orders=orders), plain.travel, plain.stations, plain.robots, plain.homes)
    for order in world.orders:
        world.order_arrives(order)
    assert WarehouseView(world).lines.priority.tolist() == [0, 3]


def test_stock_of_two_pods_one_of_them_bound() -> None:
    """Entries are sorted by pod and SKU, and told by SKU; a pod that is bound may not be sent."""
    world = small_world({"1": {"a": 2}}, {"p": {"a": 2, "b": 1}, "q": {"a": 4}})
    world.bind(world.pods[1], world.stations[0])
    world.assign(world.orders[0], world.stations[0], [0])
    stock = WarehouseView(world).stock
    assert (stock.pod.tolist(), stock.sku.tolist(), stock.items.tolist()) == ([0, 0, 1], [0, 1, 0], [2, 1, 2])
    assert (stock.of_pod.tolist(), stock.by_sku.tolist(), stock.of_sku.tolist()) == ([0, 2, 3], [0, 2, 1], [0, 2, 3])
    assert stock.at.tolist() == [STORED, BUSY]
    assert stock.location.tolist() == [pod.cell for pod in world.pods]
    with pytest.raises(ValueError, match="read-only"):
        stock.items[0] = 9
