"""TA rule nearest-robot."""

from __future__ import annotations

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.nearest_robot import NearestRobot


def waiting_world(robots: int = 3) -> Warehouse:
    """Return a world in which pods 2, 0 and 1 wait in this order; the robot with the highest id is nearest to all."""
    world = small_world({}, {"p": ["a"], "q": ["a"], "r": ["a"]}, robots=robots)
    for pod in (2, 0, 1):
        world.bind(world.pods[pod], world.stations[0])
    return world


def decide(world: Warehouse) -> list[tuple[int, int]]:
    """Return (robot, pod) of each task."""
    return [(task.robot, task.pod) for task in NearestRobot().assign_tasks(WarehouseView(world))]


def test_the_pod_that_waits_longest_gets_the_nearest_robot() -> None:
    """Robots 0, 1, 2 are 13.6, 13.0 and 12.3 s from pod 0, and in the same order from the others."""
    assert decide(waiting_world()) == [(2, 2), (1, 0), (0, 1)]


def test_pods_wait_when_there_are_more_of_them() -> None:
    """Each robot gets one task."""
    assert decide(waiting_world(robots=1)) == [(0, 2)]


def test_busy_robots_get_nothing() -> None:
    """The nearest robot already fetches a pod."""
    world = waiting_world()
    world.take_task(world.robots[2], world.pods[2])
    assert decide(world) == [(1, 0), (0, 1)]


def test_ties_go_to_the_lowest_id() -> None:
    """Both robots stand in one cell."""
    world = waiting_world(robots=2)
    world.move(world.robots[1], world.robots[0].cell, world.robots[0].heading)
    assert decide(world) == [(0, 2), (1, 0)]
