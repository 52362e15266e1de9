"""Driving full paths that are planned for all robots at once: the scheme of `complete`, asked in rounds.

Robots that are given goals at one tick are planned for together, and robots on their way may be given other paths to
their goals. 1 to 6 of the scheme hold before and after each round. A robot that has been made to arrive later as often
as there are robots, since it was given its goal, keeps its path: so each arrives.
"""

from __future__ import annotations

from collections.abc import Sequence

from rmfs_core.decisions import Path, Rows
from rmfs_core.simulation import checks
from rmfs_core.simulation.asking import ImpossibleError, instance_of
from rmfs_core.simulation.context import RunContext
from rmfs_core.simulation.driving.base import NO_LEGS, Process
from rmfs_core.warehouse import Station
from rmfs_traffic import FleetTraffic, Occupancy, Query
from rmfs_traffic.complete import CompleteDriving
from rmfs_traffic.reserved import Course


class FleetDriving(CompleteDriving):
    """For PP rules that plan for all robots that need a path at once."""

    hook = "plan_paths"

    def __init__(self, run: RunContext) -> None:
        super().__init__(run)
        self._asking: dict[int, Course] = {}
        self._put_off = [0] * len(self.courses)

    def _send(self, course: Course, goal: int) -> None:
        if goal == course.goal:
            return
        if course.robot.id in self._asking:  # a robot's first goal may be another's by now: in that order
            self._plan()
        if not self._asking:
            self.env.process(self._round())
        self.own(course, goal)
        self._put_off[course.robot.id] = 0
        self._asking[course.robot.id] = course

    def _round(self) -> Process:
        yield self.run.after(0)
        self._plan()

    def _plan(self) -> None:
        """Ask for the paths of all who have goals and no paths there, and reserve them."""
        asking, self._asking = self._asking, {}
        if not asking:
            return
        most = len(self.courses)
        others = [
            course
            for course in self.courses
            if course.legs and course.robot.id not in asking and self._put_off[course.robot.id] < most
        ]
        queries = [self._departure(course, course.goal) for course in (*asking.values(), *others)]
        answer = self._paths(queries, others)

        def commit() -> None:
            if (left := next((robot for robot in asking if robot not in answer), None)) is not None:
                raise ImpossibleError(f"left out robot {self.courses[left].robot.name}, which needs a path")
            planned = [query for query in queries if query.robot in answer]
            for query in planned:
                self.table.release(query.robot)
            for query in planned:
                course, before = self.courses[query.robot], self.courses[query.robot].arrives
                self._reach(course, query.goal, answer[query.robot])
                if query.robot not in asking and course.arrives > before:
                    self._put_off[query.robot] += 1

        self.run.asker.apply(self.rule, commit)

    def _paths(self, queries: Sequence[Query], others: Sequence[Course]) -> dict[int, Rows]:
        """Ask the rule, and check that the robots can drive what it answers."""
        under_way = {query.robot: held for query in queries if (held := self._held(self.courses[query.robot]))}
        reserved = {one.robot.id: Occupancy(*one.reserved) for one in others if one.reserved is not None}
        arrives = {course.robot.id: course.arrives for course in others}
        traffic = FleetTraffic(self.roads, self.table, under_way, reserved, arrives)
        answer, _ = self.run.ask(self.rule, queries=tuple(queries), traffic=traffic)
        asked = {query.robot: query for query in queries}

        def check() -> dict[int, Rows]:
            found = {}
            for robot, path in instance_of(answer, dict).items():
                if robot not in asked:
                    raise ImpossibleError(f"answered for {robot!r}, a robot that it was not asked for")
                start, goal = asked[robot].cell, asked[robot].goal
                given, whose = instance_of(path, Path), self.courses[robot].robot
                found[robot] = checks.path(self.run.warehouse, whose, start, goal, given)
            return found

        return self.run.asker.apply(self.rule, check)

    # Overtaking

    def _overtake(self, course: Course, station: Station) -> bool:
        self._plan()
        return super()._overtake(course, station)

    def _ask(self, query: Query, *, needed: bool = True) -> Rows:  # noqa: ARG002
        return self._paths([query], ()).get(query.robot, NO_LEGS)
