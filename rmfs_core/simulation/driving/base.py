"""What all ways of driving share."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any, Protocol

import numpy as np
import simpy
from attrs import frozen

from rmfs_core.decisions import Leg, Path
from rmfs_core.events import Event, RobotMoved
from rmfs_core.rules import BoundRule
from rmfs_core.simulation import checks
from rmfs_core.simulation.asking import Asker, instance_of
from rmfs_core.traffic.asking import Traffic
from rmfs_core.warehouse import Robot, Station, Warehouse, WarehouseView

Process = Generator[simpy.Event, Any, None]


class Driving(Protocol):
    """How robots get from place to place. Where the story of a run says "drive", one of these does it."""

    def place(self, robot: Robot, station: Station) -> None:
        """Take in a robot that stands in the line of a station from the start."""

    def to_location(self, robot: Robot, cell: int) -> Process:
        """Drive to a storage location."""

    def to_station(self, robot: Robot, station: Station) -> Process:
        """Drive to a station and wait in its line until the robot stands in front of the picker."""

    def left(self, station: Station) -> None:
        """Take note that the first in line was served; where it goes is said next."""


@frozen(eq=False)
class Surroundings:
    """What driving needs of a run.

    Parameters
    ----------
    env
        The clock.
    warehouse, view
        The warehouse, and what rules see of it.
    rule, rng
        The PP rule, and its random generator.
    asker
        Asks it.
    tell
        Called with each event.
    standstill_ticks
        How long a robot may be on its way.
    seed
        Of the run.
    """

    env: simpy.Environment
    warehouse: Warehouse
    view: WarehouseView
    rule: BoundRule
    rng: np.random.Generator
    asker: Asker
    tell: Callable[[Event], None]
    standstill_ticks: int
    seed: int

    def plan(self, robot: Robot, goal: int, traffic: Traffic | None = None) -> list[Leg]:
        """Ask the PP rule for a path, and check that the robot can drive it."""
        return self._checked(self._answer(robot, goal, traffic), robot, goal, traffic)

    def plan_if_possible(self, robot: Robot, goal: int, traffic: Traffic) -> list[Leg] | None:
        """Ask for a path that need not exist; None when the PP rule knows none."""
        answer = self._answer(robot, goal, traffic)
        return None if answer is None else self._checked(answer, robot, goal, traffic)

    def _answer(self, robot: Robot, goal: int, traffic: Traffic | None) -> object:
        answer, _ = self.asker.ask(
            self.rule, warehouse=self.view, robot=robot, goal=goal, traffic=traffic, rng=self.rng
        )
        return answer

    def _checked(self, answer: object, robot: Robot, goal: int, traffic: Traffic | None) -> list[Leg]:
        start = robot.cell if traffic is None else traffic.query.cell

        def check() -> list[Leg]:
            return checks.path(self.warehouse, robot, start, goal, instance_of(answer, Path).legs)

        return self.asker.apply(self.rule, check)

    def after(self, ticks: int) -> simpy.Event:
        """Event that happens so much later."""
        return self.env.timeout(ticks)

    def turn_and_run(self, robot: Robot, leg: Leg) -> tuple[int, int, int]:
        """Heading after a leg from where the robot stands, and the ticks of turn and run."""
        if leg.to == robot.cell:
            return robot.heading, 0, 0
        travel = self.warehouse.travel
        towards = travel.heading(robot.cell, leg.to)
        assert towards is not None
        run = travel.motion.run_ticks(travel.layout.distance(robot.cell, leg.to))
        return towards, travel.motion.turn_ticks(robot.heading, towards), run

    def arrive(self, robot: Robot, leg: Leg, heading: int, start: int, turn_ticks: int) -> None:
        """Put a robot where a leg ends, and tell it."""
        origin = robot.cell
        self.warehouse.move(robot, leg.to, heading)
        self.tell(
            RobotMoved(
                tick=self.warehouse.now,
                start_tick=start,
                robot=robot.id,
                origin=origin,
                to=leg.to,
                heading=heading,
                wait_ticks=leg.wait_ticks,
                turn_ticks=turn_ticks,
                distance_m=self.warehouse.travel.layout.distance(origin, leg.to),
                pod=robot.pod,
            )
        )
