"""Tests of the rule."""

from rmfs import JointDecision, OrderAssignment, PodTrip
from rmfs.testing import check_rule, small_world
from rmfs.warehouse import WarehouseView

from the_rule import TheRule


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world with endless pods."""
    print(check_rule(TheRule()))


def test_an_order_goes_where_its_pods_are() -> None:
    """The pod at the second station holds both SKUs: nothing has to be sent there."""
    world = small_world({"O": ["a", "b"]}, {"P": ["a"], "Q": ["a", "b"]}, capacities=(5, 5))
    world.bind(world.pods[1], world.stations[1])
    assert TheRule().assign_orders_and_pods(WarehouseView(world)) == JointDecision([OrderAssignment(0, 1)])


def test_a_pod_for_two_skus_is_sent_once() -> None:
    """One trip serves the whole order."""
    world = small_world({"O": ["a", "b"]}, {"P": ["a", "b"]})
    expected = JointDecision([OrderAssignment(0, 0)], [PodTrip(0, 0)])
    assert TheRule().assign_orders_and_pods(WarehouseView(world)) == expected
