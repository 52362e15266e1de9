"""How much pods are wanted."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.classes.worth import combined, demand, movable, rank_of, speed

ORDERS = {"1": {"a": 3}, "2": {"b": 1, "a": 1}, "3": {"c": 2}}
PODS = {"p": {"a": 2, "c": 1}, "q": {"b": 9}, "r": {"z": 9}}


def world() -> Warehouse:
    """Return a world in which pod p is to serve order 3, as far as it can."""
    made = small_world(ORDERS, PODS)
    made.assign(made.orders[2], made.stations[0], [1])
    made.bind(made.pods[0], made.stations[0])
    return made


def test_speed_is_what_was_ordered_of_the_skus_that_are_free() -> None:
    """The only `c` on p is promised: four of `a` count."""
    view = WarehouseView(world())
    assert speed(view).tolist() == [4, 1, 0]


def test_demand_is_what_is_wanted_and_free() -> None:
    """Two of four `a`, and one of nine `b`."""
    assert demand(WarehouseView(world())).tolist() == [2, 1, 0]


def test_both_are_shares_of_the_largest() -> None:
    """Speed 4/4, 1/4, 0; demand 2/2, 1/2, 0."""
    view = WarehouseView(world())
    assert combined(view, 1, 0).tolist() == [1, 0.25, 0]
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


def test_ranks_are_counted_from_the_pod_that_is_wanted_most() -> None:
    """Of equal ones the lowest id goes first."""
    wanted = np.array([2, 5, 2, 0, 5])
    assert [rank_of(pod, wanted) for pod in range(5)] == [2, 0, 3, 4, 1]
