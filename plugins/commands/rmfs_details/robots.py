"""What each robot's time goes to: rows of robots.csv."""

from __future__ import annotations

from typing import Any

from rmfs_core.clock import to_seconds
from rmfs_core.events import (
    PodLifted,
    PodStored,
    QueueJoined,
    RobotMoved,
    TaskAssigned,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.info import RunInfo
from rmfs_details.spans import Handlers

STATES = ("idle", "to_pod", "to_station", "queue", "station", "storing")
"""What a robot does: nothing; fetch a pod, until it has lifted it; carry it to a station, until it joins the queue;
queue; stand at the station; carry it to its storage location, until it has set it down."""

_UNDER_WAY = ("to_pod", "to_station", "storing")


class _Robot:
    """A robot: what it does since when, and until when it is known to have been busy with that."""

    def __init__(self, state: str, begin: int) -> None:
        self.state = state
        self.begin = begin
        self.since = self.free = 0
        self.ticks = dict.fromkeys((*STATES, "waiting"), 0)
        self.distance_m = self.loaded_m = 0

    def turn_to(self, state: str, tick: int) -> None:
        """Do something else from now on."""
        self.ticks[self.state] += max(tick, self.begin) - max(self.since, self.begin)
        self.state, self.since, self.free = state, tick, tick

    def busy(self, start: int, tick: int) -> int:
        """Note that it drove, turned or lifted; before that it waited, unless it was no time to be under way.

        Returns how long it waited.
        """
        waited = 0
        if self.state in _UNDER_WAY:
            # A robot that steps aside without a task may get one on the way: that leg began before it was under way.
            waited = max(max(start, self.begin) - max(self.free, self.begin), 0)
            self.ticks["waiting"] += waited
            self.ticks[self.state] -= waited
        self.free = tick
        return waited


class Robots:
    """Follows the robots.

    Parameters
    ----------
    run
        The run.
    begin
        The time from which on is counted.
    """

    def __init__(self, run: RunInfo, begin: int) -> None:
        robots = run.warehouse.robots
        self._names = [robot.name for robot in robots]
        self._robots = [_Robot("idle" if robot.pod is None else "queue", begin) for robot in robots]
        self._at = {pod: robot.id for robot in robots if (pod := robot.pod) is not None}
        self._begin = begin
        self.for_room_ticks = 0
        """Time in which robots waited beneath their pods for room at a station, summed over the robots."""
        self.handlers: Handlers = {
            TaskAssigned: lambda event: self._robots[event.robot].turn_to("to_pod", event.tick),
            RobotMoved: self._moved,
            PodLifted: self._lifted,
            QueueJoined: lambda event: self._robots[event.robot].turn_to("queue", event.tick),
            VisitStarted: self._started,
            VisitEnded: self._ended,
            PodStored: self._stored,
        }

    def _moved(self, event: RobotMoved) -> None:
        robot = self._robots[event.robot]
        robot.busy(event.start_tick + event.wait_ticks, event.tick)
        if event.tick >= self._begin:
            robot.distance_m += event.distance_m
            robot.loaded_m += event.distance_m if event.pod is not None else 0

    def _lifted(self, event: PodLifted) -> None:
        robot = self._robots[event.robot]
        self.for_room_ticks += robot.busy(event.start_tick, event.tick)
        robot.turn_to("to_station", event.tick)

    def _started(self, event: VisitStarted) -> None:
        self._at[event.pod] = event.robot
        self._robots[event.robot].turn_to("station", event.tick)

    def _ended(self, event: VisitEnded) -> None:
        state = "storing" if event.next_station is None else "to_station"
        self._robots[self._at[event.pod]].turn_to(state, event.tick)

    def _stored(self, event: PodStored) -> None:
        robot = self._robots[event.robot]
        robot.busy(event.start_tick, event.tick)
        robot.turn_to("idle", event.tick)

    @property
    def waiting_ticks(self) -> int:
        """Time in which robots waited for others, summed over the robots."""
        return sum(robot.ticks["waiting"] for robot in self._robots)

    def rows(self, end: int) -> list[dict[str, Any]]:
        """Return a row for each robot; its times add up to that of the run after the warm-up.

        ``waiting_s`` is not in the others: the time under way in which a robot neither drives nor turns nor lifts,
        since others are in its way or the station has no room.
        """
        for robot in self._robots:
            robot.turn_to(robot.state, end)
        return [
            {
                "robot": name,
                "distance_m": robot.distance_m,
                "loaded_distance_m": robot.loaded_m,
                **{f"{state}_s": to_seconds(ticks) for state, ticks in robot.ticks.items()},
            }
            for name, robot in zip(self._names, self._robots, strict=True)
        ]
