"""Tests of the rule."""

from rmfs import StoreBundle
from rmfs.testing import check_rule, small_world
from rmfs.warehouse import WarehouseView

from the_rule import TheRule


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world."""
    print(check_rule(TheRule()))


def test_a_pod_that_comes_anyway_is_worth_some_items() -> None:
    """Pod P, with five items of SKU a, is bound for the station; Q, with none, would have to be fetched."""
    world = small_world({}, {"P": {"a": 5}, "Q": {"b": 1}}, bundle_capacity=1, pod_capacity=10)
    world.bind(world.pods[0], world.stations[0])
    world.assign_bundle(world.bundle_arrives(0, 2), world.stations[0])
    view = WarehouseView(world)
    assert TheRule(fetching=10).select_replenishment_pods(view, max_fetches=1) == [StoreBundle(0, 0)]
    assert TheRule(fetching=1).select_replenishment_pods(view, max_fetches=1) == [StoreBundle(0, 1)]
