"""Joint POA+PPS rule ``lns``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from attrs import define

from rmfs_core import JointDecision, hookimpl
from rmfs_rules.helpers import waiting_limit
from rmfs_rules.helpers.late import late
from rmfs_rules.helpers.parameters import NOT_NEGATIVE, SHARE_ABOVE_0, parameter
from rmfs_rules.joint.alternating import MOST_ROUNDS, improving
from rmfs_rules.joint.choosing import ByPeriods, Chosen, Period, Sent, unused_capacity_weight
from rmfs_rules.joint.order_search import SCALE, fill

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView

MOST_ORDERS = 500
"""Orders of the backlog that a search looks at, besides chosen ones."""
HALF_A_LINE = SCALE // 2
"""Random part of the lines that an order lacks is below that."""


@define(kw_only=True)
class LargeNeighborhoodSearch(ByPeriods):
    """Take back some of the orders that were chosen, choose again, and keep what costs less: large neighborhood search.

    Whole orders, without a solver. It begins with the choice of ``alternating``, and its cost is that of
    ``integrated``,

        visits + W_u * free slots,

    at a station that counts orders, a free slot times the items of the largest order. Each of the iterations takes
    orders back, one of three ways, drawn at random: each with the probability ``share``; all that want something of one
    pod that is sent, at its station; or all of one station. Then orders are added as ``alternating`` does, given the
    pods that the others need, by scores from which up to half a missing line is taken at random, and pods are chosen
    for all of them. The outcome is kept if it costs less, or as much and its orders are older: of the orders by which
    two such outcomes differ, it has the oldest.

    Where more than 500 orders wait, it looks at chosen orders and at no more than 500 others: as many for each
    station with free slots, the orders that ``alternating`` would take there first, given the pods that it sends.

    Orders that have waited too long are not taken back; while one is left in the backlog, it stays with the choice of
    ``alternating``.

    References
    ----------
    P. Shaw: Using constraint programming and local search methods to solve vehicle routing problems. CP98, Lecture
    Notes in Computer Science 1520, 417-431, 1998. https://doi.org/10.1007/3-540-49481-2_30 (large neighborhood search)

    S. Ropke, D. Pisinger: An adaptive large neighborhood search heuristic for the pickup and delivery problem with time
    windows. Transportation Science 40, 455-472, 2006. https://doi.org/10.1287/trsc.1050.0135 (several ways of taking
    back, and greedy repair with random noise)
    """

    iterations: int = parameter(50, NOT_NEGATIVE, "Times that orders are taken back and chosen again in a decision")
    share: float = parameter(
        0.3, SHARE_ABOVE_0, "With which probability an order is taken back when orders are drawn one by one"
    )
    unused_capacity_weight: float = unused_capacity_weight()
    max_wait_s: float | None = waiting_limit()

    @hookimpl
    def assign_orders_and_pods(self, warehouse: WarehouseView, rng: np.random.Generator) -> JointDecision:
        """Improve the choice of ``alternating``."""
        weight, period = self.unused_capacity_weight, Period(warehouse, self.max_wait_s)
        *_, (cost, chosen, sent) = improving(period, MOST_ROUNDS, weight)
        rows, stay = {row for row, _ in chosen}, {*late(warehouse, self.max_wait_s)}
        if not chosen or not stay <= rows:
            return period.decision(chosen, sent, cost)
        shown, best = period.foremost(MOST_ORDERS, chosen, sent), (cost, sorted(rows))
        for _ in range(self.iterations):
            taken_back = self._taken_back(period, chosen, sent, rng) - stay
            kept = [pair for pair in chosen if pair[0] not in taken_back]
            noise = rng.integers(0, HALF_A_LINE, (len(shown), len(warehouse.stations)))
            other = [*kept, *fill(shown, False, noise, period.choice(period.pods_for(kept), kept))]
            pods = period.pods_for(other)
            value = period.cost(other, pods, weight), sorted(row for row, _ in other)  # of equals, the oldest
            if value < best:
                best, chosen, sent = value, other, pods
        return period.decision(chosen, sent, best[0])

    def _taken_back(self, period: Period, chosen: Chosen, sent: Sent, rng: np.random.Generator) -> set[int]:
        """Return the orders to take back, by row."""
        way = int(rng.integers(3))
        if way == 0 or (way == 1 and not sent):
            drawn = rng.random(len(chosen)) < self.share
            return {row for (row, _), taken in zip(chosen, drawn.tolist(), strict=True) if taken}
        if way == 1:
            pod, at = sent[int(rng.integers(len(sent)))]
            there = [row for row, station in chosen if station == at]
            held = period.warehouse.pods[pod].contents
            return {row for row in there if any(sku in held for sku, _ in period.lines.of_order(row))}
        at = chosen[int(rng.integers(len(chosen)))][1]
        return {row for row, station in chosen if station == at}
