"""Pods for orders that are chosen."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.helpers import ticks_to_station
from rmfs_rules.joint.choosing import Kept
from rmfs_rules.joint.covering import Chosen, Ints


def pods_for(world: Warehouse, chosen: Chosen, worth: Ints | None = None) -> list[tuple[int, int]]:
    """Return the pods that are sent."""
    return [*Kept().period(WarehouseView(world), None).pods_for(chosen, worth)]


def test_pods_that_later_ones_make_needless_stay() -> None:
    """p has most, four of six; then q and r have one of the two others each, and together all that p was sent for."""
    world = small_world({"1": ["a", "b", "c", "d", "e", "f"]}, {"p": "abcd", "q": "abe", "r": "cdf"})
    assert sorted(pods_for(world, [(0, 0)])) == [(1, 0), (2, 0)]


def test_a_pod_goes_to_two_stations_and_its_items_are_shared() -> None:
    """Of finite stock: p has three, two go to station 0, one to station 1, and q brings what is lacking there."""
    world = small_world({"1": {"a": 2}, "2": {"a": 2}}, {"p": {"a": 3}, "q": {"a": 1}}, capacities=[5, 5])
    assert sorted(pods_for(world, [(0, 0), (1, 1)])) == [(0, 0), (0, 1), (1, 1)]


def test_equal_pods() -> None:
    """The one that is bound for no station goes, then the one with most worth, then the nearest."""
    world = small_world({"1": ["a"]}, {str(i): ["a"] for i in range(9)}, capacities=[5, 5])
    view = WarehouseView(world)
    nearest = min(world.pods, key=lambda pod: (ticks_to_station(view, pod, world.stations[0]), pod.id)).id
    assert nearest != 4
    worth = (np.arange(9) == 4).astype(np.int64)
    assert pods_for(world, [(0, 0)]) == [(nearest, 0)]
    assert pods_for(world, [(0, 0)], worth) == [(4, 0)]
    world.bind(world.pods[4], world.stations[1])
    assert pods_for(world, [(0, 0)], worth) == [(nearest, 0)]


def test_what_stations_and_all_pods_have() -> None:
    """p is bound for station 0, q is sent to station 1; all pods together have what nothing was promised of."""
    world = small_world({"1": {"a": 1}}, {"p": {"a": 3}, "q": {"a": 2, "b": 5}}, capacities=[5, 5])
    world.bind(world.pods[0], world.stations[0])
    kept = Kept()
    assert kept.period(WarehouseView(world), None).pods.available([(1, 1)]).tolist() == [[3, 0], [2, 5], [5, 5]]
    world.assign(world.orders[0], world.stations[0], [0])
    assert kept.period(WarehouseView(world), None).pods.available(()).tolist() == [[2, 0], [0, 0], [4, 5]]
