"""POA rule first-come."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.first_come import FirstCome


def decide(world: Warehouse) -> list[tuple[str, int]]:
    """Return (order's name, station) of each assignment."""
    return [
        (world.orders[one.order].name, one.station)
        for one in FirstCome().assign_orders(WarehouseView(world), np.random.default_rng(0))
    ]


def test_orders_are_assigned_by_age_to_the_station_with_the_lowest_load() -> None:
    """Loads after each: 2/0, 2/1, 2/2, 3/2; what pods hold does not matter."""
    world = small_world({"1": ["a", "b"], "2": ["a"], "3": ["b"], "4": ["a"]}, {"p": ["a", "b"]}, capacities=[15, 15])
    world.bind(world.pods[0], world.stations[1])
    assert decide(world) == [("1", 0), ("2", 1), ("3", 1), ("4", 0)]


def test_the_next_oldest_that_fits_is_taken_when_the_oldest_does_not() -> None:
    """The oldest order has three items; only two places are free, at the busier station."""
    world = small_world({"0": ["a"], "1": ["a", "b", "c"], "2": ["a", "b"]}, {"p": ["a", "b", "c"]}, capacities=[1, 3])
    world.assign(world.orders[0], world.stations[1], [0])
    assert decide(world) == [("2", 1)]
