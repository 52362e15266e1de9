"""Tests of the rule."""

from rmfs.testing import check_rule, small_world
from rmfs.warehouse import WarehouseView

from the_rule import TheRule


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world."""
    print(check_rule(TheRule()))


def test_the_next_order_goes_where_least_is_to_be_done() -> None:
    """Three items are bound for the first station; two orders of one item each are as much where orders count less."""
    world = small_world({"1": {"a": 3}, "2": {"a": 1}, "3": {"a": 1}, "4": {"a": 1}}, {"P": ["a"]}, boxes=(1, 1))
    view = WarehouseView(world)
    assert list(TheRule(order_items=0).assign_packing(view, world.orders)) == [0, 1, 1, 1]
    assert list(TheRule(order_items=9).assign_packing(view, world.orders)) == [0, 1, 1, 0]


def test_a_split_order_goes_where_a_box_is_free() -> None:
    """The only box of the first station is taken; the second has more to do, and a box."""
    world = small_world({"1": ["a", "b"], "2": {"a": 9}, "3": ["a", "b"]}, {"P": ["a", "b"]}, boxes=(1, 1))
    for order, at in zip(world.orders[:2], (0, 1), strict=True):
        world.assign(order, world.stations[0], [0])
        world.bind_packing(order, world.packing[at])
    world.assign(world.orders[2], world.stations[0], [0])
    assert list(TheRule().assign_packing(WarehouseView(world), world.orders[2:])) == [1]
