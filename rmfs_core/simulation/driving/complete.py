"""Driving full paths: the scheme that cannot stand still.

The scheme
----------
Endpoints are the storage locations, the queue cells and the stations. At any time

1. each robot owns exactly one endpoint, which no other robot owns: the end of its path;
2. the table holds the whole path of each robot, and its end is held without end;
3. a robot's reservations are replaced all at once: the old endpoint is given up only with the new path away from it;
4. the robots of a station's line (those that stand in it or have taken a ticket for it) own its first cells, the
   station first, in the order of the line and without gaps; a robot takes its ticket, the cell behind the last one,
   when it has its pod and sets out;
5. a robot that leaves a station sets out for a storage location that PR chose and nobody owns, or for a ticket;
6. a robot with a pod crosses no storage location but its own start and goal. Aisles hold no endpoints, are strongly
   connected without them, and every storage location, queue entry and exit of a station touches them (the layout
   check refuses others).

Why no run stands still
-----------------------
*A path exists whenever one is asked for.* A robot asks from a state on its reserved path P (at rest, now or at the end
of the leg under way) for a path to an endpoint g that nobody owns. Let it follow P to its end e, which takes finite
time and hits nobody, because P is reserved; let it wait in e, which is held without end, until every other robot
rests at the end of its path. From then on only owned endpoints are occupied. If e is a storage location, it touches
the aisles; these hold no endpoint and lead to every aisle cell, and so to g if g is a storage location. If g is the
ticket behind a line, the queue cells behind it are owned by nobody (by 4), and the robot drives in from the entry. If e
is a queue cell and g lies before it in the same lane, the cells in between are owned by nobody: those of the line
ahead lie before g. If e is a station, its exit leads to the aisles. So a path exists that arrives, and after that g can
be held for ever: other reservations are finite in number and end, but for the endpoints. A planner that finds a path
whenever there is one among the moves *wait, turn, run straight, stop* answers.

*Nobody waits for ever for an endpoint.* Storage locations: a robot with a pod goes where no pod stands or comes to, a
robot without one where its pod stands. If an empty robot owns that location (it rests there, is idle, or has not yet
begun a task elsewhere), it is first given another location that nobody owns: there are more storage locations than
robots, and one exists; by the first argument it gets a path, and gives up the location with it. Robots that carry pods
own storage locations only as their goals, which PR chose when they were free of pods; nobody fetches a pod there
before it has been set down. Tickets: a robot lifts its pod only when fewer robots have claimed a place at the station
than it has cells; until then it rests in the storage location of its pod, which only it has to do with.

*The line moves.* The first in line owns the station cell. It arrives there in finite time, since its path is
finite; picking takes finite time; then it leaves by the first argument, and with its departure everyone behind gets the
cell ahead, by the same argument. So each claimed place is given up in finite time, and each task ends.

A run therefore ends with every order complete, if the decision rules decide it.

Sources: M. Cap, J. Vokrinek, A. Kleiner, Complete decentralized method for on-line multi-robot trajectory planning in
well-formed infrastructures, ICAPS 2015, https://doi.org/10.1609/icaps.v25i1.13696; H. Ma, J. Li, T. K. S. Kumar,
S. Koenig, Lifelong multi-agent path finding for online pickup and delivery tasks, AAMAS 2017.
"""

from __future__ import annotations

from rmfs_core.simulation.asking import ImpossibleError
from rmfs_core.simulation.driving.base import Process
from rmfs_core.simulation.driving.reserved import Course, ReservedDriving
from rmfs_core.warehouse import Robot, Station


class CompleteDriving(ReservedDriving):
    """For PP rules whose paths reach their goals, however far."""

    def to_location(self, robot: Robot, cell: int) -> Process:
        """Drive to a storage location; whoever rests there steps aside first."""
        course = self.courses[robot.id]
        self._clear(cell, robot)
        self._send(course, cell)
        self._move_up(self._leave_line(course))
        while robot.cell != cell or course.legs:
            yield course.arrived

    def to_station(self, robot: Robot, station: Station) -> Process:
        """Take the ticket behind the line, drive there, and move up until the robot stands in front of the picker."""
        course = self.courses[robot.id]
        line = self.lines[station.id]
        if course not in line:
            self._send(course, station.cells.slot(len(line)))
            self._move_up(self._leave_line(course))
            course.station = station
            line.append(course)
        while robot.cell != station.cell:
            yield course.arrived

    def _move_up(self, station: Station | None) -> None:
        """Give each robot in a line the cell behind the one ahead."""
        if station is not None:
            for place, course in enumerate(self.lines[station.id]):
                slot = station.cells.slot(place)
                if course.goal != slot:
                    self._send(course, slot)

    def _send(self, course: Course, goal: int) -> None:
        if goal == course.goal:
            return
        query = self._departure(course, goal)
        legs = self._ask(query)

        def commit() -> None:
            end = int(self._commit(course, query, legs).cells[-1])
            if end != goal:
                where = self.roads.layout.where
                raise ImpossibleError(
                    f"gave robot {course.robot.name} a path that ends at {where(end)}, not at its goal {where(goal)}"
                )

        self.run.asker.apply(self.run.rule, commit)
        self._own(course, goal)

    def _path_ended(self, course: Course) -> None:
        self._arrive(course)
