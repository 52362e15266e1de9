"""TA rule ``nearest-robot``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define

from rmfs_core import TaskAssignment, hookimpl

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView


@define
class NearestRobot:
    """Give each waiting pod, the longest waiting first, to the idle robot that reaches it first.

    That is the one with the shortest driving time without a pod, turns included; ties go to the lowest id.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8
    """

    @hookimpl
    def assign_tasks(self, warehouse: WarehouseView) -> Sequence[TaskAssignment]:
        """Pair waiting pods with the nearest idle robots."""
        idle = list(warehouse.idle_robots)
        tasks = []
        for pod in warehouse.waiting_pods[: len(idle)]:
            nearest = idle[0]
            if len(idle) > 1:
                stops = [(robot.cell, robot.heading) for robot in idle]
                nearest = idle[warehouse.travel.nearest(stops, pod.cell, loaded=False)]
            idle.remove(nearest)
            tasks.append(TaskAssignment(nearest.id, pod.id))
        return tasks
