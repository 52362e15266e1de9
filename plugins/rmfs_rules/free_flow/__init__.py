"""PP rule ``free-flow``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from attrs import define

from rmfs_core import Path, hookimpl

if TYPE_CHECKING:
    from rmfs_core.warehouse import Robot, WarehouseView


@define
class FreeFlow:
    """Drive the fastest path, as if there were no other robots.

    Acceleration, deceleration and turns count. Robots pass through each other, so the travel times are a lower bound on
    what any path planning can reach: a fast setting for studies of order and pod decisions.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8
    """

    @hookimpl
    def plan_path(self, warehouse: WarehouseView, robot: Robot, goal: int) -> Path:
        """Return the fastest path to the goal."""
        loaded = robot.pod is not None
        return Path(warehouse.travel.fastest_path(robot.cell, robot.heading, goal, loaded=loaded))
