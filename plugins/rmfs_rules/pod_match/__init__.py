"""POA rule ``pod-match``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define
from numpy.typing import NDArray

from rmfs_core import OrderAssignment, hookimpl
from rmfs_rules.helpers import lines_at, sum_per_order
from rmfs_rules.helpers.kept_options import KeptPairs
from rmfs_rules.helpers.pair_scores import PairScores

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView


@define
class PodMatch(KeptPairs):
    """Assign the order that the pods at a station can serve best.

    Over all stations s with room and all orders o that fit there, the pair with the highest score

        sum over the SKUs i of o of min(d_oi, a_is)

    is assigned; d_oi is the number of items wanted and a_is the number of items on the pods inbound to s that are not
    promised to other requests. Ties go to the oldest order (or as ``tie_break`` says), then to the station with the
    lowest load, then to the one with the lowest id. This is repeated until nothing fits.

    References
    ----------
    L. Xie, N. Thieme, R. Krenzler, H. Li: Efficient order picking methods in robotic mobile fulfillment systems.
    arXiv:1902.03092, 2019. https://arxiv.org/abs/1902.03092

    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[OrderAssignment]:
        """Assign the best matching pairs of order and station."""
        if self.keeps(warehouse, warehouse.available()):
            return self.assign_kept(warehouse, rng, None if warehouse.unlimited_stock else _Stock(self.scores).take)
        stock = _InboundStock(warehouse)
        take = None if warehouse.unlimited_stock else stock.take
        return self.assign(warehouse, rng, stock.score, take)


class _Stock:
    """Items that the orders assigned so far in this decision take from the inbound pods."""

    def __init__(self, scores: PairScores) -> None:
        self.scores = scores
        self.taken: dict[tuple[int, int], int] = {}  # (pod, SKU) -> items

    def take(self, station: Station, place: int) -> None:
        """Take an order's items from the inbound pods."""
        for sku, quantity in self.scores.lines_of(place):
            wanted = quantity
            for pod in station.inbound_pods:
                items = min(wanted, pod.free_items(sku) - self.taken.get((pod.id, sku), 0))
                if items > 0:
                    self.taken[pod.id, sku] = self.taken.get((pod.id, sku), 0) + items
                    wanted -= items
                    for at in (at for at in pod.bound_for if at < len(self.scores.available)):  # that pick
                        self.scores.change(at, sku, int(self.scores.available[at, sku]) - items)


class _InboundStock:
    """Items on inbound pods, less what the orders assigned so far in this decision take."""

    def __init__(self, warehouse: WarehouseView) -> None:
        self.warehouse = warehouse
        self.available = warehouse.available()
        self.taken: dict[tuple[int, int], int] = {}  # (pod, SKU) -> items

    def score(self, station: Station) -> NDArray[np.int64]:
        """Return how many items of each order the pods inbound to a station have available."""
        lines = self.warehouse.backlog_lines
        return sum_per_order(self.warehouse, np.minimum(self.available[station.id, lines.sku], lines.quantity))

    def take(self, station: Station, position: int) -> set[int]:
        """Take an order's items from the inbound pods; return the stations that have fewer items now."""
        lines = self.warehouse.backlog_lines
        where = lines_at(self.warehouse, position)
        changed: set[int] = set()
        for sku, quantity in zip(lines.sku[where].tolist(), lines.quantity[where].tolist(), strict=True):
            wanted = quantity
            for pod in station.inbound_pods:
                before = self.taken.get((pod.id, sku), 0)
                items = min(wanted, pod.free_items(sku) - before)
                if items > 0:
                    self.taken[pod.id, sku] = before + items
                    wanted -= items
                    picking = [at for at in pod.bound_for if at < len(self.available)]
                    self.available[picking, sku] -= items
                    changed.update(picking)
        return changed
