"""A path that a PP rule is asked for in a state: the other robots stand where they are."""

from __future__ import annotations

from typing import Any

from rmfs_commands.cli.single_rule import reserving_way
from rmfs_commands.states.rebuilding import OpenState
from rmfs_core.decisions import Path
from rmfs_core.errors import InputError
from rmfs_core.rules import BoundRule
from rmfs_core.simulation import checks
from rmfs_core.simulation.asking import instance_of
from rmfs_core.warehouse import Robot, Warehouse
from rmfs_traffic import Query, Reservations, ReservedError, Traffic, roads_on
from rmfs_traffic.paths import Stop


def path_wanted(opened: OpenState, rule: BoundRule) -> dict[str, Any]:
    """Return the arguments of the hook: the robot, its goal, and for a rule that reserves the cells of the others.

    Raises
    ------
    InputError
        When the state names no robot and goal, or the robot cannot be there, or the rule plans for all robots at once.
    """
    asked, names, travel = opened.state.ask, opened.names, opened.warehouse.travel
    way = reserving_way(rule, names.source, "which asks for paths in a run only")
    if way is not None and way.hook == "plan_paths":
        found = f"{rule.describe()} plans the paths of all robots at once"
        raise InputError(names.source, f"{found}; expected a PP rule that plans for one robot")
    robots = {robot.name: robot for robot in opened.warehouse.robots}
    if asked.robot not in robots:
        found = "is missing" if asked.robot is None else f'names robot "{asked.robot}", which the state does not list'
        names.wrong(("ask", "robot"), f"{found}; expected the robot that needs a path")
    robot, cells = robots[asked.robot], travel.layout.width * travel.layout.height
    if asked.goal is None or asked.goal >= cells or not travel.passable(asked.goal, robot.pod is not None)[asked.goal]:
        found = "is missing" if asked.goal is None else f"found {asked.goal}"
        names.wrong(("ask", "goal"), f"{found}; expected a cell of the layout where the robot can go")
    if way is None:
        return {"robot": robot, "goal": asked.goal, "traffic": None}
    table, now = Reservations(cells), opened.warehouse.now
    for other in robots.values():
        if (blocker := table.blocker(other.cell, now)) is not None:
            problem = f"found cell {other.cell}, where robot {opened.warehouse.robots[blocker].name} stands"
            names.wrong(("robots", other.name, "cell"), f"{problem}; expected one robot in a cell")
        table.hold(other.id, other.cell, now)
    query = Query(robot.id, robot.cell, robot.heading, now, asked.goal, robot.pod is not None)
    return {"robot": robot, "goal": asked.goal, "traffic": Traffic(roads_on(travel), table, query)}


def check_path(warehouse: Warehouse, answer: object, robot: Robot, goal: int, traffic: Traffic | None) -> None:
    """Check a path as in a run.

    Raises
    ------
    ImpossibleError
        When the robot cannot drive it, or another stands in its way.
    """
    if answer is None and traffic is not None:
        return
    ends = checks.path(warehouse, robot, robot.cell, goal, instance_of(answer, Path))
    if traffic is not None:
        try:
            traffic.table.settle(robot.id, traffic.roads, Stop(robot.cell, robot.heading, warehouse.now), ends)
        except ReservedError as error:
            raise checks.hit(traffic.roads.layout, robot.id, error) from None
