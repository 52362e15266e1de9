"""Driving along reserved paths: what full and windowed paths have in common.

Every robot has a course: the legs that it has reserved and still has to drive, and a process that drives them. Legs
may be replaced at any time by others that begin where the leg under way ends, or at once where the robot stands.
"""

from __future__ import annotations

from collections import deque

import numpy as np
import simpy
from attrs import define, field

from rmfs_core.decisions import Rows
from rmfs_core.errors import InputError
from rmfs_core.events import QueueJoined
from rmfs_core.simulation import checks
from rmfs_core.simulation.context import RunContext
from rmfs_core.simulation.driving.base import NO_LEGS, Driving, Process
from rmfs_core.simulation.going import Going
from rmfs_core.warehouse import Robot, Station
from rmfs_core.world.grid import RESTING
from rmfs_core.world.travel import Travel
from rmfs_traffic import Occupancy, Query, Reservations, ReservedError, Roads, Traffic, drive, roads_on
from rmfs_traffic.paths import Stop

FORGET_TICKS = 10_000
"""How often reservations of the past are removed from the table."""


@define(eq=False)
class Course:
    """A drive of a robot.

    Parameters
    ----------
    robot
        The robot.
    changed
        Happens when the legs are replaced.
    arrived
        Happens when the robot is at rest in its goal.
    goal
        Cell in which its course shall end.
    station
        Station whose line it is in or on its way to.
    legs
        Legs that are reserved and not yet begun: end and wait of each leg.
    under_way
        The leg that it drives: where and when that began, and where and when it ends.
    since
        Tick at which it came to rest, or was given a path.
    joined
        Whether it stands in the line.
    reserved, arrives
        Cells that its path occupies, the leg under way included, and the tick at which it ends.
    overtaken
        How many robots have come between it and the head of the line since it took its position there.
    waits, ready
        Event that it waits for before its next leg; the tick until which it waits, where a state has told that.
    """

    robot: Robot
    changed: simpy.Event
    arrived: simpy.Event
    goal: int
    station: Station | None = None
    legs: deque[list[int]] = field(factory=deque)
    under_way: tuple[Stop, Stop] | None = None
    since: int = 0
    joined: bool = False
    reserved: Rows | None = None
    arrives: int = 0
    overtaken: int = 0
    waits: simpy.Event | None = None
    ready: int | None = None


def _either(one: simpy.Event, other: simpy.Event) -> simpy.Event:
    """Event that happens right after the first of two: quicker than `simpy.AnyOf`, which keeps what they tell."""
    first = one.env.event()

    def happen(_: simpy.Event) -> None:
        if not first.triggered:
            first.succeed()

    one.callbacks.append(happen)
    other.callbacks.append(happen)
    return first


