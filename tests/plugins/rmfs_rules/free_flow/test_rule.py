"""PP rule free-flow."""

from __future__ import annotations

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.free_flow import FreeFlow


def test_the_path_is_the_fastest_for_what_the_robot_carries() -> None:
    """Without a pod the robot takes the straight way under stored pods, with one it keeps to the aisles."""
    world = small_world({}, {"p": ["a"], "q": ["a"]})
    robot, view = world.robots[0], WarehouseView(world)
    goal = world.stations[0].cell
    empty = FreeFlow().plan_path(view, robot, goal)
    assert empty.legs == world.travel.fastest_path(robot.cell, robot.heading, goal, loaded=False)
    world.bind(world.pods[0], world.stations[0])
    world.take_task(robot, world.pods[0])
    world.move(robot, world.pods[0].location, robot.heading)
    world.lift(robot, world.pods[0])
    loaded = FreeFlow().plan_path(view, robot, goal)
    assert loaded.legs == world.travel.fastest_path(robot.cell, robot.heading, goal, loaded=True)
    assert loaded.legs[-1].to == goal
    assert loaded.legs != world.travel.fastest_path(robot.cell, robot.heading, goal, loaded=False)
