"""How much pods are wanted."""

from __future__ import annotations

from rmfs_classes.worth import Ordered, combined, demand, speed
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_testing import small_world

ORDERS = {"1": {"a": 3}, "2": {"b": 1, "a": 1}, "3": {"c": 2}}
PODS = {"p": {"a": 2, "c": 1}, "q": {"b": 9}, "r": {"z": 9}}


def world() -> Warehouse:
    """Return a world in which pod p is to serve order 3, as far as it can."""
    made = small_world(ORDERS, PODS)
    made.assign(made.orders[2], made.stations[0], [1])
    made.bind(made.pods[0], made.stations[0])
    return made


def test_items_are_counted_as_orders_arrive() -> None:
    """Assigned or not; each order once, and from the start again in another run."""
    ordered = Ordered()
    view = WarehouseView(world())
    for _ in range(3):
        assert ordered.items(view).tolist() == [4, 2, 1, 0]
    assert ordered.items(WarehouseView(small_world({"1": ["a"]}, PODS))).tolist() == [1, 0, 0, 0]


def test_speed_is_what_was_ordered_of_the_skus_that_are_free() -> None:
    """The only `c` on p is promised: four of `a` count."""
    view = WarehouseView(world())
    assert speed(view, Ordered().items(view)).tolist() == [4, 1, 0]


def test_demand_is_what_is_wanted_and_free() -> None:
    """Two of four `a`, and one of nine `b`."""
    assert demand(WarehouseView(world())).tolist() == [2, 1, 0]


def test_both_are_shares_of_the_largest() -> None:
    """Speed 4/4, 1/4, 0; demand 2/2, 1/2, 0."""
    view = WarehouseView(world())
    ordered = Ordered().items(view)
    assert combined(view, ordered, 1, 0).tolist() == [1, 0.25, 0]
    assert combined(view, ordered, 2, 1).tolist() == [3, 1, 0]


def test_nothing_was_ordered() -> None:
    """All pods are alike."""
    view = WarehouseView(small_world({}, PODS))
    assert combined(view, Ordered().items(view), 1, 1).tolist() == [0, 0, 0]