class ReservedDriving(Driving):
    """Base of the ways to drive that keep robots out of each other's way.

    Raises
    ------
    InputError
        When no storage location would be left for a robot to step aside.
    """

    @classmethod
    def prepare_with(cls, travel: Travel) -> Roads:
        """Return the roads of the travel times."""
        return roads_on(travel)

    def __init__(self, run: RunContext) -> None:
        super().__init__(run)
        self.env = run.env
        travel = run.warehouse.travel
        robots, locations = run.warehouse.robots, travel.layout.storage_locations
        if len(robots) >= len(locations) and len(robots) > 1:
            raise InputError(
                "robots.count",
                f"found {len(robots)} robots and {len(locations)} storage locations; {self.rule.describe()} needs one "
                "location more than robots, so that one can always step aside",
            )
        self.roads = roads_on(travel)
        self.table = Reservations(self.roads.cells)
        self.courses = [Course(r, run.env.event(), run.env.event(), r.cell) for r in robots]
        self.lines: list[list[Course]] = [[] for _ in run.warehouse.stations]
        """Robots in the line of each station or with a position in it, first in line first."""
        self._locations = np.array(locations, dtype=np.int64)
        self.owner: dict[int, Course] = {course.goal: course for course in self.courses}
        self._forgotten = 0
        self._run = np.zeros((1, 2), dtype=np.int64)
        """A leg without a wait, for those who read it at once."""
        self._driving: set[int] = set()
        for course in () if run.begun else self.courses:
            self.table.hold(course.robot.id, course.robot.cell, 0)
        self.table.forget_before(0)

    def begin(self) -> None:
        """Let robots drive what is reserved; robots elsewhere than in storage locations make way."""
        if not {course.goal for course in self.courses}.issubset(self._locations.tolist()):
            self.env.process(self._make_way())  # before anyone else sets out
        for course in self.courses:
            self.go_on(course.robot.id)

    def go_on(self, robot: int) -> None:
        """Let a robot drive what is reserved for it."""
        if robot not in self._driving:
            self._driving.add(robot)
            self.env.process(self._follow(self.courses[robot]))

    def place(self, robot: Robot, station: Station) -> None:
        """Take in a robot that stands in the line of a station from the start."""
        course = self.courses[robot.id]
        self.table.release(robot.id)
        self.table.hold(robot.id, robot.cell, 0)
        self.own(course, robot.cell)
        course.station, course.joined = station, True
        self.lines[station.id].append(course)

    # What the two kinds do differently

    def _path_ended(self, course: Course) -> None:
        """Do what is due when a course has no legs left."""
        raise NotImplementedError

    def _send(self, course: Course, goal: int) -> None:
        """Give a robot a new goal."""
        raise NotImplementedError

    def set_out_for(self, course: Course, cell: int) -> None:
        """Send a robot to a storage location that nobody else owns."""
        raise NotImplementedError

    def register(self, course: Course, to: int) -> tuple[Stop, Stop] | None:
        """Take note that a robot begins a leg, after its wait; return its start and end, None if it may not."""
        start, (heading, turn, ticks) = self.next_stop(course), self.turn_and_run(course.robot, to)
        return start, Stop(to, heading, start.start_tick + turn + ticks)

    # Paths

    def next_stop(self, course: Course) -> Stop:
        """From where and when a new path of a robot can begin."""
        if course.under_way is not None:
            return course.under_way[1]
        return Stop(course.robot.cell, course.robot.heading, self.run.warehouse.now)

    def _departure(self, course: Course, goal: int) -> Query:
        return Query(course.robot.id, *self.next_stop(course), goal, course.robot.pod is not None)

    def _ask(self, query: Query, *, needed: bool = True) -> Rows:
        """Ask the PP rule for a path among what is reserved."""
        robot, traffic = self.run.warehouse.robots[query.robot], Traffic(self.roads, self.table, query)
        return self.path(robot, query.goal, traffic, query.cell, needed=needed)

    def _commit(self, course: Course, legs: Rows) -> Rows:
        """Reserve a path instead of what the robot has not begun; return what it occupies."""
        try:
            rows, end = self.table.settle(course.robot.id, self.roads, *self._begun(course, legs))
        except ReservedError as error:
            raise checks.hit(self.roads.layout, course.robot.id, error) from None
        course.reserved, course.arrives, now = rows, end.start_tick, self.run.warehouse.now
        if course.under_way is None and not course.legs:
            course.since = now
        self._replace(course, legs)
        if now - self._forgotten > FORGET_TICKS:
            self._forgotten = now
            self.table.forget_before(now)
        return rows

    def _replace(self, course: Course, legs: Rows) -> None:
        """Give a robot other legs to drive instead of legs not begun."""
        course.legs = deque(legs.tolist())
        if course.changed.callbacks:  # somebody waits for it
            changed, course.changed = course.changed, self.env.event()
            changed.succeed()

    def _begun(self, course: Course, legs: Rows) -> tuple[Stop, Rows]:
        """Return legs after the leg under way, if there is one, and from where and when all of them are driven."""
        if course.under_way is None:
            return self.next_stop(course), legs
        start, end = course.under_way
        self._run[0, 0] = end.cell
        return start, np.concatenate((self._run, legs))

    def _drive(self, course: Course, legs: Rows = NO_LEGS) -> tuple[Occupancy, Stop]:
        """Return what legs occupy and where they end, after the leg under way if there is one."""
        return drive(self.roads, *self._begun(course, legs))

    def _follow(self, course: Course) -> Process:
        """Drive what is reserved, leg by leg, forever."""
        robot, run, stands = course.robot, self.run, Going("wait", course.robot.id)
        while True:
            if course.under_way is None:
                if not course.legs:
                    self._path_ended(course)
                    if not course.legs:
                        yield course.changed
                    continue
                if wait := course.legs[0][1]:
                    ticks, course.ready = wait if course.ready is None else course.ready - run.warehouse.now, None
                    changed, course.waits = course.changed, run.after(ticks, stands)
                    yield _either(course.waits, changed)
                    course.waits = None
                    if changed.triggered:
                        continue
                to, _ = course.legs.popleft()
                if to == robot.cell or (registered := self.register(course, to)) is None:
                    continue
                course.under_way = registered
            ((_, before, begun), (to, heading, arrival)), since = course.under_way, course.since
            yield self.set_off(robot, to, begun - since, heading, since, self.turns[(heading - before) % 4], arrival)
            self.arrive(*self.under_way.pop(robot.id))
            course.under_way, course.since = None, arrival
            if course.station is not None and not course.joined:
                self._join(course.station)

    # Robots that begin elsewhere than in storage locations

    def _make_way(self) -> Process:
        """Send robots that begin in queues on through the station, and those on the floor to storage locations.

        Those at chargers and in maintenance cells rest there. On the floor the one with the fewest cells to go is next:
        no other stands in its way.
        """
        resting = (course for course in self.courses if course.robot.task is None and course.robot.goal is None)
        idle = {course.robot.cell: course for course in resting if self.rests(course)}
        kind = self.roads.layout.kind
        for station, line in zip(self.run.warehouse.stations, self.lines, strict=True):
            for cell in (station.cell, *station.cells.queue):
                if cell in idle:
                    self._send(idle[cell], station.cells.slot(len(line)))
                    idle[cell].station = station
                    line.append(idle.pop(cell))
        while strays := {cell for cell in idle if kind[cell] not in RESTING}:
            free = [location for location in self._locations.tolist() if location not in self.owner]
            cell, location = self.roads.layout.nearest(strays, free)
            self._send(idle.pop(cell), location)
        yield from ()

    def to_location(self, robot: Robot, cell: int) -> Process:
        """Drive to a storage location; a robot that rests there is sent away first, and rests elsewhere."""
        course = self.courses[robot.id]
        while course.station is not None and robot.pod is None:
            yield course.arrived  # it began in a queue
        self._clear(cell, robot)
        self.set_out_for(course, cell)
        while robot.cell != course.goal or not self.rests(course):
            yield course.arrived

    def rests(self, course: Course) -> bool:
        """Whether a robot stands and has nowhere to go yet."""
        return course.under_way is None and not course.legs

    def _arrive(self, course: Course) -> None:
        """Wake the process that waits for the robot; one that began in a queue goes on from the station at once."""
        if course.station is not None and course.robot.pod is None and course.robot.cell == course.station.cell:
            self.set_out_for(course, self._refuge(course))
        if course.arrived.callbacks:
            arrived, course.arrived = course.arrived, self.env.event()
            arrived.succeed()

    # Lines and positions

    def _join(self, station: Station) -> None:
        """Let robots in the lane join the line, in the order of their cells."""
        lane = self.roads.layout.lane
        for course in self.lines[station.id]:
            if course.station is station and not course.joined and course.robot.pod is not None:
                robot = course.robot
                if lane[robot.cell] != station.id:
                    break
                self.run.warehouse.join_line(robot, station)
                course.joined = True
                assert robot.pod is not None
                self.run.tell(QueueJoined(self.run.warehouse.now, robot=robot.id, pod=robot.pod, station=station.id))

    def _outside(self, course: Course, station: Station) -> bool:
        """Whether a robot is not in the lane of a station, nor on the leg into it."""
        lane = self.roads.layout.lane
        return station.id not in (lane[course.robot.cell], lane[self.next_stop(course).cell])

    def leave_line(self, course: Course) -> Station | None:
        """Take a robot out of the line that it stood first in; return that line's station."""
        station, course.station, course.joined = course.station, None, False
        if station is not None:
            self.lines[station.id].remove(course)
        return station

    def own(self, course: Course, goal: int) -> None:
        """Make a cell the one that a robot goes to and no other may."""
        assert self.owner.get(goal, course) is course
        self._disown(course)
        self.owner[goal] = course
        course.goal = goal

    def _disown(self, course: Course) -> None:
        """Give up the cell that a robot owns."""
        if self.owner.get(course.goal) is course:
            del self.owner[course.goal]

    def _clear(self, goal: int, robot: Robot) -> None:
        """Let an empty robot that owns a storage location step aside for another that has to go there."""
        other = self.owner.get(goal)
        if other is not None and other.robot is not robot:
            assert other.robot.pod is None
            self._send(other, self._refuge(other))

    def _refuge(self, course: Course) -> int:
        """Storage location nearest to an empty robot that no robot owns; if possible one whose pod nobody waits for."""
        stop, warehouse = self.next_stop(course), self.run.warehouse
        wanted = {pod.location for pod in warehouse.waiting.values()}
        times = warehouse.travel.times_from(stop.cell, stop.heading, False)[self._locations]
        for i in np.lexsort((self._locations, times)):
            cell = int(self._locations[i])
            if cell not in self.owner and cell not in wanted:
                return cell
        return next(cell for cell in map(int, self._locations) if cell not in self.owner)
