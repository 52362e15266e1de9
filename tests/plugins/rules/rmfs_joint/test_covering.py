"""Pods for orders that are chosen, and the cost of both."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_core import OrderAssignment, PodTrip
from rmfs_core.warehouse import WarehouseView
from rmfs_joint.covering import cost, decision, pods_for
from rmfs_rule_helpers import ticks_to_station
from rmfs_testing import small_world


def test_pods_that_later_ones_make_needless_stay() -> None:
    """p has most, four of six; then q and r have one of the two others each, and together all that p was sent for."""
    world = small_world({"1": ["a", "b", "c", "d", "e", "f"]}, {"p": "abcd", "q": "abe", "r": "cdf"})
    assert sorted(pods_for(WarehouseView(world), [(0, 0)])) == [(1, 0), (2, 0)]


def test_a_pod_goes_to_two_stations_and_its_items_are_shared() -> None:
    """Of finite stock: p has three, two go to station 0, one to station 1, and q brings what is lacking there."""
    world = small_world({"1": {"a": 2}, "2": {"a": 2}}, {"p": {"a": 3}, "q": {"a": 1}}, capacities=[5, 5])
    assert sorted(pods_for(WarehouseView(world), [(0, 0), (1, 1)])) == [(0, 0), (0, 1), (1, 1)]


def test_equal_pods() -> None:
    """The one that is bound for no station goes, then the one with most worth, then the nearest."""
    world = small_world({"1": ["a"]}, {str(i): ["a"] for i in range(9)}, capacities=[5, 5])
    view = WarehouseView(world)
    nearest = min(world.pods, key=lambda pod: (ticks_to_station(view, pod, world.stations[0]), pod.id)).id
    assert nearest != 4
    assert pods_for(view, [(0, 0)]) == [(nearest, 0)]
    assert pods_for(view, [(0, 0)], np.arange(9) == 4) == [(4, 0)]
    world.bind(world.pods[4], world.stations[1])
    assert pods_for(view, [(0, 0)], np.arange(9) == 4) == [(nearest, 0)]


@pytest.mark.parametrize(("counts_orders", "expected"), [(False, 2 + 1.5 * 6), (True, 2 + 1.5 * 3 * 8)])
def test_the_cost(counts_orders: bool, expected: float) -> None:
    """One visit is under way, one is new; of 9 places the order takes three, or one where stations count orders.

    There a free place counts three times, for the order of three items.
    """
    world = small_world({"1": {"a": 2, "b": 1}}, {"p": ["a"], "q": ["b"]}, capacities=[9], counts_orders=counts_orders)
    world.bind(world.pods[0], world.stations[0])
    assert cost(WarehouseView(world), [(0, 0)], [(1, 0)], 1.5) == expected


def test_the_decision() -> None:
    """Ids, not positions; nothing chosen is no decision."""
    world = small_world({"1": ["a"], "2": ["a"]}, {"p": ["a"]})
    world.assign(world.orders[0], world.stations[0], [0])
    given = decision(WarehouseView(world), [(0, 0)], [(0, 0)], 2.0)
    assert given.assignments == (OrderAssignment(1, 0),)
    assert given.trips == (PodTrip(0, 0),)
    assert decision(WarehouseView(world), [], [], 2.0).report is None
