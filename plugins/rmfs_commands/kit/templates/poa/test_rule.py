"""Tests of the rule."""

from rmfs import OrderAssignment
from rmfs.testing import check_rule, small_world
from rmfs.warehouse import WarehouseView

from the_rule import TheRule

ORDERS = {"large": ["a", "b", "c"], "small": ["a"]}
PODS = {"P": ["a", "b", "c"]}
LARGE, SMALL = 0, 1


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world."""
    print(check_rule(TheRule()))


def test_the_smallest_order_goes_to_the_station_with_the_most_room() -> None:
    """Capacity 2 at one station, 3 at the other: the small order takes one of the three, the large fits no more."""
    world = small_world(ORDERS, PODS, capacities=(2, 3))
    assert TheRule().assign_orders(WarehouseView(world)) == [OrderAssignment(SMALL, 1)]


def test_who_has_waited_too_long_goes_first() -> None:
    """A minute later the large order, which came first, has its turn."""
    world = small_world(ORDERS, PODS, capacities=(3,))
    world.advance(60_000)
    assert TheRule(patience_s=30).assign_orders(WarehouseView(world)) == [OrderAssignment(LARGE, 0)]
