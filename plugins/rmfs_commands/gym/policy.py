"""A policy as a rule: it decides by the features that a learner sees."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any

from attrs import define, field, validators

from rmfs_commands.gym.choices import Choice, PodChoices, of_locations, of_orders, of_robots
from rmfs_core import OrderAssignment, PodTrip, TaskAssignment, hookimpl, rule_helpers
from rmfs_core.warehouse import Pod, Station, WarehouseView
from rmfs_core.wording import shown_short

MOST_SHOWN = 10_000
"""Orders that POA may choose of: each has a row of features for every station."""

_send_pods: Any = rule_helpers.send_pods


@define
class PolicyRule:
    """Base of rules for POA, PPS, PR or TA that make one choice at a time, by features of the candidates.

    A subclass says in `choose` which slot is chosen, and in ``decides`` what it was trained for
    (``decides = (Role.PPS,)``). How choices follow one another is the same here as in the environment of `make`:

    POA
        One pair of order and station at a time, while any fits. Each is a decision of its own.
    PPS
        One pod at a time, until no request without a pod can be served or no robot can start. The station with the
        fewest inbound pods is next, then the one with most requests without a pod, then the lowest id.
    PR
        The storage location of the pod that leaves its station.
    TA
        The robot of one pod at a time, the longest waiting pod first.

    Parameters
    ----------
    orders_shown
        Of how many orders POA chooses: the oldest that fit anywhere.
    """

    orders_shown: int = field(
        default=50,
        kw_only=True,
        validator=[validators.ge(1), validators.le(MOST_SHOWN)],
        metadata={"doc": "Of how many orders POA chooses: the oldest that fit anywhere"},
    )

    def choose(self, choice: Choice) -> int:
        """Return the slot that is chosen, one that ``choice.mask`` allows."""
        raise NotImplementedError

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView) -> Sequence[OrderAssignment]:
        """Assign one order."""
        choice = of_orders(warehouse, self.orders_shown)
        if choice is None:
            return []
        order, station = self._chosen(choice)
        return [OrderAssignment(order.id, station.id)]

    @hookimpl
    def select_pods(self, warehouse: WarehouseView, max_fetches: int) -> Sequence[PodTrip]:
        """Send pods one after the other."""
        choices = PodChoices(warehouse)

        def one(station: Station, pods: Sequence[Pod], _wanted: object) -> Pod:
            pod: Pod = self._chosen(choices.among(station, pods))
            choices.take(station, pod)
            return pod

        trips: list[PodTrip] = _send_pods(warehouse, max_fetches, one)
        return trips

    @hookimpl
    def choose_storage_location(self, warehouse: WarehouseView, pod: Pod) -> int:
        """Choose one of the free storage locations."""
        cell: int = self._chosen(of_locations(warehouse, pod))
        return cell

    @hookimpl
    def assign_tasks(self, warehouse: WarehouseView) -> Sequence[TaskAssignment]:
        """Give the waiting pods to robots one after the other."""
        idle = list(warehouse.idle_robots)
        tasks = []
        for pod in warehouse.waiting_pods[: len(idle)]:
            robot = self._chosen(of_robots(warehouse, pod, idle))
            idle.remove(robot)
            tasks.append(TaskAssignment(robot.id, pod.id))
        return tasks

    def _chosen(self, choice: Choice) -> Any:
        """Return what the chosen slot stands for."""
        answer = self.choose(choice)
        try:
            return choice.options[operator.index(answer)]
        except (TypeError, KeyError):
            allowed = f"one of the {len(choice.options)} slots of {len(choice.mask)} that `mask` allows"
            raise ValueError(f"chose slot {shown_short(answer)}; expected {allowed}") from None
