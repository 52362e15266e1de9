"""Joint POA+PPS rule ``two-stage``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from attrs import define, field, validators

from rmfs_core import JointDecision, hookimpl
from rmfs_joint.choosing import NOT_NOW, Chosen, Integers, Left, Sent, placed, waiting_too_long
from rmfs_joint.covering import decision, pods_for, serve
from rmfs_rule_helpers import assign_best_pairs, waiting_limit

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView


@define(kw_only=True)
class TwoStage:
    """Send pods for some orders, then fill the stations with what these pods have.

    Whole orders, without a solver. First stage: while a station's load is below ``first_share`` of its capacity, it
    takes orders of the first stage. Again and again, of the orders that fit, the one that has fewest missing lines for
    each place that it takes goes to the station where that is so; ties go to the oldest order, then to the lowest load.
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

    whole_orders: ClassVar[bool] = True

    first_share: float = field(
        default=0.75,
        validator=validators.and_(validators.gt(0), validators.le(1)),
        metadata={
            "doc": "Share of a station's capacity; with a load of that or more, it takes only orders for which no pod "
            "has to be sent"
        },
    )
    first_orders: Literal["cheapest", "oldest"] = field(
        default="cheapest",
        validator=validators.in_(("cheapest", "oldest")),
        metadata={
            "doc": 'Which orders go first in the first stage: "cheapest" (fewest missing lines for each place) or '
            '"oldest"'
        },
    )
    max_wait_s: float | None = waiting_limit()

    @hookimpl
    def assign_orders_and_pods(self, warehouse: WarehouseView) -> JointDecision:
        """Choose orders, pods for them, and more orders for the pods."""
        first = self.first(warehouse)
        sent = pods_for(warehouse, first, _wanted_on(warehouse))
        return decision(warehouse, [*first, *self.second(warehouse, first, sent)], sent)

    def first(self, warehouse: WarehouseView) -> Chosen:
        """Return the orders of the first stage."""
        left, load = Left(warehouse), {station.id: station.load for station in warehouse.stations}
        youngest_last = np.arange(len(warehouse.backlog))[::-1] * (left.most_lines + 1)

        def score(station: Station) -> Integers:
            if load[station.id] >= self.first_share * station.capacity:
                return np.full(len(youngest_last), NOT_NOW)
            if self.first_orders == "cheapest":
                return left.score(station)
            return np.where(left.in_stock(), youngest_last + left.most_lines - left.missing(station), NOT_NOW)

        def take(station: Station, position: int) -> Iterable[int]:
            load[station.id] += warehouse.size_at(warehouse.backlog[position], station)
            return left.take(station, position)

        pairs = assign_best_pairs(warehouse, score, take, max_wait_s=self.max_wait_s)
        return placed(warehouse, pairs)

    def second(self, warehouse: WarehouseView, first: Chosen, sent: Sent) -> Chosen:
        """Return the orders of the second stage."""
        chosen, taken = list(first), {position for position, _ in first}
        if waiting_too_long(warehouse, self.max_wait_s) - taken:
            return []
        free = {station.id: station.free_capacity for station in warehouse.stations}
        for position, at in first:
            free[at] -= warehouse.size_at(warehouse.backlog[position], warehouse.stations[at])
        left = Left(warehouse, sent)
        complete = np.column_stack([left.missing(station) == 0 for station in warehouse.stations])
        for position in np.flatnonzero(complete.any(axis=1)).tolist():
            if position in taken:
                continue
            for station in sorted(warehouse.stations, key=lambda at: (at.capacity - free[at.id], at.id)):
                size = warehouse.size_at(warehouse.backlog[position], station)
                further = [*chosen, (position, station.id)]
                if complete[position, station.id] and size <= free[station.id] and serve(warehouse, further, sent):
                    free[station.id] -= size
                    chosen = further
                    break
            if not any(free.values()):
                break
        return chosen[len(first) :]


def _wanted_on(warehouse: WarehouseView) -> Integers:
    """Return how many items on each pod the backlog wants."""
    lines, free = warehouse.backlog_lines, warehouse.free_items
    demand = np.bincount(lines.sku, weights=lines.quantity, minlength=warehouse.n_skus)
    wanted = np.minimum(free.number, demand[free.sku])
    return np.bincount(free.pod, weights=wanted, minlength=len(warehouse.pods)).astype(np.int64)
