"""TA rule ``the-rule``."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING

from attrs import define

from rmfs import TaskAssignment, hookimpl

if TYPE_CHECKING:
    from rmfs.warehouse import Pod, Robot, WarehouseView


@define
class TheRule:
    """Pair idle robots and waiting pods, the pair with the shortest drive first.

    Ties go to the lower id of the robot, then of the pod. A pod that is far from every robot may have to wait long.
    """

    @hookimpl
    def assign_tasks(self, warehouse: WarehouseView) -> Sequence[TaskAssignment]:
        """Pair them until robots or pods run out."""

        def drive(pair: tuple[Robot, Pod]) -> tuple[int, int, int]:
            robot, pod = pair
            return warehouse.travel.ticks(robot.cell, robot.heading, pod.cell, loaded=False), robot.id, pod.id

        idle, waiting = list(warehouse.idle_robots), list(warehouse.waiting_pods)
        tasks = []
        while idle and waiting:
            robot, pod = min(product(idle, waiting), key=drive)
            idle.remove(robot)
            waiting.remove(pod)
            tasks.append(TaskAssignment(robot.id, pod.id))
        return tasks
