"""How much pods are wanted."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Order, Warehouse, WarehouseView
from rmfs_core.world import OrderData
from rmfs_rules.classes.worth import Ordered, Worth, rank_of

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
    assert Worth().speed(view).tolist() == [4, 1, 0]


def test_demand_is_what_is_wanted_and_free() -> None:
    """Two of four `a`, and one of nine `b`."""
    assert Worth().demand(WarehouseView(world())).tolist() == [2, 1, 0]


def test_both_are_shares_of_the_largest() -> None:
    """Speed 4/4, 1/4, 0; demand 2/2, 1/2, 0."""
    view = WarehouseView(world())
    assert Worth().combined(view, 1, 0).tolist() == [1, 0.25, 0]
    assert Worth().combined(view, 2, 1).tolist() == [3, 1, 0]


def test_nothing_was_ordered() -> None:
    """All pods are alike."""
    view = WarehouseView(small_world({}, PODS))
    assert Worth().combined(view, 1, 1).tolist() == [0, 0, 0]


def test_what_is_kept_is_what_is_read_anew() -> None:
    """While orders arrive and are assigned, and pods are bound and picked from."""
    made, kept = small_world(ORDERS, PODS), Worth()
    view, station, pod = WarehouseView(made), made.stations[0], made.pods[0]

    def compare() -> None:
        assert kept.speed(view).tolist() == Worth().speed(view).tolist()
        assert kept.demand(view).tolist() == Worth().demand(view).tolist()

    compare()
    made.assign(made.orders[2], station, [1])
    compare()
    made.place_at_station(made.robots[0], pod, station)
    compare()
    made.fulfil(station.open_requests[0], pod)
    compare()
    made.order_arrives(Order(9, OrderData("9", 0, ((0, 2), (1, 1))), lambda: 0))
    compare()


def test_ranks_are_counted_from_the_pod_that_is_wanted_most() -> None:
    """Of equal ones the lowest id goes first."""
    wanted = np.array([2, 5, 2, 0, 5])
    assert [rank_of(pod, wanted) for pod in range(5)] == [2, 0, 3, 4, 1]
