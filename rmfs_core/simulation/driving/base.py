"""Contract of the ways of driving, and the code that all of them share.

A PP rule says by its attribute ``reserves`` which way it plans for: the name of an entry point in the group
``rmfs.driving``, which leads to a subclass of `Driving`. Without it, robots drive as in `free`.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Any, ClassVar

import simpy

from rmfs_core.clock import to_seconds, to_ticks
from rmfs_core.decisions import Path, Rows, ends_of
from rmfs_core.errors import StandstillError
from rmfs_core.events import RobotMoved
from rmfs_core.simulation import checks
from rmfs_core.simulation.asking import instance_of
from rmfs_core.simulation.context import RunContext
from rmfs_core.simulation.going import Going
from rmfs_core.warehouse import Robot, Station
from rmfs_core.world.travel import Travel

Process = Generator[simpy.Event, Any, None]
NO_LEGS = ends_of(())
CROSSINGS = 10
"""How many crossings of the layout, in time, a robot may wait for others before it counts as standing still."""


class Driving:
    """How robots drive. Where the story of a run says "drive", one of its subclasses does it.

    Parameters
    ----------
    run
        The run.

    Attributes
    ----------
    rule
        The PP rule.
    standstill_ticks
        How long a robot may come no nearer to its goal: ``run.standstill_s``, or `CROSSINGS` if they take longer.
    allowed
        The same in words, for messages.
    """

    hook: ClassVar[str] = "plan_path"
    """The hook of the PP rule that it asks: one of ``Role.PP.hooks``."""

    @classmethod
    def prepare_with(cls, travel: Travel) -> Any:
        """Return what the PP rule's `prepare` is handed: the travel times, or what the way makes of them."""
        return travel

    def __init__(self, run: RunContext) -> None:
        self.run = run
        self.rule = run.rules.pp
        travel = run.warehouse.travel
        self._width = travel.layout.width
        self.turns, self._runs = travel.turns.tolist(), travel.runs.tolist()
        crossing = self._runs[self._width] + self._runs[travel.layout.height] + 2 * self.turns[2]
        self.standstill_ticks = max(to_ticks(run.scenario.run.standstill_s), CROSSINGS * crossing)
        self.allowed = f"longer than run.standstill_s and than {CROSSINGS} crossings of the layout take"
        self._on_leg = [Going("leg", robot.id) for robot in run.warehouse.robots]
        self.under_way: dict[int, tuple[Robot, int, int, int, int, int]] = {}
        """By robot, what `arrive` is called with at the end of its leg."""
        self.standing: list[list[Robot]] = [[] for _ in run.warehouse.stations]  # that wait until the line moves

    def begin(self) -> None:
        """Let robots begin, or go on, on their own."""

    # What each way does for the story

    def place(self, robot: Robot, station: Station) -> None:
        """Take in a robot that stands in the line of a station from the start."""

    def to_location(self, robot: Robot, cell: int) -> Process:
        """Drive to a storage location."""
        raise NotImplementedError

    def to_station(self, robot: Robot, station: Station) -> Process:
        """Drive to a station and wait in its line until the robot stands in front of the picker."""
        raise NotImplementedError

    def left(self, station: Station) -> None:
        """Take note that the first in line was served; where it goes is said next."""

    # What they share

    def path(
        self, robot: Robot, goal: int, traffic: Any = None, start: int | None = None, *, needed: bool = True
    ) -> Rows:
        """Ask the PP rule for a path, and check that the robot can drive it; no legs where it need not know any.

        It begins in the cell ``start``, if not where the robot is, and is an array with end and wait of each leg, as
        `rmfs_core.decisions.ends_of` makes it. ``traffic`` is what the way hands the rule.
        """
        answer, _ = self.run.ask(self.rule, robot=robot, goal=goal, traffic=traffic)
        if answer is None and not needed:
            return NO_LEGS

        def check() -> Rows:
            begin = robot.cell if start is None else start
            return checks.path(self.run.warehouse, robot, begin, goal, instance_of(answer, Path))

        return self.run.asker.apply(self.rule, check)

    def turn_and_run(self, robot: Robot, to: int) -> tuple[int, int, int]:
        """Heading after a leg from where the robot stands, and the ticks of turn and run."""
        if to == robot.cell:
            return robot.heading, 0, 0
        travel = self.run.warehouse.travel
        towards = travel.heading(robot.cell, to)
        assert towards is not None
        turn = self.turns[(towards - robot.heading) % 4]
        return towards, turn, self._runs[travel.layout.distance(robot.cell, to)]

    def set_off(
        self, robot: Robot, to: int, wait: int, heading: int, start: int, turn_ticks: int, arrival: int
    ) -> simpy.Event:
        """Let a robot be on a leg that began at ``start``; return what happens when it is to `arrive`."""
        self.under_way[robot.id] = robot, to, wait, heading, start, turn_ticks
        return self.run.after(arrival - self.run.warehouse.now, self._on_leg[robot.id])

    def cut_off(self) -> None:
        """Put robots under way in the last cells whose centres they have passed: the run is over."""
        motion, layout = self.run.warehouse.travel.motion, self.run.warehouse.travel.layout
        for robot, to, wait, heading, start, turn_ticks in self.under_way.values():
            driven = self.run.warehouse.now - start - wait - turn_ticks
            whole = layout.distance(robot.cell, to)
            metres = int(motion.position_m(whole, to_seconds(driven))) if driven > 0 else 0
            if metres:
                passed = robot.cell + (to - robot.cell) // whole * metres
                self.arrive(robot, passed, wait, heading, start, turn_ticks)

    def arrive(self, robot: Robot, to: int, wait: int, heading: int, start: int, turn_ticks: int) -> None:
        origin, warehouse, width = robot.cell, self.run.warehouse, self._width
        apart, now = abs(to - origin), warehouse.now
        metres = apart if apart < width else apart // width
        warehouse.move(robot, to, heading, now - start - wait)
        if (charge := robot.charge) is not None and charge < 0:
            where = f"{self.run.warehouse.travel.layout.where(to)}, at {to_seconds(now):.3f} s"
            spent = "its ways took more than `robots.battery.detour` times what they take without other robots"
            raise StandstillError(f"Robot {robot.name} has no charge left in {where}: {spent}.")
        self.run.tell(RobotMoved(now, start, robot.id, origin, to, heading, wait, turn_ticks, metres, robot.pod))
