"""The backlog, and copies of its lines and of free items as arrays."""

from __future__ import annotations

import pytest

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView, columns_of
from rmfs_core.warehouse.backlog import Backlog, lines_in
from rmfs_core.warehouse.parts import UNLIMITED
from standing import put_at_station


def test_the_backlog_as_arrays_follows_what_joins_and_leaves() -> None:
    """Lines as the orders have them, oldest first; sizes follow, and an order leaves with its last line."""
    world = small_world({"1": {"a": 2, "b": 1}, "2": {"b": 3}}, {"p": ["a", "b"]}, capacities=[9])
    backlog, station = world.backlog, world.stations[0]
    assert (len(backlog), dict(backlog.sizes), dict(backlog.line_sizes)) == (2, {3: 2}, {2: 1, 1: 1, 3: 1})
    world.assign(world.orders[0], station, [0])
    assert (backlog.lines.order_id.tolist(), backlog.lines.sku.tolist()) == ([0, 1], [1, 1])
    assert backlog.lines is backlog.lines
    world.assign(world.orders[0], station, [1])
    assert [order.id for order in backlog.orders] == [1]
    assert world.orders[0] not in backlog
    assert (dict(backlog.sizes), dict(backlog.line_sizes)) == ({3: 1}, {3: 1})


def test_an_order_that_joins_late_takes_its_place_by_age() -> None:
    """Whether others there are younger or older; lines that were assigned stay so."""
    world = small_world({"1": ["a"], "2": {"a": 1, "b": 2}, "3": ["b"], "4": ["a"]}, {"p": ["a", "b"]}, capacities=[9])
    first, second, third, fourth = world.orders
    backlog = Backlog(world.n_skus)
    backlog.add(second, third)
    backlog.close(second, [0])
    backlog.add(fourth)
    backlog.add(first)
    assert backlog.orders == (first, second, third, fourth)
    assert backlog.lines.order_id.tolist() == [0, 1, 2, 3]
    assert backlog.lines.sku.tolist() == [0, 1, 1, 0]
    assert (dict(backlog.sizes), dict(backlog.line_sizes)) == ({2: 1, 1: 3}, {2: 1, 1: 3})
    backlog.close(second, [1])
    assert backlog.orders == (first, third, fourth)


def test_open_lines_of_any_orders_as_arrays() -> None:
    """The position is that in the sequence, not the order's id; closed lines are left out, and nobody changes them."""
    world = small_world({"1": {"a": 2, "b": 1}, "2": {"b": 2}}, {"p": ["a", "b"]})
    first, second = world.orders
    world.assign(first, world.stations[0], [1])
    lines = lines_in(columns_of((second, first), world.n_skus))
    assert [lines.order.tolist(), lines.sku.tolist(), lines.quantity.tolist()] == [[0, 1], [1, 0], [2, 2]]
    assert len(lines_in(columns_of((), 2)).order) == 0
    with pytest.raises(ValueError, match="read-only"):
        lines.quantity[0] = 1


def test_free_items_are_told_as_arrays() -> None:
    """Every SKU of every pod, by pod and SKU, as they are when they are asked for."""
    world = small_world({"1": ["a", "b"], "2": ["a"]}, {"p": {"a": 2, "b": 1}, "q": ["a"]}, capacities=[5])
    view, station = WarehouseView(world), world.stations[0]
    before = view.free_items
    assert (before.pod.tolist(), before.sku.tolist()) == ([0, 0, 1], [0, 1, 0])
    assert before.number.tolist() == [2, 1, UNLIMITED]
    put_at_station(world, 0)
    world.assign(world.orders[0], station, [0, 1])
    assert view.free_items.number.tolist() == [1, 0, UNLIMITED]
    assert before.number.tolist() == [2, 1, UNLIMITED]
    world.fulfil(station.open_requests[0], world.pods[0])
    assert view.free_items.number.tolist() == [1, 0, UNLIMITED]
    with pytest.raises(ValueError, match="read-only"):
        view.free_items.number[0] = 9
