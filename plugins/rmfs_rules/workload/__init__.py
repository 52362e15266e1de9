"""POA rule ``workload``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field, validators
from numpy.typing import NDArray

from rmfs_core import OrderAssignment, hookimpl
from rmfs_rules.helpers.kept_options import KeptPairs

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView


@define
class Workload(KeptPairs):
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

    prefer: str = field(
        default="fewest",
        validator=validators.in_(("fewest", "most")),
        metadata={"doc": "Which stations go first: those that work on the fewest orders, or on the most"},
    )

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[OrderAssignment]:
        """Assign orders to the stations by their number of orders."""
        orders = {s.id: {request.order.id for request in s.open_requests} for s in warehouse.stations}
        if self.keeps(warehouse):
            sign = 1.0 if self.prefer == "most" else -1.0
            extra = np.array([sign * len(orders[station.id]) for station in warehouse.stations])

            def take(station: Station, _place: int) -> None:
                extra[station.id] += sign

            return self.assign_kept(warehouse, rng, take, extra=extra)
        backlog = warehouse.backlog
        most = max(map(len, orders.values()), default=0) + len(backlog)

        def score(station: Station) -> NDArray[np.int64]:
            number = len(orders[station.id])
            return np.full(len(backlog), number if self.prefer == "most" else most - number, np.int64)

        def assigned(station: Station, position: int) -> tuple[int]:
            orders[station.id].add(backlog[position].id)
            return (station.id,)

        return self.assign(warehouse, rng, score, assigned)
