"""Robots without a task: where they are sent to rest, and that they come to rest."""

from __future__ import annotations

from rmfs_commands.validation.case import Case, Handlers
from rmfs_commands.validation.state import State
from rmfs_core.events import PodMoveDecided, PodStored, RobotRested, RobotSent, VisitEnded


class RestCheck:
    """A robot without a task is sent to a cell of its own, and rests there, or elsewhere if a pod comes there."""

    def __init__(self, case: Case, state: State) -> None:
        self.case = case
        self.state = state
        self.since: dict[int, int] = {}  # robot -> when it was sent
        self.come: dict[int, int] = {}  # cell -> when a pod was stored there last
        self.coming: dict[int, int] = {}  # pod that is to be stored -> since when
        self.elsewhere: list[tuple[int, int, str]] = []  # robots that rest elsewhere: when, where they were sent, who
        self.handlers: Handlers = {
            RobotSent: self.sent,
            RobotRested: self.rested,
            VisitEnded: self.leaves,
            PodMoveDecided: self.leaves,
            PodStored: self.stored,
        }

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
        robot.sent, self.since[event.robot] = event.cell, event.tick

    def rested(self, event: RobotRested) -> None:
        """Check that the robot was sent, and stands where it may rest."""
        case, robot = self.case, self.state.robots[event.robot]
        rests = f"{case.robot(event.robot)} rests at {case.where(event.cell)}"
        if robot.sent is None:
            case.add("rested", event.tick, f"{rests}, but was not sent to rest")
        elif event.cell != robot.sent:
            came = self.come.get(robot.sent, -1) >= self.since[event.robot]
            if not came and all(pod.location != robot.sent for pod in self.state.pods):
                self.elsewhere.append((event.tick, robot.sent, f"{rests}, but was sent to {case.where(robot.sent)}"))
        if robot.cell != event.cell:
            case.add("rested", event.tick, f"{rests}, but stands at {case.where(robot.cell)}")
        if not case.is_rest(event.cell):
            case.add("no-rest", event.tick, f"{rests}, which is no storage location or charger")
        robot.sent = None

    def leaves(self, event: VisitEnded | PodMoveDecided) -> None:
        """Note that a pod gets a storage location."""
        if isinstance(event, PodMoveDecided) or event.next_station is None:
            self.coming[event.pod] = event.tick

    def stored(self, event: PodStored) -> None:
        """Note where a pod came, for which robots that were sent there make way."""
        self.come[event.cell] = event.tick
        self.elsewhere = [one for one in self.elsewhere if one[1] != event.cell]
        self.coming.pop(event.pod, None)

    def at_end(self) -> None:
        """Check that robots only rest elsewhere than they were sent if a pod comes there, or still may."""
        first = min(self.coming.values(), default=self.case.trace.tick + 1)
        for tick, _, said in self.elsewhere:
            if tick < first:
                self.case.add("rested", tick, said)
