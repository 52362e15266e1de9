"""Tests of the rule."""

from rmfs.testing import check_rule, small_world
from rmfs.warehouse import WarehouseView

from the_rule import TheRule


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world."""
    print(check_rule(TheRule()))


def test_a_longer_backlog_activates_more_stations() -> None:
    """Three orders and two a station: two stations, the larger ones."""
    world = small_world({"1": ["a"], "2": ["a"], "3": ["a"]}, {"P": ["a"]}, capacities=[5, 9, 7])
    assert list(TheRule(orders=2).activate_stations(WarehouseView(world))) == [1, 2]
    assert list(TheRule(orders=3).activate_stations(WarehouseView(world))) == [1]


def test_a_station_with_something_to_do_stays_active() -> None:
    """The first one has an order; the backlog is worth one station, the second."""
    world = small_world({"1": ["a"], "2": ["a"]}, {"P": ["a"]}, capacities=[5, 9])
    world.assign(world.orders[0], world.stations[0], [0])
    assert sorted(TheRule().activate_stations(WarehouseView(world))) == [0, 1]
