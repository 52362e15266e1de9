"""Tests of the rule."""

from rmfs import BundleAssignment
from rmfs.testing import check_rule, small_world
from rmfs.warehouse import WarehouseView

from the_rule import TheRule


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world."""
    print(check_rule(TheRule()))


def test_what_is_wanted_goes_first_unless_another_waited_too_long() -> None:
    """One unit is free. SKU b is wanted, a is not."""
    world = small_world({"O": ["b"]}, {"P": {"a": 1, "b": 1}}, bundle_capacity=1)
    for sku in (0, 1):
        world.bundle_arrives(sku, 5)
    view = WarehouseView(world)
    assert TheRule().assign_bundles(view) == [BundleAssignment(1, 0)]
    world.advance(1000)
    assert TheRule(patience_s=0.5).assign_bundles(view) == [BundleAssignment(0, 0)]
