"""Failures, repairs and maintenance: when the seed and the timetables say, and nothing is begun in between."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Sequence
from typing import Any

from attrs import define

from rmfs_commands.instances.calendar import Calendar
from rmfs_commands.processes.events import ChargerDown, ChargerUp, RobotDown, RobotUp, StationDown, StationUp
from rmfs_commands.validation.case import Case, Handlers, seconds
from rmfs_commands.validation.state import State
from rmfs_commands.validation.tables import has_batteries
from rmfs_core.clock import TICKS_PER_S, to_ticks
from rmfs_core.events import (
    BundleStored,
    Event,
    ItemPicked,
    PodMoveDecided,
    PodStored,
    RobotRested,
    RobotSent,
    TaskAssigned,
)
from rmfs_core.randomness import keyed_stream
from rmfs_core.timetable import Timetable, read_spans
from rmfs_core.warehouse import Warehouse


@define
class _One:
    """A robot, station or charger.

    ``fails`` and ``repair`` are as drawn, ``up`` is the tick since which it works, ``free`` that since which it has no
    task (None while it has one), ``charges`` whether it may have charged for a while yet, ``out`` the time out of
    service under way or else the last one: from when until when it lasts; ``down`` whether it is under way.
    """

    name: str
    hours: Timetable
    fails: float = math.inf
    repair: int = 0
    up: int = 0
    free: int | None = 0
    charges: bool = False
    out: tuple[float, float] = (-1, -1)
    down: bool = False
    number: int = 0

    def due(self) -> tuple[float, bool]:
        """Return the tick at which it is to be out of service next, and whether that is planned."""
        if self.free is None:
            return math.inf, False
        since = max(self.up, self.free)
        planned = since if self.hours.at(since) else self.hours.next_change(since)
        fails = max(self.fails, since)
        return (fails, False) if planned is None or fails <= planned else (planned, True)


class OutageCheck:
    """All is out of service as the seed draws it, and robots as their maintenance is planned, in cells for that."""

    def __init__(self, case: Case, state: State) -> None:
        scenario, trace = case.trace.scenario, case.trace
        self.case, self.state, self.seed = case, state, int(scenario.get("seed", 1))
        robots, zero = scenario.get("robots", {}), Calendar(scenario.get("instance", {}).get("start")).time_of_day()
        given = robots.get("maintenance") or {}
        self.laws = {"robots": robots.get("failures"), "stations": scenario["stations"].get("outages")}
        self.laws["chargers"] = (robots.get("battery") or {}).get("charger_outages")
        hours = [Timetable(read_spans(given.get(str(i + 1), ())), zero) for i in range(len(trace.robots))]
        self.robots = [_One(case.robot(i), one) for i, one in enumerate(hours)]
        picking = len(trace.stations) - trace.layout.replenishing
        self.stations = [_One(case.station(i), Timetable(())) for i in range(picking)]
        self.cells = case.layout.chargers
        self.chargers = [_One(f"the charger at {case.where(cell)}", Timetable(())) for cell in self.cells]
        self.ones = {"robots": self.robots, "stations": self.stations, "chargers": self.chargers}
        for pod in trace.pods:
            if pod["robot"] is not None:
                self.robots[pod["robot"]].free = None
        for kind, ones in self.ones.items():
            for i in range(len(ones)):
                self._draw(kind, i)
        self.handlers: Handlers = {
            RobotDown: self.robot_goes,
            RobotUp: lambda event: self.comes("robots", event.robot, event),
            StationDown: lambda event: self.goes("stations", event.station, event, planned=False),
            StationUp: lambda event: self.comes("stations", event.station, event),
            ChargerDown: lambda event: self.charger(event, self.goes, planned=False),
            ChargerUp: lambda event: self.charger(event, self.comes),
            TaskAssigned: self.begins,
            PodMoveDecided: self.begins,
            RobotSent: self.sent,
            PodStored: self.ends,
            RobotRested: self.ends,
            ItemPicked: self.works,
            BundleStored: self.works,
        }

    def begin(self, warehouse: Warehouse, told: Sequence[Any] | None, charging: Container[int]) -> None:
        """Take note of when all fails next, and what is out of service, where a run begins in a state.

        None: that does not tell, so that all begins to work, or has failed, just now.
        """
        now, known = self.case.trace.began, {} if told is None else {(f"{one.of}s", one.id): one for one in told}
        busy = {robot.id for robot in warehouse.robots if robot.task is not None or robot.goal is not None}
        down = {"robots": {robot.id for robot in warehouse.robots if not robot.in_service}}
        down["stations"] = {station.id for station in warehouse.stations if not station.in_service}
        down["chargers"] = {i for i, cell in enumerate(self.cells) if cell not in warehouse.chargers}
        for kind, ones in self.ones.items():
            for i, one in enumerate(ones):
                one.up, kept = now, known.get((kind, i))
                if kept is None:
                    self._draw(kind, i)
                else:
                    one.number, one.repair = kept.number, to_ticks(kept.repair_s)
                    one.fails = math.inf if kept.fails_s is None else to_ticks(kept.fails_s)
                one.down = i in down[kind]
                if one.down:
                    ends = now + one.repair if kept is None else math.inf
                    one.out = now, to_ticks(kept.until_s) if kept is not None and kept.until_s is not None else ends
                if kind == "robots":
                    one.free, one.charges = None if i in busy else now, i in charging

    def charger(self, event: ChargerDown | ChargerUp, check: Callable[..., None], **more: bool) -> None:
        """Check that a charger fails, or is in service again, when it is due."""
        if event.cell in self.cells:
            check("chargers", self.cells.index(event.cell), event, **more)
        else:
            self.case.add("outage", event.tick, f"a charger fails at {self.case.where(event.cell)}, where none is")

    def robot_goes(self, event: RobotDown) -> None:
        """Check that a robot goes out of service when it is due, and in a maintenance cell that is free."""
        self.goes("robots", event.robot, event, planned=event.planned)
        if self.case.layout.maintenance and not has_batteries(self.case.trace):  # no event tells how low those are
            robot, free = self.state.robots[event.robot], self._free_cells(event.robot)
            if robot.cell not in self.case.layout.maintenance and free:
                what = f"{self.case.robot(event.robot)} is out of service at {self.case.where(robot.cell)}"
                self.case.add("outage", event.tick, f"{what}, but {self.case.where(free[0])} is free for that")

    def _free_cells(self, robot: int) -> list[int]:
        """Return the maintenance cells that are free for a robot."""
        taken = {cell for i, other in enumerate(self.state.robots) if i != robot for cell in (other.cell, other.sent)}
        return [cell for cell in self.case.layout.maintenance if cell not in taken]

    def sent(self, event: RobotSent) -> None:
        """Check that a robot which comes to a maintenance cell has failed or is to be maintained."""
        one, goes = self.robots[event.robot], event.cell in self.case.layout.maintenance
        if goes and one.due()[0] > event.tick:
            where = f"{self.case.robot(event.robot)} is sent to the maintenance cell at {self.case.where(event.cell)}"
            self.case.add("outage", event.tick, f"{where}, but nothing was due")
        self.begins(event)

    def _draw(self, kind: str, number: int) -> None:
        law, one = self.laws[kind], self.ones[kind][number]
        if law is not None:
            rng = keyed_stream(self.seed, f"failures of {kind}", number, one.number)
            works, repair = (max(round(rng.exponential(mean) * TICKS_PER_S), 1) for mean in _means(law))
            one.fails, one.repair = one.up + works, repair

    def goes(self, kind: str, number: int, event: Event, *, planned: bool) -> None:
        """Check that something goes out of service when it is due."""
        if number >= len(self.ones[kind]):
            self.case.add("outage", event.tick, f"{self.case.station(number)} fails, where no orders are picked")
            return
        one, why = self.ones[kind][number], "is maintained" if planned else "fails"
        tick, expected = one.due()
        agrees = planned == expected and event.tick == tick
        if one.charges:  # when it was charged, and so had nothing to do, nobody has told
            agrees = bool(one.hours.at(event.tick)) if planned else event.tick >= one.fails
        if one.down or not agrees:
            due = "nothing was due" if one.down or tick == math.inf else f"due: {_what(expected)} at {seconds(tick)}"
            self.case.add("outage", event.tick, f"{one.name} {why} from {seconds(event.tick)} on; {due}")
        until = (one.hours.next_change(event.tick) or math.inf) if planned else event.tick + one.repair
        one.down, one.out = True, (event.tick, until)

    def comes(self, kind: str, number: int, event: Event) -> None:
        """Check that something comes back when it is repaired."""
        if number >= len(self.ones[kind]):
            return
        one = self.ones[kind][number]
        if not one.down or event.tick != one.out[1]:
            due = f"expected at {seconds(one.out[1])}" if one.down else "it was not out of service"
            self.case.add("outage", event.tick, f"{one.name} is in service again from {seconds(event.tick)} on; {due}")
        one.down, one.up, one.number = False, event.tick, one.number + 1
        self._draw(kind, number)

    def begins(self, event: TaskAssigned | PodMoveDecided | RobotSent) -> None:
        """Check that a robot which gets something to do is in service."""
        one = self.robots[event.robot]
        if not one.charges and event.tick > self.case.trace.began:  # a state tells itself what was due before
            self._missed(one, event.tick)
        if one.down:
            self.case.add("out-of-service", event.tick, f"{one.name} gets a task, but is out of service")
        one.free, one.charges = None, False

    def ends(self, event: PodStored | RobotRested) -> None:
        """Note that a robot has nothing to do."""
        one = self.robots[event.robot]
        one.free = event.tick
        one.charges = event.cell in self.cells

    def works(self, event: ItemPicked | BundleStored) -> None:
        """Check that work at a station was not begun while that was out of service."""
        if event.station < len(self.stations):
            one = self.stations[event.station]
            if one.out[0] < event.start_tick < (math.inf if one.down else one.out[1]):
                what = f"{one.name} begins at {seconds(event.start_tick)}, while it is out of service"
                self.case.add("out-of-service", event.tick, f"work at {what}")

    def _missed(self, one: _One, tick: int) -> None:
        due, planned = one.due()
        if not one.down and due < tick:
            one.fails, one.hours = math.inf, Timetable(())  # say it once
            self.case.add("outage", tick, f"{one.name} works at {seconds(due)}; expected: {_what(planned)}")

    def at_end(self) -> None:
        """Check that whatever was due has been told."""
        end = self.case.trace.tick
        for one in (*self.robots, *self.stations, *self.chargers):
            if one.down and one.out[1] < end:
                self.case.add("outage", end, f"{one.name} is not in service again at {seconds(one.out[1])}")
            elif not one.charges:
                self._missed(one, end)


def _means(law: dict[str, float]) -> tuple[float, float]:
    """Return the means of working and of a repair in seconds."""
    return 3600 * law["mtbf_h"], law["mttr_s"]


def _what(planned: bool) -> str:
    return "maintenance" if planned else "a failure"
