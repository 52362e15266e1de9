"""Driving paths planned for a window of time, as RAWSim-O does it for WHCA*_n.

Non-volatile: reservations live on, and only robots that need a new path plan, at most one round of them per second of
simulated time: robots with pods first, then those nearer to their goals. A robot plans when it is given a goal, where
its path ends before the goal, when it has lost its path (below), and when the line it stands in moves. One that finds
no path that moves it stays and plans again two seconds later at the latest, asking no rule while others keep all cells
next to it; one that has found none, or has been refused, for thirty seconds steps into a free one, drawn at random.

Robots drive run by run, and each run is registered when it begins. It occupies its cells as a reserved one does, but
its last cell without end, since nobody knows yet that the next run will begin in time. No two registered runs overlap;
a robot at rest has registered its cell. So a run is refused if it crosses a cell after another robot has come to a stop
there, or comes to a stop in one that another has yet to cross, even if the reserved paths would let both pass. A robot
that is refused loses its path and keeps its cell; the robot that had reserved that cell loses its path too, and stops
where its own run ends. A run by a shortcut or a second entrance is refused as well as long as a robot that is ahead in
the line would be behind it then: those ahead have to stand, or be on runs that end, nearer to the station. So robots
stand in a lane in the order of their line; who joins it later is not ahead of one that has come so. Where those
ahead have no such paths yet, a robot is planned for to the far end of the queue; in the lane, it waits.

The line at a station is in the order in which the reserved paths enter its queue; a robot that loses its path on the
way there loses its position. A robot plans for the position behind those ahead of it, and leaves the line when it
begins its first run away from the station.

There is no proof against deadlock: a robot that finds no path, or has been refused for thirty seconds, when it has come
no nearer to its goal than ever before for longer than `Driving.standstill_ticks`, ends the run with an error that says
who waits for whom. Time that it drives nearer does not count, however slow it is.

Source: M. Merschformann, L. Xie, D. Erdmann, Multi-agent path finding with kinematic constraints for robotic mobile
fulfillment systems, arXiv:1706.09347.
"""

from __future__ import annotations

from bisect import insort
from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import pairwise, takewhile

import numpy as np
from attrs import define, evolve

from rmfs_core.clock import UNREACHABLE, far, to_seconds
from rmfs_core.decisions import Rows
from rmfs_core.errors import StandstillError
from rmfs_core.randomness import stream
from rmfs_core.simulation.context import RunContext
from rmfs_core.simulation.driving.base import NO_LEGS, Process
from rmfs_core.warehouse import Robot, Station
from rmfs_traffic import FOREVER, Query, Reservations, ReservedError, drive
from rmfs_traffic.paths import Stop
from rmfs_traffic.reserved import Course, ReservedDriving

ROUND_TICKS = 1000
RETRY_TICKS = 2000
PATIENCE_TICKS = 30_000


@define
class Progress:
    """How far a robot has come on its way to one goal.

    Parameters
    ----------
    moved
        Tick at which its last run ended or ends, or at which it was given its goal, or the position ahead in its line.
    nearest, nearer
        Ticks from the goal, other robots ignored, of the nearest stop that it asked for a path at and found none, and
        ``moved`` as it was then.
    entry
        Tick at which its path enters the queue of the station it goes to.
    leaves
        Station that it stands in front of until it begins a run away.
    refused
        Cell that it was refused a run for since it moved last; None when it was not.
    passes
        Whether it came into its lane by a shortcut or a second entrance: nobody gets a position ahead of it any more.
    """

    moved: int = 0
    nearest: int = UNREACHABLE + 1
    nearer: int = 0
    entry: int = -1
    leaves: Station | None = None
    refused: int | None = None
    passes: bool = False


