"""Pods: who fetches them, where they are lifted and set down, and how long that takes."""

from __future__ import annotations

from collections.abc import Mapping

from rmfs_commands.validation.case import Case, Handlers, seconds
from rmfs_commands.validation.state import PodState, RobotState, State
from rmfs_core.events import PodLifted, PodMoveDecided, PodStored, TaskAssigned


class PodCheck:
    """Each pod stands alone in a storage location or is carried by the one robot that lifted it."""

    def __init__(self, case: Case, state: State) -> None:
        self.case = case
        self.state = state
        self._going: dict[int, int] = {}
        self.handlers: Handlers = {
            TaskAssigned: self.task,
            PodMoveDecided: self.moved,
            PodLifted: self.lifted,
            PodStored: self.stored,
        }

    def bring(self, going: Mapping[int, int]) -> None:
        """Note pods that are carried elsewhere without a visit, and where to."""
        self._going.update(going)

    def task(self, event: TaskAssigned) -> None:
        """Check that a robot has no other task, and that the pod stands and waits for it."""
        robot, pod = self.state.robots[event.robot], self.state.pods[event.pod]
        fetches = f"{self.case.robot(event.robot)} shall fetch {self.case.pod(event.pod)}"
        if not pod.bound:
            self.case.add("no-trip", event.tick, f"{fetches}, which is bound for no station")
        self._take(event, robot, pod, fetches)

    def moved(self, event: PodMoveDecided) -> None:
        """Check that a pod which is carried elsewhere is bound for no station, and finds a free location there."""
        case, robot, pod = self.case, self.state.robots[event.robot], self.state.pods[event.pod]
        moves = f"{case.robot(event.robot)} shall carry {case.pod(event.pod)} to {case.where(event.cell)}"
        if pod.bound:
            case.add("moved-bound", event.tick, f"{moves}, but the pod is bound for {case.station(pod.bound[0][0])}")
        if not case.is_storage(event.cell):
            case.add("no-storage-location", event.tick, f"{moves}, which is no storage location")
        elif event.cell in self.state.stored or event.cell in self._going.values():
            case.add("location-taken", event.tick, f"{moves}, where a pod stands or comes to")
        self._take(event, robot, pod, moves)
        self._going[event.pod] = event.cell

    def _take(self, event: TaskAssigned | PodMoveDecided, robot: RobotState, pod: PodState, fetches: str) -> None:
        other = pod.fetched_by if pod.robot is None else pod.robot
        if other is not None and other != event.robot:
            self.case.add("fetched-twice", event.tick, f"{fetches}, which {self.case.robot(other)} fetches or carries")
        pod.fetched_by = event.robot
        if robot.task is not None:
            busy = f"is still busy with {self.case.pod(robot.task)}"
            self.case.add("robot-busy", event.tick, f"{fetches}, but {busy}")
        elif robot.sent is not None:
            where = self.case.where(robot.sent)
            self.case.add("robot-busy", event.tick, f"{fetches}, but is on its way to rest at {where}")
        robot.task = event.pod

    def lifted(self, event: PodLifted) -> None:
        """Check that robot and pod are where the pod is lifted."""
        case, robot, pod = self.case, self.state.robots[event.robot], self.state.pods[event.pod]
        lifts = f"{case.robot(event.robot)} lifts {case.pod(event.pod)} at {case.where(event.cell)}"
        self._work(event, lifts)
        if robot.task != event.pod:
            case.add("no-task", event.tick, f"{lifts}, but was not told to fetch it")
        if robot.pod is not None:
            case.add("robot-loaded", event.tick, f"{lifts}, but carries {case.pod(robot.pod)}")
        if pod.robot is not None:
            case.add("pod-in-use", event.tick, f"{lifts}, but {case.robot(pod.robot)} carries it")
        elif pod.location != event.cell:
            stands = "nowhere" if pod.location is None else f"at {case.where(pod.location)}"
            case.add("pod-not-there", event.tick, f"{lifts}, but the pod stands {stands}")
        self.state.take(event.robot, event.pod)
        robot.lifted_at = event.cell

    def stored(self, event: PodStored) -> None:
        """Check that a robot sets down its pod in a free storage location."""
        case, robot, pod = self.case, self.state.robots[event.robot], self.state.pods[event.pod]
        stores = f"{case.robot(event.robot)} sets down {case.pod(event.pod)} at {case.where(event.cell)}"
        self._work(event, stores)
        if robot.pod != event.pod:
            case.add("pod-in-use", event.tick, f"{stores}, but carries {case.load(robot.pod)}")
        if not case.is_storage(event.cell):
            case.add("no-storage-location", event.tick, f"{stores}, which is no storage location")
        if event.cell in self.state.stored and self.state.stored[event.cell] != event.pod:
            standing = case.pod(self.state.stored[event.cell])
            case.add("location-taken", event.tick, f"{stores}, where {standing} stands")
        if pod.next_station is not None:
            bound = case.station(pod.next_station)
            case.add("next-station", event.tick, f"{stores}, but was to carry it on to {bound}")
        going = self._going.pop(event.pod, event.cell)
        if going != event.cell:
            case.add("moved-elsewhere", event.tick, f"{stores}, but was to carry it to {case.where(going)}")
        pod.next_station, pod.to_storage, pod.fetched_by = None, False, None
        self.state.put(event.pod, event.cell)
        robot.task = None

    def at_end(self) -> None:
        """Check that no robot stands with its pod where that is to be stored, and does nothing."""
        case, end = self.case, self.case.trace.tick
        for i, robot in enumerate(self.state.robots):
            pod = None if robot.pod is None else self.state.pods[robot.pod]
            if robot.pod is None or pod is None:
                continue
            if pod.to_storage and case.is_storage(robot.cell):
                since = robot.free_tick + case.services.lift(robot.pod)
                if since < end:
                    stands = f"{case.robot(i)} with {case.pod(robot.pod)} stands at {case.where(robot.cell)}"
                    case.add("not-stored", end, f"{stands} since {seconds(robot.free_tick)} and does not set it down")

    def _work(self, event: PodLifted | PodStored, doing: str) -> None:
        """Check cell and time of what a robot does at rest, and note how long it is busy."""
        robot = self.state.robots[event.robot]
        if robot.cell != event.cell:
            self.case.add("robot-elsewhere", event.tick, f"{doing}, but stands at {self.case.where(robot.cell)}")
        if event.start_tick < robot.free_tick:
            self.case.add(
                "time-overlap",
                event.tick,
                f"{doing} from {seconds(event.start_tick)} on, "
                f"but what it did before lasted until {seconds(robot.free_tick)}",
            )
        taken, needed = event.tick - event.start_tick, self.case.services.lift(event.pod)
        if taken != needed:
            self.case.add("lift-time", event.tick, f"{doing} in {seconds(taken)}; that takes {seconds(needed)}")
        robot.free_tick = event.tick
