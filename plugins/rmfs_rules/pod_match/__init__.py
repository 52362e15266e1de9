"""POA rule ``pod-match``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define

from rmfs_core import OrderAssignment, hookimpl
from rmfs_rules.helpers.pairs import PairOptions, Pairs
from rmfs_rules.helpers.parameters import NOT_NEGATIVE, parameter

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView


@define
class PodMatch(PairOptions):
    """Assign the order that the pods at a station can serve best.

    Over all stations s with free capacity and all orders o that fit there, the pair with the highest score

        sum over the SKUs i of o of min(d_oi, a_is) - spread * w_s

    is assigned; d_oi is the number of items wanted, a_is the number of items on the pods inbound to s that are not
    promised to other requests, and w_s the number of items that s has yet to pick. Ties go to the oldest order (or as
    ``tie_break`` says), then to the station with the lowest load, then to the one with the lowest id. This is repeated
    until nothing fits.

    References
    ----------
    L. Xie, N. Thieme, R. Krenzler, H. Li: Efficient order picking methods in robotic mobile fulfillment systems.
    arXiv:1902.03092, 2019. https://arxiv.org/abs/1902.03092

    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    spread: float = parameter(
        0.0,
        NOT_NEGATIVE,
        "Items that an order has to match more at a station for each item that the station has yet to pick; 0: the "
        "paper's rule, under which one station may get most orders while others have little to do",
    )

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[OrderAssignment]:
        """Assign the best matching pairs of order and station."""
        taken: Counter[tuple[int, int]] = Counter()  # items by pod and SKU that go to orders of this decision
        extra = np.zeros(len(warehouse.stations))
        if self.spread:
            extra -= [self.spread * station.open_items for station in warehouse.stations]

        def take(pairs: Pairs, station: Station, row: int) -> None:
            extra[station.id] -= self.spread * pairs.lines.items[row]
            if warehouse.unlimited_stock:
                return
            for sku, quantity in pairs.lines.of_order(row):
                wanted = quantity
                for pod in station.inbound_pods:
                    items = min(wanted, pod.free_items(sku) - taken[pod.id, sku])
                    if items > 0:
                        taken[pod.id, sku] += items
                        wanted -= items
                        for at in pod.bound_for:
                            pairs.add(at, sku, -items)

        told = None if warehouse.unlimited_stock and not self.spread else take
        return self.assign(warehouse, rng, warehouse.available(), told, extra=extra)
