"""Tests of the rule."""

from rmfs.testing import check_rule, small_world
from rmfs.warehouse import WarehouseView

from the_rule import TheRule


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world."""
    print(check_rule(TheRule()))


def test_a_long_path_comes_in_pieces() -> None:
    """The first leg of a path to the station, or all of it."""
    warehouse = WarehouseView(small_world({}, {"P": ["a"]}))
    robot, goal = warehouse.robots[0], warehouse.stations[0].cell
    whole = TheRule(max_legs=100).plan_path(warehouse, robot, goal).legs
    assert whole[-1].to == goal
    assert len(whole) > 1
    assert TheRule(max_legs=1).plan_path(warehouse, robot, goal).legs == whole[:1]
