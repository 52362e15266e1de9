"""PP rule ``the-rule``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from attrs import define, field, validators
from rmfs import Path, hookimpl

if TYPE_CHECKING:
    from rmfs.warehouse import Robot, WarehouseView


@define
class TheRule:
    """Drive the fastest path a few legs at a time, as if there were no other robots.

    Where a path ends before the goal the rule is asked again: that is where to plan anew.

    Parameters
    ----------
    max_legs
        How many straight runs to plan at a time.
    """

    max_legs: int = field(default=3, validator=validators.ge(1))

    @hookimpl
    def plan_path(self, warehouse: WarehouseView, robot: Robot, goal: int) -> Path:
        """Return the first legs of the fastest path to the goal."""
        loaded = robot.pod is not None
        legs = warehouse.travel.fastest_path(robot.cell, robot.heading, goal, loaded=loaded)
        return Path(legs[: self.max_legs])
