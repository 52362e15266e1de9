"""Tests of the rule."""

from rmfs.testing import check_rule, small_world
from rmfs.warehouse import WarehouseView

from the_rule import TheRule


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world."""
    print(check_rule(TheRule()))


def test_a_robot_beneath_a_pod_goes_to_an_empty_location() -> None:
    """The other one rests in such a location already, and stays."""
    world = small_world({}, {"1": ["a"]}, robots=2)
    world.move(world.robots[0], world.pods[0].cell, world.robots[0].heading)
    view = WarehouseView(world)
    (move,) = TheRule().idle_robots(view)
    assert move.robot == 0
    assert move.cell in view.free_storage_locations
