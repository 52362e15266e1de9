"""POA rule ``common-lines``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define

from rmfs_core import OrderAssignment, hookimpl
from rmfs_rules.helpers.pairs import PairOptions, Pairs

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView


@define
class CommonLines(PairOptions):
    """Assign the order that wants the same SKUs as the orders already at a station.

    Over all stations s with free capacity and all orders o that fit there, the pair with the most lines in common,

        number of open lines of o whose SKU is wanted by an open request at s,

    is assigned, so that one pod can serve several orders. Requests assigned in the same decision count as well. Ties go
    to the oldest order (or as ``tie_break`` says), then to the station with the lowest load, then to the one with the
    lowest id. This is repeated until nothing fits.

    References
    ----------
    P. R. Wurman, R. D'Andrea, M. Mountz: Coordinating hundreds of cooperative, autonomous vehicles in warehouses.
    AI Magazine 29(1), 9-19, 2008. https://doi.org/10.1609/aimag.v29i1.2082

    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8
    """

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[OrderAssignment]:
        """Assign the pairs of order and station with the most lines in common."""
        wanted = np.zeros((len(warehouse.stations), warehouse.n_skus), dtype=np.int64)
        for station in warehouse.stations:
            wanted[station.id, [request.sku for request in station.open_requests]] = 1

        def take(pairs: Pairs, station: Station, row: int) -> None:
            for sku, _ in pairs.lines.of_order(row):
                pairs.change(station.id, sku, 1)

        return self.assign(warehouse, rng, wanted, take)
