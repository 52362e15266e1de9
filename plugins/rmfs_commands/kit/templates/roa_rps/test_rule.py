"""Tests of the rule."""

from rmfs import BundleAssignment, BundleDecision, StoreBundle
from rmfs.testing import check_rule, small_world
from rmfs.warehouse import WarehouseView

from the_rule import TheRule


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world."""
    print(check_rule(TheRule()))


def test_a_bundle_without_a_pod_waits_outside() -> None:
    """The first bundle is too large for what is free on the pods; the second goes to the emptier one."""
    world = small_world({}, {"P": {"a": 8}, "Q": {"a": 6}}, bundle_capacity=2, pod_capacity=10)
    for items in (5, 2):
        world.bundle_arrives(0, items)
    decided = TheRule().assign_bundles_and_pods(WarehouseView(world), max_fetches=1)
    assert decided == BundleDecision([BundleAssignment(1, 0)], [StoreBundle(1, 1)])
