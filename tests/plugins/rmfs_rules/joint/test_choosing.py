"""One decision: orders for stations, and what that costs."""

from __future__ import annotations

import pytest

from rmfs_commands.testing import small_world
from rmfs_core import OrderAssignment, PodTrip
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.joint.choosing import Kept, Period, with_a_place


def period(world: Warehouse, max_wait_s: float | None = None) -> Period:
    """Return a decision."""
    return Kept().period(WarehouseView(world), max_wait_s)


def test_orders_go_by_places() -> None:
    """One line missing for three items is better than one for two; where orders are counted, both take one place."""
    orders = {"1": {"b": 2}, "2": {"b": 3}, "3": {"a": 1}}
    for counts_orders, expected in ((False, [2, 1]), (True, [2, 0, 1])):
        world = small_world(orders, {"p": ["a"], "q": ["b"]}, capacities=[4], counts_orders=counts_orders)
        world.bind(world.pods[0], world.stations[0])
        assert period(world).filled(()) == [(place, 0) for place in expected]


def test_who_waits_too_long() -> None:
    """With a limit all who reach it; without, only orders larger than any station, after ten minutes."""
    world = small_world({"1": ["a"], "2": {"a": 4}}, {"p": ["a"]}, capacities=[3])
    world.now = 599_999
    assert [*period(world, 600).late()] == []
    assert [*period(world).late()] == []
    world.now = 600_000
    assert [*period(world, 600).late()] == [0, 1]
    assert [*period(world).late()] == [1]


def test_an_order_in_part() -> None:
    """What is left of it is in question; at a station that counts orders, where it has a place, it takes none."""
    world = small_world({"1": ["a", "b"], "2": ["a"]}, {"p": ["a", "b"]}, capacities=[1, 1], counts_orders=True)
    world.assign(world.orders[0], world.stations[0], [0])
    view = WarehouseView(world)
    now = period(world)
    assert with_a_place(view, now.orders).tolist() == [[0], [0]]
    assert now.filled([(0, 0)]) == [(0, 0), (1, 1)]


def test_few_orders() -> None:
    """Those that are chosen and those that lack least, with the places that they have among these."""
    orders = {"1": ["b"], "2": ["b", "c"], "3": ["a"], "4": ["c"], "5": ["a"]}
    world = small_world(orders, {"p": ["a"], "q": ["b", "c"]}, capacities=[2])
    world.bind(world.pods[0], world.stations[0])
    few, places = period(world).foremost(2, [(1, 0)], ())
    assert places == [1, 2, 4]
    assert [few.orders.id_of(place) for place in range(3)] == [world.orders[place].id for place in places]
    assert period(world).foremost(5, [(1, 0)], ())[1] == [0, 1, 2, 3, 4]


@pytest.mark.parametrize(("counts_orders", "expected"), [(False, 2 + 1.5 * 6), (True, 2 + 1.5 * 3 * 8)])
def test_the_cost(counts_orders: bool, expected: float) -> None:
    """One visit is under way, one is new; of 9 places the order takes three, or one where stations count orders.

    There a free place counts three times, for the order of three items.
    """
    world = small_world({"1": {"a": 2, "b": 1}}, {"p": ["a"], "q": ["b"]}, capacities=[9], counts_orders=counts_orders)
    world.bind(world.pods[0], world.stations[0])
    assert period(world).cost([(0, 0)], [(1, 0)], 1.5) == expected


def test_the_decision() -> None:
    """Ids, not places; nothing chosen is no decision."""
    world = small_world({"1": ["a"], "2": ["a"]}, {"p": ["a"]})
    world.assign(world.orders[0], world.stations[0], [0])
    now = Kept().period(WarehouseView(world).showing(world.orders[1:]), None)
    given = now.decision([(0, 0)], [(0, 0)], 2.0)
    assert given.assignments == (OrderAssignment(1, 0),)
    assert given.trips == (PodTrip(0, 0),)
    assert now.decision([], [], 2.0).report is None
