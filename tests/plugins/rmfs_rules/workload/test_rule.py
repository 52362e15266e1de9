"""POA rule workload; test_oracles.py has it on random worlds."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.workload import Workload


def busy() -> Warehouse:
    """Return a world in which station 0 works on one order of three items, station 1 on two of one, of five each."""
    orders = {"x": {"a": 3}, "y": {"a": 1}, "z": {"a": 1}, "1": {"a": 2}, "2": {"a": 1}, "3": {"a": 1}}
    world = small_world(orders, {"p": ["a"]}, capacities=[5, 5])
    for order, station in ((0, 0), (1, 1), (2, 1)):
        world.assign(world.orders[order], world.stations[station], [0])
    return world


def decide(world: Warehouse, rule: Workload) -> list[tuple[str, int]]:
    """Return (order's name, station) of each assignment."""
    given = rule.assign_orders(WarehouseView(world), np.random.default_rng(0))
    return [(world.orders[one.order].name, one.station) for one in given]


def test_the_station_with_fewest_orders_is_filled_first() -> None:
    """Orders count, not items: 1/2, then 2/2, of which station 1 has the lower load; then nothing fits station 0."""
    assert decide(busy(), Workload()) == [("1", 0), ("2", 1), ("3", 1)]


def test_or_the_one_with_most() -> None:
    """Station 1 takes two orders; the third does not fit there any more."""
    assert decide(busy(), Workload(prefer="most")) == [("1", 1), ("2", 1), ("3", 0)]


def test_picked_orders_are_no_work() -> None:
    """Both orders of station 1 were picked."""
    world = busy()
    world.bind(world.pods[0], world.stations[1])
    for request in world.stations[1].open_requests:
        world.fulfil(request, world.pods[0])
    assert decide(world, Workload())[0] == ("1", 1)


def test_other_preferences_are_refused() -> None:
    """There are two."""
    with pytest.raises(ValueError, match="'prefer' must be in"):
        Workload(prefer="least")
