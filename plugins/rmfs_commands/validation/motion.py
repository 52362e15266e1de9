"""Runs of robots: where and when they start and end, how long they take, and which cells they cross."""

from __future__ import annotations

from rmfs_commands.validation.case import NOBODY_WAITS, Case, Handlers, nobody_waits, seconds
from rmfs_commands.validation.collisions import LONGEST_M, reached_s
from rmfs_commands.validation.state import RobotState, State
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.events import RobotMoved
from rmfs_core.world import CellKind


class MotionCheck:
    """Each run starts where and when the last one ended, is straight, and takes the time of the formulas."""

    def __init__(self, case: Case, state: State) -> None:
        self.case = case
        self.state = state
        self.traffic = not nobody_waits(case.trace)
        self.handlers: Handlers = {RobotMoved: self.moved}

    def moved(self, event: RobotMoved) -> None:
        """Check a leg, and note where the robot is now."""
        robot = self.state.robots[event.robot]
        name = self.case.robot(event.robot)
        if event.origin != robot.cell:
            self.case.add(
                "teleport",
                event.tick,
                f"{name} starts a run at {self.case.where(event.origin)}, "
                f"but it stood at {self.case.where(robot.cell)}",
            )
        if event.start_tick < robot.free_tick:
            self.case.add(
                "time-overlap",
                event.tick,
                f"{name} starts a run at {seconds(event.start_tick)}, "
                f"but what it did before lasted until {seconds(robot.free_tick)}",
            )
        if event.wait_ticks < 0 or event.turn_ticks < 0:
            self.case.add(
                "negative-time",
                event.tick,
                f"{name} waits for {seconds(event.wait_ticks)} and turns for {seconds(event.turn_ticks)}",
            )
        self._direction(event, robot)
        self._duration(event)
        self._waited(event, robot)
        robot.cell, robot.heading, robot.free_tick = event.to, event.heading, event.tick

    def _direction(self, event: RobotMoved, robot: RobotState) -> None:
        case, name = self.case, self.case.robot(event.robot)
        run = f"from {case.where(event.origin)} to {case.where(event.to)}"
        if event.origin != event.to:
            towards = case.heading(event.origin, event.to)
            if towards is None:
                case.add("not-straight", event.tick, f"{name} drives {run}, which is no straight run")
            elif towards != event.heading:
                case.add(
                    "heading",
                    event.tick,
                    f"{name} drives {run} in heading {towards}, but faces heading {event.heading}",
                )
        distance = case.layout.distance(event.origin, event.to)
        if event.distance_m != distance:
            case.add(
                "distance", event.tick, f"{name} drives {run}, {distance} m, but {event.distance_m} m are reported"
            )
        turn = case.turn_ticks(robot.heading, event.heading)
        if event.turn_ticks != turn:
            case.add(
                "turn-time",
                event.tick,
                f"{name} turns from heading {robot.heading} to {event.heading} in {seconds(event.turn_ticks)} "
                f"at {case.where(event.origin)}; that takes {seconds(turn)}",
            )

    def _duration(self, event: RobotMoved) -> None:
        distance = self.case.layout.distance(event.origin, event.to)
        needed = self.case.run_ticks(distance) if distance else 0
        taken = event.tick - event.start_tick - event.wait_ticks - event.turn_ticks
        if self.case.is_cut_off(event):  # towards a cell farther on: it has passed this one, and not the next one
            passed = reached_s(self.case.motion, LONGEST_M, distance) * TICKS_PER_S
            if passed - 1 <= taken <= self.case.run_ticks(distance + 1):
                return
        if taken != needed:
            self.case.add(
                "too-fast" if taken < needed else "too-slow",
                event.tick,
                f"{self.case.robot(event.robot)} drives {distance} m from {self.case.where(event.origin)} "
                f"to {self.case.where(event.to)} in {seconds(taken)}; that takes {seconds(needed)}",
            )

    def _waited(self, event: RobotMoved, robot: RobotState) -> None:
        """Note that a robot stood still in a queue; by free-flow nobody does."""
        if event.wait_ticks and not self.traffic:
            self.traffic = True  # told once
            waits = f"{self.case.robot(event.robot)} waits for {seconds(event.wait_ticks)} before a run"
            self.case.add("rule", event.tick, f"{waits}, but the scenario's PP rule, {NOBODY_WAITS}, lets nobody wait")
        lane = self.case.lane[event.origin]
        in_line = lane >= 0 and event.robot in self.state.stations[lane].line
        waited = event.pod is not None and event.start_tick + event.wait_ticks > robot.free_tick
        served = lane >= 0 and event.origin == self.case.layout.stations[lane].station  # its visit there is over
        if lane >= 0 and not in_line and waited and not served:  # without a pod it began there
            robot.rested_in = lane


