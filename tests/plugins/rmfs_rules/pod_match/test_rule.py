"""POA rule pod-match."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.pod_match import PodMatch


def decide(world: Warehouse, view: WarehouseView | None = None) -> list[tuple[str, int]]:
    """Return (order's name, station) of each assignment."""
    given = PodMatch().assign_orders(view or WarehouseView(world), np.random.default_rng(0))
    assert all(type(one.order) is int and type(one.station) is int and one.skus is None for one in given)
    return [(world.orders[one.order].name, one.station) for one in given]


def test_the_order_with_most_items_on_inbound_pods_is_assigned() -> None:
    """The newer order has two items on the pod at the station, the older one has one."""
    world = small_world({"old": ["a", "c"], "new": ["b", "c"]}, {"p": ["b", "c"], "q": ["a"]}, capacities=[2])
    world.bind(world.pods[0], world.stations[0])
    assert decide(world) == [("new", 0)]


def test_items_count_and_not_lines() -> None:
    """Three items of one SKU beat two SKUs."""
    world = small_world({"two": {"a": 1, "b": 1}, "three": {"a": 3}}, {"p": ["a", "b"]}, capacities=[3])
    world.bind(world.pods[0], world.stations[0])
    assert decide(world) == [("three", 0)]


def test_ties_go_to_the_oldest_order_then_to_the_lowest_load_then_to_the_lowest_id() -> None:
    """Without inbound pods all pairs score 0: order by order, each to the station with less to do."""
    world = small_world({"0": ["a", "b"], "1": ["a"], "2": ["a"], "3": ["a"]}, {"p": ["a", "b"]}, capacities=[15, 15])
    assert decide(world) == [("0", 0), ("1", 1), ("2", 1), ("3", 0)]


def test_load_from_earlier_decisions_counts() -> None:
    """Station 1 (id 0) already works on an order."""
    world = small_world({"0": ["a"], "1": ["a"]}, {"p": ["a"]}, capacities=[15, 15])
    world.assign(world.orders[0], world.stations[0], [0])
    assert decide(world) == [("1", 1)]


def test_an_order_that_does_not_fit_is_passed_over() -> None:
    """The best match has three items, but there is room for two."""
    orders = {"0": ["d", "e", "f"], "big": ["a", "b", "c"], "small": ["d"]}
    world = small_world(orders, {"p": ["a", "b", "c"], "q": ["d"]}, capacities=[2, 3])
    world.assign(world.orders[0], world.stations[1], [line.sku for line in world.orders[0].lines])
    world.bind(world.pods[0], world.stations[0])
    assert decide(world) == [("small", 0)]


def test_nothing_fits_or_nothing_is_there() -> None:
    """A full station gets nothing, and an empty backlog gives nothing."""
    world = small_world({"0": ["a", "b"], "big": ["a", "b"]}, {"p": ["a", "b"]}, capacities=[1, 2])
    world.assign(world.orders[0], world.stations[1], [line.sku for line in world.orders[0].lines])
    assert decide(world) == []
    assert decide(small_world({}, {"p": ["a"]})) == []


def test_order_capacity_takes_orders_of_any_size() -> None:
    """Each order takes one of two places."""
    world = small_world(
        {"1": ["a", "b", "c"], "2": ["a", "b"], "3": ["a"]}, {"p": ["a", "b", "c"]}, capacities=[2], counts_orders=True
    )
    assert decide(world) == [("1", 0), ("2", 0)]


def test_finite_stock_is_counted_once() -> None:
    """The only item of `a` goes to the first order, so the third has more on the pod than the second then."""
    orders = {"1": ["a"], "2": ["a"], "3": ["b"]}
    world = small_world(orders, {"p": {"a": 1, "b": 1}, "q": {"a": 5}}, capacities=[2])
    world.bind(world.pods[0], world.stations[0])
    assert decide(world) == [("1", 0), ("3", 0)]
    unlimited = small_world(orders, {"p": ["a", "b"]}, capacities=[2])
    unlimited.bind(unlimited.pods[0], unlimited.stations[0])
    assert decide(unlimited) == [("1", 0), ("2", 0)]


def test_an_item_on_a_pod_bound_for_two_stations_is_taken_at_both() -> None:
    """Station 2 loses the item that station 1 takes, so order 3 matches better there."""
    world = small_world(
        {"1": ["a"], "2": ["a"], "3": ["b"]}, {"p": {"a": 1}, "q": {"b": 1}, "r": {"a": 9}}, capacities=[1, 1]
    )
    for pod, station in ((0, 0), (0, 1), (1, 1)):
        world.bind(world.pods[pod], world.stations[station])
    assert decide(world) == [("1", 0), ("3", 1)]


def test_only_open_lines_count() -> None:
    """What an earlier period assigned of an order is neither wanted nor takes up room again."""
    world = small_world({"1": ["a", "b"], "2": ["c"]}, {"p": ["a"], "q": ["c", "b"]}, capacities=[2, 1])
    world.assign(world.orders[0], world.stations[0], [0])
    world.bind(world.pods[0], world.stations[1])
    assert decide(world) == [("1", 1), ("2", 0)]


def test_only_the_filtered_backlog_is_assigned() -> None:
    """Positions in the arrays are those of the filtered backlog."""
    world = small_world({"1": ["a"], "2": ["b"], "3": ["a", "b"]}, {"p": ["a", "b"]}, capacities=[3])
    world.bind(world.pods[0], world.stations[0])
    assert decide(world, WarehouseView(world, world.orders[1:])) == [("3", 0), ("2", 0)]
