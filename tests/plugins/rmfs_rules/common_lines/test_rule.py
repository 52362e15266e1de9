"""POA rule common-lines."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.common_lines import CommonLines


def decide(world: Warehouse) -> list[tuple[str, int]]:
    """Return (order's name, station) of each assignment."""
    return [
        (world.orders[one.order].name, one.station)
        for one in CommonLines().assign_orders(WarehouseView(world), np.random.default_rng(0))
    ]


def test_the_order_with_most_skus_in_common_goes_to_the_station() -> None:
    """Station 2 wants `a` and `b`: the newest order shares both with it, the others at most one."""
    world = small_world(
        {"first": ["a", "b"], "1": ["c"], "2": ["a"], "3": ["b", "a", "d"]},
        {"p": ["a", "b", "c", "d"]},
        capacities=[1, 5],
    )
    world.assign(world.orders[0], world.stations[1], [0, 1])
    assert decide(world) == [("3", 1), ("1", 0)]


def test_lines_count_and_not_items() -> None:
    """Five items of one SKU are one line in common."""
    world = small_world({"first": ["a", "b"], "1": {"a": 5}, "2": ["a", "b"]}, {"p": ["a", "b"]}, capacities=[7])
    world.assign(world.orders[0], world.stations[0], [0, 1])
    assert decide(world) == [("2", 0)]


def test_requests_of_the_same_decision_count() -> None:
    """Nothing is at the station yet: the oldest order comes first and draws the order with the same SKU after it."""
    world = small_world({"1": ["a"], "2": ["b"], "3": ["a"]}, {"p": ["a", "b"]}, capacities=[2])
    assert decide(world) == [("1", 0), ("3", 0)]


def test_what_was_picked_is_in_common_no_more() -> None:
    """The request for `a` was fulfilled, `b` is still wanted."""
    world = small_world({"first": ["a", "b"], "1": ["a"], "2": ["b"]}, {"p": ["a", "b"]}, capacities=[3])
    station = world.stations[0]
    world.bind(world.pods[0], station)
    world.assign(world.orders[0], station, [0, 1])
    world.fulfil(station.open_requests[0], world.pods[0])
    assert decide(world) == [("2", 0)]
