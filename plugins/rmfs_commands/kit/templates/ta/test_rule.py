"""Tests of the rule."""

from rmfs import TaskAssignment
from rmfs.testing import check_rule, small_layout, small_world
from rmfs.warehouse import WarehouseView

from the_rule import TheRule


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world."""
    print(check_rule(TheRule()))


def test_the_robot_under_a_pod_fetches_that_pod() -> None:
    """It has no way to go at all, whichever pod has waited longer."""
    locations = len(small_layout().storage_locations)
    world = small_world({}, {str(i): ["a"] for i in range(locations)}, robots=1)
    for pod in (world.pods[0], world.pods[-1]):
        world.bind(pod, world.stations[0])
    assert world.robots[0].cell == world.pods[-1].cell
    assert TheRule().assign_tasks(WarehouseView(world)) == [TaskAssignment(0, locations - 1)]


def test_robots_without_a_pod_stay_idle() -> None:
    """Two robots, one pod: one task."""
    world = small_world({}, {"P": ["a"]}, robots=2)
    world.bind(world.pods[0], world.stations[0])
    assert len(TheRule().assign_tasks(WarehouseView(world))) == 1
