"""Tests of the rule."""

from rmfs.testing import check_rule, small_world
from rmfs.warehouse import PackingTask, WarehouseView

from the_rule import TheRule


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world."""
    print(check_rule(TheRule()))


def test_patience_ends() -> None:
    """A long task has waited for 200 s, a short one for 100 s."""
    world = small_world({"1": {"a": 9}, "2": {"a": 1}}, {"P": ["a"]}, boxes=(1,))
    world.advance(200_000)
    long, short = world.orders
    tasks = [PackingTask("pack", long, 1, 9, 75.0, 0.0), PackingTask("pack", short, 2, 1, 35.0, 100.0)]
    view = WarehouseView(world)
    assert TheRule(patience_s=300).choose_packing_task(view, tasks) == 1
    assert TheRule(patience_s=200).choose_packing_task(view, tasks) == 0
