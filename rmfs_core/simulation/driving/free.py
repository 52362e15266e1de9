"""Driving as if each robot were alone: robots pass through each other, and only the lines at the stations count."""

from __future__ import annotations

from collections import deque

import simpy

from rmfs_core.clock import UNREACHABLE, to_seconds
from rmfs_core.events import QueueJoined
from rmfs_core.simulation.context import RunContext
from rmfs_core.simulation.driving.base import Driving, Process
from rmfs_core.warehouse import Robot, Station


class FreeDriving(Driving):
    """For PP rules that reserve nothing.

    The line at a station is in order of arrival. A robot drives to the slot behind those in line when it sets out.
    """

    def __init__(self, run: RunContext) -> None:
        super().__init__(run)
        self._line_moved: list[simpy.Event] = [run.env.event() for _ in run.warehouse.stations]
        self.next_legs: dict[int, deque[list[int]]] = {}  # by robot: cell and wait of those after that under way

    def left(self, station: Station) -> None:
        """Let those in line move up."""
        moved, self._line_moved[station.id] = self._line_moved[station.id], self.run.env.event()
        self.standing[station.id].clear()
        moved.succeed()

    def to_location(self, robot: Robot, cell: int) -> Process:
        """Drive to a storage location, from a queue through its station."""
        lane = int(self.run.warehouse.travel.layout.lane[robot.cell])
        if lane >= 0:
            yield from self._drive(robot, self.run.warehouse.stations[lane].cell)
        yield from self._drive(robot, cell)

    def to_station(self, robot: Robot, station: Station) -> Process:
        """Drive to the end of the line, join it, and move up until the station is reached."""
        if robot not in station.line:
            yield from self._drive(robot, station.cells.slot(len(station.line)))
            self.join(robot, station)
        slots = (station.cell, *station.cells.queue[station.cells.clear :])
        while True:
            line = station.line
            place = min(line.index(robot), len(slots) - 1)
            # Whoever came while this robot was still driving may stand behind its own position: nobody backs up.
            if robot.cell not in slots or slots.index(robot.cell) > place:
                yield from self._drive(robot, slots[place])
            elif line[0] is robot:
                return
            else:
                self.standing[station.id].append(robot)
                yield self._line_moved[station.id]

    def join(self, robot: Robot, station: Station) -> None:
        """Let a robot that has come to the end of a line stand there."""
        self.run.warehouse.join_line(robot, station)
        assert robot.pod is not None
        self.run.tell(QueueJoined(self.run.warehouse.now, robot=robot.id, pod=robot.pod, station=station.id))

    def _drive(self, robot: Robot, goal: int) -> Process:
        """Drive to a cell, one event a leg; the rule is asked again where its path ends before the goal."""
        run, travel, loaded = self.run, self.run.warehouse.travel, robot.pod is not None
        nearest, nearer = UNREACHABLE + 1, run.warehouse.now
        while robot.cell != goal:
            if (ticks := travel.ticks(robot.cell, robot.heading, goal, loaded)) < nearest:
                nearest, nearer = ticks, run.warehouse.now
            if run.warehouse.now - nearer > self.standstill_ticks:
                since_s = to_seconds(run.warehouse.now - nearer)
                problem = f"robot {robot.name} has come no nearer to {travel.layout.where(goal)} for {since_s:.0f} s"
                raise run.asker.error(self.rule, f"{problem} ({self.allowed})")
            yield from self.follow(robot, deque(self.path(robot, goal).tolist()), run.warehouse.now)

    def follow(self, robot: Robot, legs: deque[list[int]], start: int) -> Process:
        """Drive legs, on the first of them since a tick."""
        self.next_legs[robot.id] = legs
        while legs:
            to, wait = legs.popleft()
            heading, turn, ticks = self.turn_and_run(robot, to)
            yield self.set_off(robot, to, wait, heading, start, turn, start + wait + turn + ticks)
            self.arrive(*self.under_way.pop(robot.id))
            start = self.run.warehouse.now
