"""TA rule ``assignment``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from attrs import define, validators
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from rmfs_core import TaskAssignment, hookimpl
from rmfs_core.clock import to_ticks
from rmfs_rules.helpers.parameters import NOT_NEGATIVE, parameter

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, Robot, WarehouseView

NEVER = 1e15
"""Cost of what must not be, above any sum of driving times."""


@define
class Assignment:
    """Give waiting pods to robots so that these drive least in all.

    Of the idle robots and the pods that have been waiting longest, as many as there are robots, all of the fewer get
    one of the others: the pairs with the lowest sum of driving times without a pod, turns included (the assignment
    problem, solved exactly).

    With ``defer_s`` a pod may be left to a robot that is about to be idle: each robot that brings a pod back to its
    place takes part, and costs defer_s more than its drive from where it stood last. A pod that is paired with
    such a robot waits. The one that has been waiting longest never does.

    References
    ----------
    H. W. Kuhn: The Hungarian method for the assignment problem. Naval Research Logistics Quarterly 2, 83-97, 1955.
    https://doi.org/10.1002/nav.3800020109
    """

    libraries: ClassVar[tuple[str, ...]] = ("scipy",)

    defer_s: float | None = parameter(
        None,
        validators.optional(NOT_NEGATIVE),
        "What a robot costs that has a pod to store yet, besides its drive; left out: no pod waits for one",
        "s",
    )

    @hookimpl
    def assign_tasks(self, warehouse: WarehouseView) -> Sequence[TaskAssignment]:
        """Pair waiting pods and idle robots."""
        robots = list(warehouse.idle_robots)
        idle = len(robots)
        if self.defer_s is not None:
            robots += [robot for robot in warehouse.robots if _about_to_be_idle(warehouse, robot)]
        pods = warehouse.waiting_pods[: len(robots)]
        if not pods:
            return []
        cost = _driving_times(warehouse, robots, pods)
        if self.defer_s is not None:
            cost[idle:] += to_ticks(self.defer_s)
            cost[idle:, 0] = NEVER
        pairs = zip(*(found.tolist() for found in linear_sum_assignment(cost)), strict=True)
        return [TaskAssignment(robots[robot].id, pods[pod].id) for robot, pod in pairs if robot < idle]


def _about_to_be_idle(warehouse: WarehouseView, robot: Robot) -> bool:
    """Whether a robot carries a pod that is bound for no station."""
    return robot.pod is not None and not warehouse.pods[robot.pod].bound_for


def _driving_times(warehouse: WarehouseView, robots: Sequence[Robot], pods: Sequence[Pod]) -> NDArray[np.float64]:
    """Return the driving times of robots without a pod to pods (ticks), shape (robots, pods)."""
    cells, headings = [robot.cell for robot in robots], [robot.heading for robot in robots]
    times = [warehouse.travel.times_to(pod.cell, False)[cells, headings] for pod in pods]
    return np.column_stack(times).astype(np.float64)
