"""Driving full paths: the scheme that cannot stand still.

The scheme
----------
Endpoints are the storage locations, the queue cells and the stations. At any time

1. each robot owns exactly one endpoint, which no other robot owns: the end of its path;
2. the table holds the whole path of each robot, and its end is held without end;
3. a robot's reservations are replaced all at once: the old endpoint is given up only with the new path away from it;
4. the robots of a station's line (those that stand in it or have taken a ticket for it) own its first positions, the
   station first, in the order of the line and without gaps; a robot takes its ticket, the cell behind the last one,
   when it has its pod and sets out, and may then overtake (below). Every step in a lane leads ahead, shortcuts too;
5. a robot that leaves a station sets out for a storage location that PR chose and nobody owns, or for a ticket;
6. a robot with a pod crosses no storage location but its own start and goal. Aisles hold no endpoints, are strongly
   connected without them, and every storage location, queue entry and exit of a station touches them (the layout
   check refuses others).

Overtaking
----------
Tickets are taken in the order of departure, and who departs first need not come first. So the robot that has just taken
a ticket changes positions with the one ahead, and then with the next one, as long as all of this holds: neither is in
the lane of the station, nor on a leg that ends there; among the reservations of all others, and those for the legs that
the two have under way, there is a path to the position ahead that arrives before the other robot would, and with it one
for the other robot to the position behind; and that robot has been overtaken less often, since it took its ticket, than
the queue has cells. Both paths, both endpoints and both positions in line are then replaced at once.
Otherwise the table gets back what it had. No simulated time passes in between: at all times that other arguments speak
of, 1 to 6 hold, since the two have exchanged the endpoints that they owned, and each has a whole path to its own.

Why no run stands still is argued from 1 to 6 in the documentation, docs/explanation/traffic.md.

Sources: M. Cap, J. Vokrinek, A. Kleiner, Complete decentralized method for on-line multi-robot trajectory planning in
well-formed infrastructures, ICAPS 2015, https://doi.org/10.1609/icaps.v25i1.13696; H. Ma, J. Li, T. K. S. Kumar,
S. Koenig, Lifelong multi-agent path finding for online pickup and delivery tasks, AAMAS 2017.
"""

from __future__ import annotations

from attrs import evolve

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.decisions import Rows
from rmfs_core.simulation.asking import ImpossibleError
from rmfs_core.simulation.driving.base import NO_LEGS, Process
from rmfs_core.warehouse import Robot, Station
from rmfs_traffic import Occupancy, Query
from rmfs_traffic.reserved import Course, ReservedDriving


class CompleteDriving(ReservedDriving):
    """For PP rules whose paths reach their goals, however far."""

    def to_station(self, robot: Robot, station: Station) -> Process:
        """Take the ticket behind the line, drive there, and move up until the robot stands in front of the picker."""
        course = self.courses[robot.id]
        line = self.lines[station.id]
        if course not in line:
            while len(line) > station.cells.places:  # with robots that began there, and leave
                yield self.run.after(TICKS_PER_S)
            self._send(course, station.cells.slot(len(line)))
            self._move_up(self.leave_line(course))
            course.station, course.overtaken = station, 0
            line.append(course)
            while self._overtake(course, station):
                pass
        while robot.cell != station.cell:
            yield course.arrived

    def set_out_for(self, course: Course, cell: int) -> None:
        """Send a robot to a storage location that nobody else owns."""
        self._send(course, cell)
        self._move_up(self.leave_line(course))

    def _move_up(self, station: Station | None) -> None:
        """Give each robot in a line the cell behind the one ahead."""
        if station is not None:
            for place, course in enumerate(self.lines[station.id]):
                slot = station.cells.slot(place)
                if course.goal != slot:
                    self._send(course, slot)

    # Overtaking

    def _overtake(self, course: Course, station: Station) -> bool:
        """Let a robot change positions with the one ahead in line if it comes first; return whether it did."""
        line = self.lines[station.id]
        place = line.index(course)
        if place == 0:
            return False
        ahead = line[place - 1]
        if ahead.overtaken >= station.cells.places:
            return False
        if not (self._outside(course, station) and self._outside(ahead, station)):
            return False
        first, second = self._departure(course, ahead.goal), self._departure(ahead, course.goal)
        paths = self.both(course, first, ahead, second)
        if paths is None:
            return False
        self._commit(course, paths[0])
        self._commit(ahead, paths[1])
        line[place - 1 : place + 1] = [course, ahead]
        for each, goal in ((course, first.goal), (ahead, second.goal)):
            self.owner[goal], each.goal = each, goal
        ahead.overtaken += 1
        return True

    def both(self, course: Course, first: Query, ahead: Course, second: Query) -> tuple[Rows, Rows] | None:
        """Return paths by which a robot gets the position of the one ahead before that one would, and that one behind.

        None when there are none. The table has what the two need only for the legs under way if there are, and what
        they had before if there are none.
        """
        before = [(each.robot.id, each.reserved) for each in (course, ahead)]
        for each in (course, ahead):
            self._give_up(each)
        legs = self._legs(course, evolve(first, latest=ahead.arrives))
        if len(legs):
            self.table.commit(course.robot.id, self._drive(course, legs)[0])
            others = self._legs(ahead, second)
            if len(others):
                self.table.release(ahead.robot.id)
                return legs, others
        for robot, _ in before:
            self.table.release(robot)
        for robot, reserved in before:
            assert reserved is not None
            self.table.add(robot, Occupancy(*reserved))
        return None

    def _give_up(self, course: Course) -> None:
        """Release what a robot has reserved except for its leg under way."""
        self.table.release(course.robot.id)
        if (held := self._held(course)) is not None:
            self.table.add(course.robot.id, held)

    def _held(self, course: Course) -> Occupancy | None:
        """Cells that a robot occupies until the end of its leg under way."""
        if course.under_way is None:
            return None
        occupied = self._drive(course)[0]
        occupied.until[-1] = course.under_way[1].start_tick
        return occupied

    def _legs(self, course: Course, query: Query) -> Rows:
        """Ask for a path that hits no reservation and is at its goal early enough; no legs without one."""
        legs = self._ask(query, needed=False)
        occupied, end = self._drive(course, legs)
        fits = self.table.is_free(course.robot.id, occupied)
        return legs if fits and end.cell == query.goal and end.start_tick < query.latest else NO_LEGS

    def _send(self, course: Course, goal: int) -> None:
        if goal == course.goal:
            return
        legs = self._ask(self._departure(course, goal))
        self.run.asker.apply(self.rule, lambda: self._reach(course, goal, legs))
        self.own(course, goal)

    def _reach(self, course: Course, goal: int, legs: Rows) -> None:
        """Reserve a path that has to end at a goal."""
        end = int(self._commit(course, legs)[0, -1])
        if end != goal:
            where = self.roads.layout.where
            raise ImpossibleError(
                f"gave robot {course.robot.name} a path that ends at {where(end)}, not at its goal {where(goal)}"
            )

    def _path_ended(self, course: Course) -> None:
        self._arrive(course)
