"""Joint POA+PPS rule ``two-stage``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from attrs import define, validators

from rmfs_core import JointDecision, hookimpl
from rmfs_rules.helpers import waiting_limit
from rmfs_rules.helpers.late import late
from rmfs_rules.helpers.parameters import SHARE_ABOVE_0, parameter
from rmfs_rules.joint.choosing import ByPeriods, Period

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView


@define(kw_only=True)
class TwoStage(ByPeriods):
    """Send pods for some orders, then fill the stations with what these pods have.

    Whole orders, without a solver. First stage: while a station's load is below ``first_share`` of its capacity, it
    takes orders of the first stage. Again and again, of the orders that fit, the one that has fewest missing lines for
    each slot that it takes goes to the station where that is so; ties go to the oldest order, then to the lowest load.
    (Or the oldest order goes where fewest of its lines are missing.) A line is missing where the pods at or bound for
    the station have too few items left, and no order before it made the SKU one that has to be brought.

    Then pods are sent for these orders: again and again, the pair of pod and station with most items that the orders
    there want and no pod there has; ties go to a pod bound for no station, then to the one with most items that the
    backlog wants, then to the nearest. Pods that the later ones make needless stay.

    Second stage: no more pods are sent. Of the other orders that fit, oldest first, each goes to the station with the
    lowest load whose pods have all of it. While an order that has waited too long is left, there is no second stage.

    References
    ----------
    C. A. Valle, J. E. Beasley: A two stage approach for order and rack allocation with order backlog in a mobile rack
    environment. Annals of Operations Research 351, 167-201, 2025. https://doi.org/10.1007/s10479-024-06058-6 (the two
    stages, each solved exactly there; which orders the first one has to fulfil is given there)
    """

    first_share: float = parameter(
        0.75,
        SHARE_ABOVE_0,
        "Share of a station's capacity; with a load of that or more, it takes only orders for which no pod "
        "has to be sent",
    )
    first_orders: Literal["cheapest", "oldest"] = parameter(
        "cheapest",
        validators.in_(("cheapest", "oldest")),
        'Which orders go first in the first stage: "cheapest" (fewest missing lines for each slot) or "oldest"',
    )
    max_wait_s: float | None = waiting_limit()

    @hookimpl
    def assign_orders_and_pods(self, warehouse: WarehouseView) -> JointDecision:
        """Choose orders, pods for them, and more orders for the pods."""
        period = Period(warehouse, self.max_wait_s)
        until = np.array([self.first_share * station.capacity for station in warehouse.stations])
        first = period.filled([], oldest=self.first_orders == "oldest", until=until)
        sent = period.pods_for(first, by_worth=True)
        late_ones = {*late(warehouse, self.max_wait_s)}
        second = period.completed(first, sent) if late_ones <= {row for row, _ in first} else []
        return period.decision([*first, *second], sent)