class WayCheck:
    """Each cell of a run may be entered from the one before it, by this robot with what it carries."""

    def __init__(self, case: Case, state: State) -> None:
        self.case = case
        self.state = state
        self.handlers: Handlers = {RobotMoved: self.moved}

    def moved(self, event: RobotMoved) -> None:
        """Check the cells of a leg."""
        robot = self.state.robots[event.robot]
        if event.pod != robot.pod:
            self.case.add(
                "pod-mismatch",
                event.tick,
                f"{self.case.robot(event.robot)} drives with {self.case.load(event.pod)}, "
                f"but carries {self.case.load(robot.pod)}",
            )
            self.state.take(event.robot, event.pod)
        heading = self.case.heading(event.origin, event.to)
        if heading is None:
            return
        if robot.pod is not None and self.case.is_rest(event.origin) and event.origin != robot.lifted_at:
            self._storage(event, event.origin)
        robot.lifted_at = None
        self._follow(event, robot, heading)

    def _follow(self, event: RobotMoved, robot: RobotState, heading: int) -> None:
        case = self.case
        cell, step = event.origin, case.step(heading)
        while cell != event.to:
            before, cell = cell, cell + step
            if not case.moves[before] >> heading & 1:
                name, direction = case.robot(event.robot), ("east", "north", "west", "south")[heading]
                if case.kind[cell] == CellKind.WALL:
                    case.add("wall", event.tick, f"{name} drives through the wall at {case.where(cell)}")
                else:
                    case.add("one-way", event.tick, f"{name} leaves {case.where(before)} to the {direction}")
                return
            if case.lane[cell] != case.lane[before]:
                self._lane(event, robot, case.lane[cell])
            if robot.pod is not None and self._closed(event, cell):
                self._storage(event, cell)

    def _closed(self, event: RobotMoved, cell: int) -> bool:
        """Whether a robot with a pod must not come into a cell of its run."""
        if not self.case.is_storage(cell):
            return self.case.is_rest(cell)
        return cell != event.to or cell in self.state.stored

    def _lane(self, event: RobotMoved, robot: RobotState, lane: int) -> None:
        """Note that a robot enters the queue of a station, or leaves one."""
        name = self.case.robot(event.robot)
        if robot.lane is not None:
            self.case.add(
                "queue-lane", event.tick, f"{name} drove through the queue of {self.case.station(robot.lane)}"
            )
        robot.lane = None if lane < 0 else lane
        if robot.lane is not None and robot.pod is None:
            self.case.add(
                "queue-lane", event.tick, f"{name} enters the queue of {self.case.station(lane)} without a pod"
            )
            robot.lane = None

    def _storage(self, event: RobotMoved, cell: int) -> None:
        carrying = f"{self.case.robot(event.robot)} with {self.case.load(event.pod)}"
        if cell in self.state.stored:
            standing = self.case.pod(self.state.stored[cell])
            self.case.add(
                "through-stored-pod", event.tick, f"{carrying} drives into {standing} at {self.case.where(cell)}"
            )
        else:
            what = "storage location" if self.case.is_storage(cell) else "charger"
            self.case.add("storage-crossed", event.tick, f"{carrying} crosses the {what} {self.case.where(cell)}")
