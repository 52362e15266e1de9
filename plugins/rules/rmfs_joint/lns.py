"""Joint POA+PPS rule ``lns``."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from attrs import define, field, validators

from rmfs_core import JointDecision, hookimpl
from rmfs_joint.alternating import Alternating
from rmfs_joint.choosing import NOT_NOW, SCALE, Chosen, Integers, Left, Sent, waiting_too_long
from rmfs_joint.covering import cost, decision, pods_for, unused_capacity_weight
from rmfs_rule_helpers import lines_at, waiting_limit

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView


@define(kw_only=True)
class LargeNeighborhoodSearch:
    """Take back some of the orders that were chosen, choose again, and keep what costs less: large neighborhood search.

    Whole orders, without a solver. It begins with the choice of ``alternating``, and its cost is that of
    ``integrated``,

        visits + W_u * free places,

    at a station that counts orders, a free place times the items of the largest order. Each of the iterations takes
    orders back, one of three ways, drawn at random: each with the probability ``share``; all that want something of one
    pod that is sent, at its station; or all of one station. Then orders are added as ``alternating`` does, given the
    pods that the others need, by scores from which up to half a missing line is taken at random, and pods are chosen
    for all of them. The outcome is kept if it costs less, or as much and its orders are older: of the orders by which
    two such outcomes differ, it has the oldest.

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

    whole_orders: ClassVar[bool] = True

    iterations: int = field(
        default=50,
        validator=validators.ge(0),
        metadata={"doc": "Times that orders are taken back and chosen again in a decision"},
    )
    share: float = field(
        default=0.3,
        validator=validators.and_(validators.gt(0), validators.le(1)),
        metadata={"doc": "With which probability an order is taken back when orders are drawn one by one"},
    )
    unused_capacity_weight: float = unused_capacity_weight()
    max_wait_s: float | None = waiting_limit()

    @hookimpl
    def assign_orders_and_pods(self, warehouse: WarehouseView, rng: np.random.Generator) -> JointDecision:
        """Improve the choice of ``alternating``."""
        weight = self.unused_capacity_weight
        start = Alternating(unused_capacity_weight=weight, max_wait_s=self.max_wait_s)
        chosen, sent = start.best(warehouse)
        waiting = waiting_too_long(warehouse, self.max_wait_s)
        if not chosen or waiting - {position for position, _ in chosen}:
            return decision(warehouse, chosen, sent, weight)
        best = _value(warehouse, chosen, sent, weight)
        sizes = _sizes(warehouse)
        for _ in range(self.iterations):
            taken_back = self._taken_back(warehouse, chosen, sent, rng) - waiting
            kept = [pair for pair in chosen if pair[0] not in taken_back]
            other = _filled(warehouse, kept, sizes, rng)
            pods = pods_for(warehouse, other)
            value = _value(warehouse, other, pods, weight)
            if value < best:
                best, chosen, sent = value, other, pods
        return decision(warehouse, chosen, sent, weight)

    def _taken_back(self, warehouse: WarehouseView, chosen: Chosen, sent: Sent, rng: np.random.Generator) -> set[int]:
        """Return the orders to take back, by position in the backlog."""
        way = int(rng.integers(3))
        if way == 0 or (way == 1 and not sent):
            drawn = rng.random(len(chosen)) < self.share
            return {position for (position, _), taken in zip(chosen, drawn.tolist(), strict=True) if taken}
        if way == 1:
            pod, at = sent[int(rng.integers(len(sent)))]
            skus, there = warehouse.backlog_lines.sku, [position for position, station in chosen if station == at]
            held = warehouse.pods[pod].contents.keys()
            return {position for position in there if held & set(skus[lines_at(warehouse, position)].tolist())}
        at = chosen[int(rng.integers(len(chosen)))][1]
        return {position for position, station in chosen if station == at}


def _value(warehouse: WarehouseView, chosen: Chosen, sent: Sent, weight: float) -> tuple[float, list[int]]:
    """Return what is compared: the cost, and then the orders, oldest first."""
    return cost(warehouse, chosen, sent, weight), sorted(position for position, _ in chosen)


def _sizes(warehouse: WarehouseView) -> Integers:
    """Return what each order of the backlog takes up at each station."""
    return np.array([[warehouse.size_at(order, at) for at in warehouse.stations] for order in warehouse.backlog])


def _filled(warehouse: WarehouseView, kept: Chosen, sizes: Integers, rng: np.random.Generator) -> Chosen:
    """Return the orders that are kept, and more as long as any fits."""
    stations = warehouse.stations
    left = Left(warehouse, pods_for(warehouse, kept))
    free = np.array([station.free_capacity for station in stations])
    open_ = np.ones(len(sizes), np.bool_)
    for position, station in kept:
        left.take(stations[station], position)
        free[station] -= sizes[position, station]
        open_[position] = False
    noise = rng.integers(0, SCALE // 2, sizes.shape)
    chosen, changed = list(kept), [station.id for station in stations]
    scores = np.empty_like(sizes)
    while True:
        for station in changed:
            score = left.score(stations[station])
            scores[:, station] = np.where(score == NOT_NOW, NOT_NOW, score - noise[:, station])
        able = np.where((sizes <= free) & open_[:, None], scores, NOT_NOW)
        position, station = (int(at) for at in np.unravel_index(able.argmax(), able.shape))
        if able[position, station] == NOT_NOW:
            return chosen
        chosen.append((position, station))
        free[station] -= sizes[position, station]
        open_[position] = False
        changed = list(left.take(stations[station], position))
