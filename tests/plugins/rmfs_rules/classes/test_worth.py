"""How much pods are wanted."""

from __future__ import annotations

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.classes.worth import combined, movable

ORDERS = {"1": {"a": 3}, "2": {"b": 1, "a": 1}, "3": {"c": 2}}
PODS = {"p": {"a": 2, "c": 1}, "q": {"b": 9}, "r": {"z": 9}}


def world() -> Warehouse:
    """Return a world in which pod p is to serve order 3, as far as it can."""
    made = small_world(ORDERS, PODS)
    made.assign(made.orders[2], made.stations[0], [1])
    made.bind(made.pods[0], made.stations[0])
    return made


def test_both_are_shares_of_the_largest() -> None:
    """Four of `a`, and one of `b` were ordered; two of four `a`, and one of nine `b` are wanted; `c` is promised."""
    view = WarehouseView(world())
    assert combined(view, 1, 0).tolist() == [1, 0.25, 0]
    assert combined(view, 0, 1).tolist() == [1, 0.5, 0]
    assert combined(view, 2, 1).tolist() == [3, 1, 0]


def test_nothing_was_ordered() -> None:
    """All pods are alike."""
    view = WarehouseView(small_world({}, PODS))
    assert combined(view, 1, 1).tolist() == [0, 0, 0]


def test_a_pod_that_a_robot_fetches_may_not_be_moved() -> None:
    """Nor one that is bound for a station."""
    made = world()
    made.waiting[made.pods[1].id] = made.pods[1]
    made.take_task(made.robots[0], made.pods[1])  # to be carried elsewhere, without a visit
    assert movable(WarehouseView(made)).tolist() == [False, False, True]
