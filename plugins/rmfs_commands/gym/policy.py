"""A policy as a rule: it decides by the features that a learner sees."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any, ClassVar

from attrs import define, field, validators

from rmfs_commands.gym.choices import Choice, Feature, PodChoices, Table, of_locations, of_orders, of_robots
from rmfs_commands.gym.covering import of_orders_and_pods
from rmfs_core import JointDecision, OrderAssignment, PodTrip, TaskAssignment, hookimpl, rule_helpers
from rmfs_core.warehouse import Pod, Station, WarehouseView
from rmfs_core.wording import shown_short

MOST_SHOWN = 10_000
"""Orders that POA may choose of: each has a row of features for every station."""

MOST_WAYS = 100
"""Ways to serve an order at a station that POA+PPS may choose of."""

_send_pods: Any = rule_helpers.send_pods


@define
class PolicyRule:
    """Base of rules for POA, PPS, POA+PPS, PR or TA that make one choice at a time, by features of the candidates.

    A subclass says in `choose` which slot is chosen, in ``decides`` what it was trained for (``decides =
    (Role.PPS,)``), and in ``features`` which features of its own there are besides `FEATURES`. How choices follow one
    another is the same here as in the environment of `make`:

    POA
        One pair of order and station at a time, while any fits. Each is a decision of its own.
    PPS
        One pod at a time, until no request without a pod can be served or no robot can start. The station with the
        fewest inbound pods is next, then the one with most requests without a pod, then the lowest id.
    POA+PPS
        One order at a time with its station and the pods that it needs there, while any fits. Each is a decision of
        its own.
    PR
        The storage location of the pod that leaves its station.
    TA
        The robot of one pod at a time, the longest waiting pod first.

    Where it may wait, the last slot decides nothing: POA and POA+PPS end there until something changes, the station
    gets no pod (PPS), the pod no robot (TA) in this round.

    Parameters
    ----------
    orders_shown
        Of how many orders POA and POA+PPS choose: the oldest that fit anywhere.
    pods_shown
        In how many ways POA+PPS can serve an order at a station.
    may_wait
        Whether a slot stands for waiting. It may be chosen while some robot has a task: then another decision comes.
    """

    features: ClassVar[tuple[Feature, ...]] = ()
    whole_orders: ClassVar[bool] = True

    orders_shown: int = field(
        default=50,
        kw_only=True,
        validator=[validators.ge(1), validators.le(MOST_SHOWN)],
        metadata={"doc": "Of how many orders POA and POA+PPS choose: the oldest that fit anywhere"},
    )
    pods_shown: int = field(
        default=3,
        kw_only=True,
        validator=[validators.ge(1), validators.le(MOST_WAYS)],
        metadata={"doc": "In how many ways POA+PPS can serve an order at a station, each with another pod first"},
    )
    may_wait: bool = field(
        default=False,
        kw_only=True,
        metadata={"doc": "Whether a slot stands for waiting, where the decision allows it"},
    )

    @property
    def table(self) -> Table:
        """How choices are shown."""
        return Table(self.orders_shown, self.pods_shown, self.may_wait, self.features)

    def choose(self, choice: Choice) -> int:
        """Return the slot that is chosen, one that ``choice.mask`` allows."""
        raise NotImplementedError

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView) -> Sequence[OrderAssignment]:
        """Assign one order."""
        choice = of_orders(warehouse, self.table)
        if choice is None or (chosen := self._chosen(choice)) is None:
            return []
        order, station = chosen
        return [OrderAssignment(order.id, station.id)]

    @hookimpl
    def select_pods(self, warehouse: WarehouseView, max_fetches: int) -> Sequence[PodTrip]:
        """Send pods one after the other."""
        choices = PodChoices(warehouse, self.table)

        def one(station: Station, pods: Sequence[Pod], _wanted: object) -> Pod | None:
            pod: Pod | None = self._chosen(choices.among(station, pods))
            if pod is not None:
                choices.take(station, pod)
            return pod

        trips: list[PodTrip] = _send_pods(warehouse, max_fetches, one)
        return trips

    @hookimpl
    def assign_orders_and_pods(self, warehouse: WarehouseView) -> JointDecision:
        """Assign one order, and send the pods that it needs."""
        choice = of_orders_and_pods(warehouse, self.table)
        if choice is None or (chosen := self._chosen(choice)) is None:
            return JointDecision()
        order, station, pods = chosen
        return JointDecision([OrderAssignment(order.id, station.id)], [PodTrip(pod.id, station.id) for pod in pods])

    @hookimpl
    def choose_storage_location(self, warehouse: WarehouseView, pod: Pod) -> int:
        """Choose one of the free storage locations."""
        cell: int = self._chosen(of_locations(warehouse, pod, self.table))
        return cell

    @hookimpl
    def assign_tasks(self, warehouse: WarehouseView) -> Sequence[TaskAssignment]:
        """Give the waiting pods to robots one after the other."""
        idle = list(warehouse.idle_robots)
        tasks = []
        for pod in warehouse.waiting_pods:
            if not idle:
                break
            robot = self._chosen(of_robots(warehouse, pod, idle, self.table))
            if robot is not None:
                idle.remove(robot)
                tasks.append(TaskAssignment(robot.id, pod.id))
        return tasks

    def _chosen(self, choice: Choice) -> Any:
        """Return what the chosen slot stands for, None for waiting."""
        answer = self.choose(choice)
        try:
            return choice.options[operator.index(answer)]
        except (TypeError, KeyError):
            allowed = f"one of the {len(choice.options)} slots of {len(choice.mask)} that `mask` allows"
            raise ValueError(f"chose slot {shown_short(answer)}; expected {allowed}") from None
