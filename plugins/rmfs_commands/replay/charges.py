"""How full the robots' batteries are over a run: what `rmfs_commands.processes.battery.Battery` counts, as lines."""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections.abc import Sequence
from copy import copy

from attrs import define, field

from rmfs_commands.processes.battery import Battery
from rmfs_commands.processes.events import ChargerDown, ChargerUp
from rmfs_commands.trace import Trace
from rmfs_core.clock import to_ticks
from rmfs_core.entrypoints import process
from rmfs_core.events import Event, PodLifted, PodStored, RobotMoved
from rmfs_core.scenario import scenario_from_dict
from rmfs_core.scenario.model import BatterySection
from rmfs_core.world.travel import travel_on

WHOLE = 10_000
"""Value of a full battery."""


@define
class Line:
    """The charge of one robot: a straight line from each point to the next.

    Parameters
    ----------
    ticks, charges
        The points, in the order of time: full is `WHOLE`.
    """

    ticks: array[int] = field(factory=lambda: array("q", [0]))
    charges: array[int] = field(factory=lambda: array("q", [WHOLE]))

    def at(self, tick: int) -> float:
        """Return the charge at a time as a share."""
        if tick >= self.ticks[-1]:
            return self.charges[-1] / WHOLE
        last = bisect_right(self.ticks, tick)
        begin, end = self.ticks[last - 1 : last + 1]
        low, high = self.charges[last - 1 : last + 1]
        return (low + (high - low) * (tick - begin) / (end - begin)) / WHOLE

    def copy(self) -> Line:
        """Return a line that goes on by itself."""
        return Line(array("q", self.ticks), array("q", self.charges))


class Charges:
    """Takes the events of a run one at a time.

    Parameters
    ----------
    start
        The trace they belong to; its own events are not read. Where its scenario has no batteries, nothing is counted.
    """

    def __init__(self, start: Trace) -> None:
        self._lift = start.motion.lift_ticks
        self._chargers = {*start.layout.chargers}  # those in service
        self._turned: dict[int, list[tuple[int, bool]]] = {}  # by charger: when, and whether it works from then on
        self._now = 0
        self._lines: list[Line] = []
        self._batteries: list[Battery] = []
        self._charging: list[bool] = []
        if (start.scenario.get("robots") or {}).get("battery") is None:
            return
        scenario = scenario_from_dict(start.scenario, name="header of the trace")
        make = process("battery", "robots.battery")(scenario, travel_on(start.layout, start.motion))
        self._batteries = [make(lambda: self._now) for _ in start.robots]
        self._charging = [robot["cell"] in self._chargers for robot in start.robots]
        self._lines = [Line() for _ in start.robots]
        self._cells = [robot["cell"] for robot in start.robots]

    def add(self, event: Event) -> None:
        """Count what an event took out of a battery, or what a charger does from then on."""
        if self._lines and isinstance(event, ChargerDown | ChargerUp):
            works = isinstance(event, ChargerUp)
            (self._chargers.add if works else self._chargers.discard)(event.cell)
            self._turned.setdefault(event.cell, []).append((event.tick, works))
        if not self._lines or not isinstance(event, RobotMoved | PodLifted | PodStored):
            return
        self._now, robot = event.tick, event.robot
        section = self._batteries[robot].section
        if isinstance(event, RobotMoved):
            ticks, watts = event.tick - event.start_tick - event.wait_ticks, _driving(section, event)
        else:
            ticks, watts = self._lift, section.lifting_w
        self._stand(self._lines[robot], robot, event.tick - ticks)
        self._batteries[robot].work(ticks, watts, self._charging[robot])
        _put(self._lines[robot], event.tick, self._batteries[robot].joules / self._batteries[robot].capacity_j)
        if isinstance(event, RobotMoved):
            self._charging[robot], self._cells[robot] = event.to in self._chargers, event.to

    def lines(self, end: int) -> Sequence[Line]:
        """Return the charges of all robots up to a time; none without batteries."""
        found = [line.copy() for line in self._lines]
        known = [*map(copy, self._batteries)], [*self._charging]
        for robot, line in enumerate(found):
            self._stand(line, robot, end)
        self._batteries, self._charging = known
        return found

    def _stand(self, line: Line, robot: int, until: int) -> None:
        """Let a robot stand until a time, at a charger that may fail, or work again, in the meantime."""
        battery = self._batteries[robot]
        for tick, works in self._turned.get(self._cells[robot], ()):
            if battery.since < tick <= until:
                self._stand_alike(line, robot, tick)
                battery.joules, battery.since = battery.left_j(tick, self._charging[robot]), tick
                self._charging[robot] = works
        self._stand_alike(line, robot, until)

    def _stand_alike(self, line: Line, robot: int, until: int) -> None:
        """Let a robot stand; a battery gets full, or so low that the robot sleeps, and stays so."""
        battery, charging = self._batteries[robot], self._charging[robot]
        if until <= battery.since:
            return
        watts = battery.section.charging_w if charging else -battery.section.idle_w
        change = battery.capacity_j - battery.joules if charging else min(battery.low_j - battery.joules, 0.0)
        if watts and 0 <= (turning := to_ticks(change / watts)) < until - battery.since:
            tick = battery.since + turning
            _put(line, tick, battery.left_j(tick, charging) / battery.capacity_j)
        _put(line, until, battery.left_j(until, charging) / battery.capacity_j)


def _driving(section: BatterySection, event: RobotMoved) -> float:
    return section.empty_w if event.pod is None else section.loaded_w


def _put(line: Line, tick: int, charge: float) -> None:
    if tick > line.ticks[-1]:
        line.ticks.append(tick)
        line.charges.append(round(charge * WHOLE))
