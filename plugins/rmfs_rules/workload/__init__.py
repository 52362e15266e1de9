"""POA rule ``workload``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, validators

from rmfs_core import OrderAssignment, hookimpl
from rmfs_rules.helpers.pairs import PairOptions, Pairs
from rmfs_rules.helpers.parameters import parameter

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView


@define
class Workload(PairOptions):
    """Fill the station that works on the fewest orders, or on the most.

    Of the stations where an order fits, the one that works on the fewest orders (``prefer = "fewest"``, which evens the
    work out) or the most (``"most"``, which fills one station after another) is assigned the oldest that fits, or which
    ``tie_break`` says. Ties go to the station with the lowest load, then to the one with the lowest id. This is
    repeated until nothing fits.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8
    """

    prefer: str = parameter(
        "fewest",
        validators.in_(("fewest", "most")),
        "Stations that go first: those with the fewest orders at work, or the most",
    )

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[OrderAssignment]:
        """Assign orders to the stations by their number of orders."""
        sign = 1.0 if self.prefer == "most" else -1.0
        orders = [{request.order.id for request in station.open_requests} for station in warehouse.stations]
        extra = np.array([sign * len(of_station) for of_station in orders])

        def take(pairs: Pairs, station: Station, row: int) -> None:
            orders[station.id].add(int(pairs.lines.order_id[row]))  # one that is begun may be there already
            extra[station.id] = sign * len(orders[station.id])

        return self.assign(warehouse, rng, take=take, extra=extra)
