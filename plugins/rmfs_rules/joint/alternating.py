"""Joint POA+PPS rule ``alternating``."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from attrs import define

from rmfs_core import JointDecision, hookimpl
from rmfs_rules.helpers import waiting_limit
from rmfs_rules.helpers.parameters import AT_LEAST_1, parameter
from rmfs_rules.joint.choosing import ByPeriods, Chosen, Period, Sent, unused_capacity_weight

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView

MOST_ROUNDS = 10
"""Times that orders and pods are chosen at most, by default."""


@define(kw_only=True)
class Alternating(ByPeriods):
    """Choose orders for pods and pods for orders in turn, each greedily, until that lowers the cost no more.

    Whole orders, without a solver. The cost is that of ``integrated``,

        visits + W_u * free slots,

    at a station that counts orders, a free slot times the items of the largest order.

    Orders for pods: again and again, the pair of order and station with the fewest missing lines for each slot that
    the order takes, of those where it fits; ties go to the oldest order, then to the station with the lowest load. A
    line is missing where the pods at, bound for or (from the second time on) sent to the station have too few items
    left, and no order before it made the SKU one that has to be brought.

    Pods for orders: again and again, the pair of pod and station with most items that the orders there want and no pod
    there has; ties go to a pod bound for no station, then to the nearest. Pods that the later ones make needless stay.

    It begins with orders for the pods that are at or bound for stations, and ends with the first pair of choices that
    does not cost less than the one before, which it takes.

    References
    ----------
    G. Jiao, M. Huang, Y. Song, H. Li, X. Wang: Online joint optimization of order picking process in robotic mobile
    fulfillment systems. Omega, 103374, 2025. https://doi.org/10.1016/j.omega.2025.103374 (orders and pods chosen
    greedily in turn; there with tasks of robots, and another objective)
    """

    rounds: int = parameter(MOST_ROUNDS, AT_LEAST_1, "Times that orders and pods are chosen at most")
    unused_capacity_weight: float = unused_capacity_weight()
    max_wait_s: float | None = waiting_limit()

    @hookimpl
    def assign_orders_and_pods(self, warehouse: WarehouseView) -> JointDecision:
        """Choose orders and pods in turn."""
        period = Period(warehouse, self.max_wait_s)
        *_, (cost, chosen, sent) = improving(period, self.rounds, self.unused_capacity_weight)
        return period.decision(chosen, sent, cost)


def improving(period: Period, rounds: int, weight: float) -> Iterator[tuple[float, Chosen, Sent]]:
    """Yield the choices one after another, with their cost: each costs less than the one before."""
    before, given = math.inf, Sent()
    for _ in range(rounds):
        chosen = period.filled(given)
        sent = period.pods_for(chosen)
        costs = period.cost(chosen, sent, weight)
        if costs >= before:
            return
        yield costs, chosen, sent
        if sent == given:  # the next choice would be the same
            return
        before, given = costs, sent
