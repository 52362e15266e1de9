"""What orders lack at a station."""

from __future__ import annotations

from rmfs_core.warehouse import WarehouseView
from rmfs_joint.choosing import NOT_NOW, Left, waiting_too_long
from rmfs_testing import small_world


def test_lines_are_missing_until_an_order_has_them_brought() -> None:
    """p is bound for station 0 and has a; b is missing everywhere, until order 2, chosen for station 0, wants it."""
    world = small_world({"1": ["a", "b"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[5, 5])
    world.bind(world.pods[0], world.stations[0])
    left = Left(WarehouseView(world))
    assert [left.missing(station).tolist() for station in world.stations] == [[1, 1], [2, 1]]
    assert list(left.take(world.stations[0], 1)) == [0]
    assert [left.missing(station).tolist() for station in world.stations] == [[0, 0], [2, 1]]


def test_pods_that_are_sent_count() -> None:
    """q to station 1."""
    world = small_world({"1": ["a", "b"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[5, 5])
    left = Left(WarehouseView(world), [(1, 1)])
    assert [left.missing(station).tolist() for station in world.stations] == [[2, 1], [1, 0]]


def test_finite_stock_runs_out() -> None:
    """p has two items at the station: enough for 1 or for 2, and once one of them is chosen no pod has any for 3."""
    orders = {"1": {"a": 2}, "2": {"a": 1}, "3": {"a": 1, "b": 1}}
    world = small_world(orders, {"p": {"a": 2}, "q": {"b": 1}})
    world.bind(world.pods[0], world.stations[0])
    left = Left(WarehouseView(world))
    assert left.missing(world.stations[0]).tolist() == [0, 0, 1]
    left.take(world.stations[0], 0)
    assert left.in_stock().tolist() == [False, False, False]
    assert left.score(world.stations[0]).tolist() == [NOT_NOW] * 3


def test_the_score_goes_by_places() -> None:
    """One line missing for three items is better than one for two; where orders are counted, both take one place."""
    orders = {"1": {"b": 2}, "2": {"b": 3}, "3": {"a": 1}}
    for counts_orders in (False, True):
        world = small_world(orders, {"p": ["a"], "q": ["b"]}, counts_orders=counts_orders)
        world.bind(world.pods[0], world.stations[0])
        two, three, none = Left(WarehouseView(world)).score(world.stations[0]).tolist()
        assert (two == three) if counts_orders else (two < three)
        assert three < none


def test_who_waits_too_long() -> None:
    """With a limit all who reach it; without, only orders larger than any station, after ten minutes."""
    world = small_world({"1": ["a"], "2": {"a": 4}}, {"p": ["a"]}, capacities=[3])
    world.now = 599_999
    assert waiting_too_long(WarehouseView(world), 600) == set()
    assert waiting_too_long(WarehouseView(world), None) == set()
    world.now = 600_000
    assert waiting_too_long(WarehouseView(world), 600) == {0, 1}
    assert waiting_too_long(WarehouseView(world), None) == {1}
