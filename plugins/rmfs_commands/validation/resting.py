"""Robots without a task: where they are sent to rest, and that they come to rest."""

from __future__ import annotations

from rmfs_commands.validation.case import Case, Handlers
from rmfs_commands.validation.state import State
from rmfs_core.events import RobotRested, RobotSent


class RestCheck:
    """A robot without a task is sent to a cell of its own, and rests in such a one."""

    def __init__(self, case: Case, state: State) -> None:
        self.case = case
        self.state = state
        self.handlers: Handlers = {RobotSent: self.sent, RobotRested: self.rested}

    def sent(self, event: RobotSent) -> None:
        """Check that the robot has nothing else to do, and that robots may rest where it is sent."""
        case, robot = self.case, self.state.robots[event.robot]
        sends = f"{case.robot(event.robot)} is sent to rest at {case.where(event.cell)}"
        if robot.task is not None:
            case.add("robot-busy", event.tick, f"{sends}, but is busy with {case.pod(robot.task)}")
        elif robot.sent is not None:
            case.add("robot-busy", event.tick, f"{sends}, but is on its way to {case.where(robot.sent)}")
        others = [other for other in self.state.robots if other is not robot]
        if not case.is_rest(event.cell):
            case.add("no-rest", event.tick, f"{sends}, which is no storage location or charger")
        elif any(event.cell in (other.cell, other.sent) for other in others):
            case.add("no-rest", event.tick, f"{sends}, where another robot is or goes")
        robot.sent = event.cell

    def rested(self, event: RobotRested) -> None:
        """Check that the robot was sent, and stands where it may rest."""
        case, robot = self.case, self.state.robots[event.robot]
        rests = f"{case.robot(event.robot)} rests at {case.where(event.cell)}"
        if robot.sent is None:
            case.add("rested", event.tick, f"{rests}, but was not sent to rest")
        if robot.cell != event.cell:
            case.add("rested", event.tick, f"{rests}, but stands at {case.where(robot.cell)}")
        if not case.is_rest(event.cell):
            case.add("no-rest", event.tick, f"{rests}, which is no storage location or charger")
        robot.sent = None
