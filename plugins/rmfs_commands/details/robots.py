"""Shares of each robot's time: rows of robots.csv."""

from __future__ import annotations

from collections import Counter
from typing import Any

from rmfs_commands.details.outages import robots_may_fail
from rmfs_commands.details.spans import Count, Handlers, Number, Span, ratio
from rmfs_commands.processes.events import ChargerDown, ChargerUp, RobotDown, RobotUp
from rmfs_core.clock import to_seconds
from rmfs_core.events import (
    DecisionMade,
    PodLifted,
    PodMoveDecided,
    PodStored,
    QueueJoined,
    RobotMoved,
    RobotRested,
    RobotSent,
    RobotsOnDuty,
    TaskAssigned,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.info import RunInfo

STATES = ("idle", "to_pod", "to_station", "queue", "station", "storing")
"""Activity of a robot: nothing; fetch a pod, until it has lifted it; carry it to a station, until it joins the queue;
queue; stand at the station; carry it to its storage location, until it has set it down."""

OFF = "off"
"""Nothing, off duty, elsewhere than at a charger; only where `robots.available` says when robots are on duty."""

TO_REST, CHARGING, LOW, MOVING, DOWN = "to_rest", "charging", "low", "moving_pods", "down"
"""And where the scenario has rules for that, batteries, or failures: drive to where it rests or is repaired; stand at a
charger; stand elsewhere with too little in its battery for a task; carry a pod elsewhere, without a visit; be out of
service."""

_UNDER_WAY = ("to_pod", "to_station", "storing")


class _Robot:
    """A robot: what it does since when, and until when it is known to have been busy with that."""

    def __init__(self, state: str, begin: int) -> None:
        self.state = state
        self.begin = begin
        self.since = self.free = 0
        self.ticks = dict.fromkeys((*STATES, TO_REST, CHARGING, LOW, MOVING, DOWN, "waiting", OFF), 0)
        self.metres = dict.fromkeys((TO_REST, MOVING), 0)
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
        # A robot that steps aside without a task may get one on the way: that leg began before it was under way.
        if start > self.free and start > self.begin and self.state in _UNDER_WAY:
            waited = start - max(self.free, self.begin)
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
        self._has_off = run.scenario.robots.available is not None
        self._chargers, self._broken = frozenset(run.layout.chargers), set[int]()
        self._warehouse = run.warehouse
        rules, self._battery = run.scenario.rules, run.scenario.robots.battery is not None
        fail = robots_may_fail(run.scenario.robots)
        used = {TO_REST: rules.idle is not None or (fail and bool(run.layout.maintenance))}
        used |= {CHARGING: self._battery, LOW: self._battery, MOVING: rules.move is not None, DOWN: fail}
        self._more = [state for state, there in used.items() if there]
        self._charges = self._moved_pods = 0
        self._lowest = 1.0
        self.for_room_ticks = 0
        """Time in which robots waited under their pods for a queue cell, summed over the robots."""
        self.free = Count()
        """Robots that can take a task: on duty, without one, and with charge enough."""
        self.charging = Count()
        """Robots on duty that wait for a charger, drive to one, or stand there until they are charged."""
        self.low = [Count() for _ in robots]
        """Which of these stand where they are, with too little in their batteries for a task."""
        self.down = Count()
        """Robots on duty that are out of service."""
        self.beneath: dict[int, Span] = {}
        """When a robot last waited under each pod for a queue cell, before it lifted the pod."""
        self.beneath_for: dict[int, list[Span]] = {}
        """All such times, by station."""
        self.on_duty = Count()
        """Robots on duty."""
        self.on_duty.add(0, len(robots))
        self._picked: tuple[int, Counter[str], int] | None = None
        self._none_ticks = self._none_since = 0
        self._counted: list[Count | None] = [None for _ in robots]  # where each robot counts
        self._sent: dict[int, int] = {}  # robots without a task to the cells where they were last sent
        for i in range(len(robots)):
            self._count(i, 0)
        self.handlers: Handlers = {
            TaskAssigned: lambda event: self._turn(event.robot, "to_pod", event.tick),
            RobotMoved: self._moved,
            PodLifted: self._lifted,
            QueueJoined: self._joined,
            VisitStarted: self._started,
            VisitEnded: self._ended,
            PodStored: self._stored,
            RobotsOnDuty: self._duty,
            RobotSent: self._sent_off,
            RobotRested: self._rested,
            RobotDown: self._fails,
            ChargerDown: self._charger_changed,
            ChargerUp: self._charger_changed,
            RobotUp: self._repaired,
            PodMoveDecided: lambda event: self._turn(event.robot, MOVING, event.tick),
            **({DecisionMade: self._decided} if self._battery else {}),
        }

    def _turn(self, robot: int, state: str, tick: int) -> None:
        """Let a robot do something else from now on."""
        self._robots[robot].turn_to(state, tick)
        self._count(robot, tick)

    def _count(self, robot: int, tick: int) -> None:
        """Count a robot as free, as one that charges, or as neither."""
        before, now = self._counted[robot], self._counts_as(robot)
        low = self._battery and now is self.charging and self._robots[robot].state == "idle"
        if low != self.low[robot].number:
            self.low[robot].add(tick, 1 if low else -1)
        if before is now:
            return
        if self.free in (before, now):
            self._none_ticks = self.none_free(tick)
            self._none_since = tick
        for count, change in ((before, -1), (now, 1)):
            if count is not None:
                count.add(tick, change)
        self._counted[robot] = now

    def _counts_as(self, robot: int) -> Count | None:
        state = self._robots[robot].state
        if not self._battery or robot >= self.on_duty.number:
            return self.free if state == "idle" else None
        if state == TO_REST:
            return self.charging if self._sent.get(robot) in self._chargers else None
        if state not in ("idle", CHARGING):
            return None
        known = self._warehouse.robots[robot]
        return self.charging if known.low or (state == CHARGING and known.goal is not None) else self.free

    def _fails(self, event: RobotDown) -> None:
        self._turn(event.robot, DOWN, event.tick)
        self._count_down(event.tick)

    def _repaired(self, event: RobotUp) -> None:
        self._turn(event.robot, self._resting(event.robot), event.tick)
        self._count_down(event.tick)

    def _count_down(self, tick: int) -> None:
        number = sum(robot.state == DOWN for robot in self._robots[: self.on_duty.number])
        self.down.add(tick, number - self.down.number)

    def _decided(self, event: DecisionMade) -> None:
        """Count robots anew whose batteries change while they stand."""
        for i, robot in enumerate(self._robots):
            if robot.state in ("idle", CHARGING):
                self._count(i, event.tick)

    def _sent_off(self, event: RobotSent) -> None:
        self._sent[event.robot] = event.cell
        self._turn(event.robot, TO_REST, event.tick)

    def none_free(self, tick: int) -> int:
        """Return for how many ticks, up to now, no robot was free."""
        return self._none_ticks + (0 if self.free.number else tick - self._none_since)

    def _moved(self, event: RobotMoved) -> None:
        robot, start = self._robots[event.robot], event.start_tick + event.wait_ticks
        if start > robot.free:
            robot.busy(start, event.tick)
        robot.free = event.tick
        if event.tick >= self._begin:
            robot.distance_m += event.distance_m
            if event.pod is not None:
                robot.loaded_m += event.distance_m
            if robot.state in robot.metres:
                robot.metres[robot.state] += event.distance_m
        if self._battery:
            self._look_at(event.robot)

    def _lifted(self, event: PodLifted) -> None:
        robot, start = self._robots[event.robot], event.start_tick
        self.beneath[event.pod] = min(robot.free, start), start
        self.for_room_ticks += robot.busy(start, event.tick)
        if robot.state != MOVING:
            robot.turn_to("to_station", event.tick)

    def _joined(self, event: QueueJoined) -> None:
        if (waited := self.beneath.pop(event.pod, None)) is not None:
            self.beneath_for.setdefault(event.station, []).append(waited)
        self._robots[event.robot].turn_to("queue", event.tick)

    def _started(self, event: VisitStarted) -> None:
        self._at[event.pod] = event.robot
        self._robots[event.robot].turn_to("station", event.tick)

    def _ended(self, event: VisitEnded) -> None:
        state = "storing" if event.next_station is None else "to_station"
        self._robots[self._at[event.pod]].turn_to(state, event.tick)

    def _stored(self, event: PodStored) -> None:
        robot = self._robots[event.robot]
        robot.busy(event.start_tick, event.tick)
        self._moved_pods += robot.state == MOVING and event.tick >= self._begin
        self._turn(event.robot, self._resting(event.robot), event.tick)
        if self._battery:
            self._look_at(event.robot)

    def _duty(self, event: RobotsOnDuty) -> None:
        self.on_duty.add(event.tick, event.number - self.on_duty.number)
        for i, robot in enumerate(self._robots):
            if robot.state in ("idle", OFF):
                self._turn(i, self._resting(i), event.tick)
            else:
                self._count(i, event.tick)
        self._count_down(event.tick)

    def _resting(self, robot: int) -> str:
        if self._battery and self._warehouse.robots[robot].cell in self._chargers - self._broken:
            return CHARGING
        return "idle" if robot < self.on_duty.number else OFF

    def _rested(self, event: RobotRested) -> None:
        self._turn(event.robot, state := self._resting(event.robot), event.tick)
        self._charges += state == CHARGING and event.tick >= self._begin

    def _charger_changed(self, event: ChargerDown | ChargerUp) -> None:
        (self._broken.add if isinstance(event, ChargerDown) else self._broken.discard)(event.cell)
        for i, robot in enumerate(self._robots):
            if robot.state in (CHARGING, "idle", OFF) and self._warehouse.robots[i].cell == event.cell:
                self._turn(i, self._resting(i), event.tick)

    def _look_at(self, robot: int) -> None:
        """Note how much is in its battery."""
        self._lowest = min(self._lowest, self._warehouse.robots[robot].charge or 0.0)

    def values(self, end: int, completed: int) -> dict[str, Number]:
        """Return the metrics of what robots do without a task, as far as the scenario lets them, and what is left."""
        for robot in self._robots:
            robot.turn_to(robot.state, end)
        metres = {state: sum(robot.metres[state] for robot in self._robots) for state in (TO_REST, MOVING)}
        charging = 100 * sum(robot.ticks[CHARGING] for robot in self._robots)
        found: dict[str, dict[str, Number]] = {
            TO_REST: {"resting_distance_m": metres[TO_REST]},
            CHARGING: {
                "charges": self._charges,
                "charging_percent": ratio(charging, len(self._robots) * (end - self._begin)),
                "charge_lowest_percent": 100 * self._lowest,
            },
            MOVING: {"pods_moved": self._moved_pods, "moving_distance_m": metres[MOVING]},
        }
        picking = sum(robot.distance_m for robot in self._robots) - sum(metres.values())
        return {
            "picking_distance_per_order_m": ratio(picking, completed),
            **{name: value for state in self._more for name, value in found.get(state, {}).items()},
        }

    def picked(self, tick: int) -> None:
        """Note what the robots' time went to until the last pick, after which some may only be packed."""
        self._picked = tick, self._spent(tick), self.for_room_ticks

    def spent(self, end: int) -> tuple[Counter[str], int]:
        """Return the ticks of each state summed over the robots, until the run's end or the last pick, and those of
        waiting for a queue cell."""
        if self._picked is not None and self._picked[0] == end:
            return self._picked[1:]
        return self._spent(end), self.for_room_ticks

    def _spent(self, end: int) -> Counter[str]:
        ticks: Counter[str] = Counter()
        for robot in self._robots:
            ticks.update(robot.ticks)
            ticks[robot.state] += max(end, robot.begin) - max(robot.since, robot.begin)
        return ticks

    @property
    def waiting_ticks(self) -> int:
        """Time in which robots waited for others, summed over the robots."""
        return sum(robot.ticks["waiting"] for robot in self._robots)

    def rows(self, end: int) -> list[dict[str, Any]]:
        """Return a row for each robot; its times add up to that of the run after the warm-up.

        ``off_s`` is there where robots are off duty at times. ``waiting_s`` is not in the others: the time under way in
        which a robot neither drives nor turns nor lifts, since others are in its way or the station's queue is full.
        """
        for robot, low in zip(self._robots, self.low, strict=True):
            robot.turn_to(robot.state, end)
            low_ticks = round(low.mean(self._begin, end) * (end - self._begin))
            robot.ticks["idle"] += robot.ticks[LOW] - low_ticks
            robot.ticks[LOW] = low_ticks
        return [
            {
                "robot": name,
                "distance_m": robot.distance_m,
                "loaded_distance_m": robot.loaded_m,
                **{
                    f"{state}_s": to_seconds(robot.ticks[state])
                    for state in (*STATES, *self._more, "waiting", *([OFF] if self._has_off else []))
                },
            }
            for name, robot in zip(self._names, self._robots, strict=True)
        ]