class WindowedDriving(ReservedDriving):
    """For PP rules whose paths may end before the goal."""

    def __init__(self, run: RunContext) -> None:
        super().__init__(run)
        self.progress_of = [Progress() for _ in self.courses]
        self.registered = Reservations(self.roads.cells)
        """The runs under way, or the cells that robots stand in; no two robots ever have a cell at once."""
        for course in () if run.begun else self.courses:
            self.registered.hold(course.robot.id, course.robot.cell, 0)
        lanes = [(station.cell, *station.cells.queue) for station in run.warehouse.stations]
        self._slots = [(slots, dict(pairwise(slots))) for slots in lanes]
        """By station: the cells of its lane, and which of them is behind which."""
        self._ways_past = lru_cache(1 << 16)(self._find_ways_past)
        self._queues = np.zeros((len(lanes), self.roads.cells), dtype=np.bool_)
        for queue, (_, *cells) in zip(self._queues, lanes, strict=True):
            queue[cells] = True
        self.asking: dict[int, Course] = {}
        self._round_due = False
        self._last_round = -ROUND_TICKS
        self._rng = stream(run.scenario.seed, "robots that step aside")

    def place(self, robot: Robot, station: Station) -> None:
        """Take in a robot that stands in the line of a station from the start."""
        super().place(robot, station)
        self.registered.release(robot.id)
        self.registered.hold(robot.id, robot.cell, 0)

    def to_station(self, robot: Robot, station: Station) -> Process:
        """Drive to the end of the line, and move up until the robot stands in front of the picker."""
        course = self.courses[robot.id]
        if course.station is not station:
            self.leave_station(course)
            self._disown(course)
            course.station, course.goal = station, station.cell
            self.progress_of[robot.id].passes = False
            self._set_out(course)
        while robot.cell != station.cell:
            yield course.arrived

    def set_out_for(self, course: Course, cell: int) -> None:
        """Send a robot to a storage location that nobody else owns."""
        self.leave_station(course)
        self._send(course, cell)

    def _send(self, course: Course, goal: int) -> None:
        if goal != course.goal or course.robot.cell != goal:
            self.own(course, goal)
            self._set_out(course)

    def _set_out(self, course: Course) -> None:
        self._start_clocks(course)
        self._request(course)

    def _start_clocks(self, course: Course) -> None:
        progress = self.progress_of[course.robot.id]
        progress.moved = progress.nearer = self.run.warehouse.now
        progress.nearest, progress.refused = UNREACHABLE + 1, None

    def leave_station(self, course: Course) -> None:
        """Note that a robot goes elsewhere; it stays in the line until it begins a run away."""
        if course.station is not None:
            self.progress_of[course.robot.id].leaves = course.station
            course.station, course.joined = None, False

    def _target(self, course: Course) -> int:
        """Cell that a robot is planned for to: its goal, or its present position in a line."""
        if course.station is None:
            return course.goal
        line = self.lines[course.station.id]
        return course.station.cells.slot(line.index(course) if course in line else len(line))

    # Planning rounds

    def _path_ended(self, course: Course) -> None:
        if course.robot.cell == self._target(course):
            self._arrive(course)
        else:
            self._request(course)

    def _request(self, course: Course) -> None:
        """Let a robot plan in the next round."""
        self.asking[course.robot.id] = course
        if not self._round_due:
            self._round_due = True
            delay = max(self._last_round + ROUND_TICKS - self.run.warehouse.now, 0)
            self.run.after(delay).callbacks.append(self._round)

    def _round(self, _: object) -> None:
        self._round_due, self._last_round = False, self.run.warehouse.now
        asking, self.asking = [*self.asking.values()], {}
        if len(asking) > 1:
            asking.sort(key=self._priority)
        for course in asking:
            self.plan(course)

    def _priority(self, course: Course) -> tuple[bool, int, int]:
        loaded = course.robot.pod is not None
        stop, target = self.next_stop(course), self._target(course)
        ticks = self.run.warehouse.travel.ticks(stop.cell, stop.heading, target, loaded)
        return not loaded, ticks, course.robot.id

    def plan(self, course: Course) -> None:
        """Ask for a path and reserve it; a robot without one asks again, and steps aside in the end."""
        self.asking.pop(course.robot.id, None)  # whom another has stopped in this round has asked again
        query = self._departure(course, self._target(course))
        if query.cell == query.goal:
            if self.rests(course):
                self._arrive(course)
            elif course.legs:  # it passes its goal, and could go on
                self.stop(course)
            return
        legs = NO_LEGS if self._is_shut_in(query) else self._ask(query, needed=False)
        if len(legs) and course.station is not None:
            ends = [query.cell, *legs[:, 0].tolist()]
            ways = [cell for start, end in pairwise(ends) for cell in self._ways_past(course.station, start, end)]
            if ways and self.gets_ahead(course, ways, planned=True) is not None:
                legs = self._ask(evolve(query, goal=course.station.cells.queue[-1]), needed=False)
        if len(legs) and legs[0, 0] == query.cell and (legs[:, 0] == query.cell).all():
            legs = NO_LEGS
        progress = self.progress_of[course.robot.id]
        if not len(legs) or (progress.refused is not None and self._has_stood_long(course)):
            ticks = self.run.warehouse.travel.ticks(query.cell, query.heading, course.goal, query.loaded)
            if ticks < progress.nearest:
                progress.nearest, progress.nearer = ticks, progress.moved
            if self.run.warehouse.now - progress.nearer > self.standstill_ticks:
                raise StandstillError(self.who_waits_for_whom(course))
            legs = self._step_aside(course, query, legs)
        if len(legs):
            self._go(course, legs)
        elif self.rests(course):  # where a path goes on it asks again at its end
            self.run.after(RETRY_TICKS).callbacks.append(lambda _: self._ask_again(course))

    def _go(self, course: Course, legs: Rows) -> None:
        """Reserve a path, and see whether it leads into a line."""
        progress = self.progress_of[course.robot.id]
        rows, station = self.run.asker.apply(self.rule, lambda: self._commit(course, legs)), course.station
        if station is not None and course not in self.lines[station.id]:
            enters = rows[1][self._queues[station.id][rows[0]]]
            if len(enters):
                passing = (self.progress_of[other.robot.id] for other in self.lines[station.id])
                progress.entry = max([int(enters[0]), *(other.entry for other in passing if other.passes)])
                insort(self.lines[station.id], course, key=lambda other: self.progress_of[other.robot.id].entry)

    def let_move_up(self, station: Station) -> None:
        """Let robots that rest in a line plan for their present positions."""
        for place, course in enumerate(self.lines[station.id]):
            if self.rests(course):
                if course.robot.cell == station.cells.slot(place + 1):
                    self._start_clocks(course)
                self._request(course)

    # Runs that are registered or refused

    def register(self, course: Course, to: int) -> tuple[Stop, Stop] | None:
        """Register a run, and return its start and end; when another is in its way, stop the robot instead."""
        start, robot = self.next_stop(course), course.robot.id
        progress, ways = self.progress_of[robot], self._ways_past(course.station, start.cell, to)
        progress.refused = self.gets_ahead(course, ways, planned=False) if ways else None
        self._run[0, 0] = to
        try:
            if progress.refused is None:
                _, end = self.registered.settle(robot, self.roads, start, self._run)
        except ReservedError as error:
            progress.refused = error.cell
        if progress.refused is not None:
            self.stop(course)
            return None
        progress.moved, progress.passes = end.start_tick, progress.passes or bool(ways)
        left, progress.leaves = progress.leaves, None
        if left is not None:
            self.lines[left.id].remove(course)
            self.let_move_up(left)
        return start, end

    def gets_ahead(self, course: Course, ways: Iterable[int], *, planned: bool) -> int | None:
        """First of the cells by which a robot would come into its lane, or pass others there, before one ahead of it.

        Those ahead have to end up nearer to the station than that: with what is planned, or with their runs alone.
        """

        def end(other: Course) -> int:
            return other.legs[-1][0] if planned and other.legs else self.next_stop(other).cell

        for cell in ways:
            assert course.station is not None
            slots, _ = self._slots[course.station.id]
            ahead = takewhile(lambda other: other is not course, self.lines[course.station.id])
            if any(end(other) not in slots[: slots.index(cell)] for other in ahead):
                return cell
        return None

    def _find_ways_past(self, station: Station | None, start: int, end: int) -> list[int]:
        """Cells of the lane to a station that a run between two cells enters by a shortcut or second entrance."""
        if station is None:
            return []
        behind, width = self._slots[station.id][1], self.roads.layout.width
        step = (1 if abs(end - start) < width else width) * (1 if end > start else -1)
        return [cell for cell in range(start + step, end + step, step) if behind.get(cell, cell - step) != cell - step]

    def stop(self, course: Course) -> None:
        """Take a robot's path from it: it stops where it stands or where its run ends, and plans anew.

        So does the robot that had reserved that cell, then the one that had reserved the cell where that one stops.
        A robot that has stopped has reserved its registered cells only, which no other overlaps: none stops twice.
        """
        stopping = [course]
        for each in stopping:
            occupied = self._drive(each)[0]
            losers = self.table.seize(each.robot.id, occupied)
            self._replace(each, NO_LEGS)
            self._lose_place(each)
            self._request(each)
            stopping += [self.courses[loser] for loser in sorted(losers) if self.courses[loser] not in stopping]

    def _lose_place(self, course: Course) -> None:
        """Take a robot that is not in the lane yet out of the line that its path led into."""
        station = course.station
        if station is None or course.joined or course not in self.lines[station.id]:
            return
        if self._outside(course, station):
            self.lines[station.id].remove(course)
            self.let_move_up(station)

    # Robots that cannot move

    def _has_stood_long(self, course: Course) -> bool:
        now = self.run.warehouse.now
        return self.rests(course) and now - self.progress_of[course.robot.id].moved >= PATIENCE_TICKS

    def _step_aside(self, course: Course, query: Query, legs: Rows) -> Rows:
        """Return a leg into a free cell next to a robot that has stood for long; else the legs that it has.

        Who stands in a line never leaves it so.
        """
        if self._has_stood_long(course) and not course.joined:
            for cell in self._steps(query, self._rng.permutation(4).tolist()):
                step = np.array([[cell, 0]])
                if self.table.is_free(query.robot, drive(self.roads, query, step)[0]):
                    return step
        return legs

    def _is_shut_in(self, query: Query) -> bool:
        """Whether a robot has stood for a while and others keep all cells next to it: no path leads anywhere then."""
        if query.start_tick - self.progress_of[query.robot].moved < RETRY_TICKS:
            return False
        for cell in self._steps(query, range(4)):
            last = self.table.reserved(cell)[-1:]
            if not any(who != query.robot and begin <= query.start_tick for who, begin, end in last if end >= FOREVER):
                return False
        return True

    def _ask_again(self, course: Course) -> None:
        if self.rests(course):
            self._request(course)

    def _steps(self, query: Query, headings: Iterable[int]) -> Iterator[int]:
        """Cells next to a robot that it may enter and get on from."""
        tracks = self.roads.tracks(query.goal, query.loaded)
        for heading in headings:
            beside = self.roads.layout.neighbour(query.cell, heading)
            if (
                beside is not None
                and self.roads.layout.may_step(query.cell, heading)
                and (tracks.passable[beside] or beside == query.goal)
                and tracks.times[beside, heading] < far(tracks.times)
            ):
                yield beside

    def who_waits_for_whom(self, course: Course) -> str:
        """Return the message of a run that ends because a robot got no farther."""
        sentences = [self.waits_for(other) for other in self.courses if other is course or self._stands(other)]
        now = self.run.warehouse.now
        since_s = to_seconds(now - self.progress_of[course.robot.id].nearer)
        return (
            f"The run stands still at {to_seconds(now):.3f} s: robot {course.robot.name} has come no nearer to its "
            f"goal for {since_s:.0f} s ({self.allowed}). {'; '.join(sentences)}. Paths were planned by "
            f'{self.rule.describe()}, which has no proof against deadlock; rules.pp = "sipp" has.'
        )

    def _stands(self, course: Course) -> bool:
        """Whether a robot wants to move and does not."""
        stands = course.under_way is None and course.robot.cell != self._target(course)
        return stands and self.run.warehouse.now - self.progress_of[course.robot.id].moved >= RETRY_TICKS

    def waits_for(self, course: Course) -> str:
        """Say where a robot is, and which cell of whose keeps it there."""
        robot, layout, now = course.robot, self.roads.layout, self.run.warehouse.now
        target = self._target(course)
        query = self._departure(course, target)
        cell, blocker = self.progress_of[robot.id].refused, None
        if cell is not None:
            blocker = self.registered.blocker(cell, now, owner=robot.id)
        if cell is None or blocker is None:
            cell = self.ahead(query)
            blocker = self.table.blocker(cell, now, owner=robot.id)
        whom = "nobody holds it" if blocker is None else f"which robot {self.run.warehouse.robots[blocker].name} has"
        return (
            f"robot {robot.name} at {layout.where(query.cell)} waits for {layout.where(cell)}, {whom}, "
            f"on its way to {layout.where(target)}"
        )

    def ahead(self, query: Query) -> int:
        """Cell that a robot would enter first."""
        travel = self.run.warehouse.travel
        heading = travel.heading(
            query.cell, travel.fastest_path(query.cell, query.heading, query.goal, query.loaded)[0].to
        )
        assert heading is not None
        ahead = self.roads.layout.neighbour(query.cell, heading)
        assert ahead is not None
        return ahead
