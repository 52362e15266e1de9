"""POA rule ``near-best-pod``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define

from rmfs_core import OrderAssignment, hookimpl
from rmfs_rule_helpers import assign_best_pairs
from rmfs_rule_helpers.options import late
from rmfs_rule_helpers.pair_scores import KeptPairs

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, Pod, Station, WarehouseView


@define
class NearBestPod(KeptPairs):
    """Assign each order to the station that is nearest to a pod with most of it.

    The oldest order that fits anywhere (or as ``tie_break`` says) goes next. The best pods for it are those of the pods
    not in use with the highest

        sum over the SKUs i of the order of min(d_i, n_ip),

    d_i items wanted and n_ip free items on pod p. Of the stations where the order fits, the one is taken to which one
    of these pods has the shortest loaded driving time; ties go to the station with the lowest load, then to the one
    with the lowest id. This is repeated until nothing fits.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8
    """

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[OrderAssignment]:
        """Assign orders near their best pods; only the pods of orders whose turn it is are looked at."""
        best: dict[int, list[Pod]] = {}

        def drive(order: int, station: Station) -> int:
            if order not in best:
                best[order] = _best_pods(warehouse, warehouse.order(order))
            times = warehouse.travel.times_to(station.cell, True)
            return min((int(times[pod.cell].min()) for pod in best[order]), default=0)

        if self.keeps(warehouse):
            return self.assign_kept(warehouse, rng, prefer=drive)
        same = np.zeros(len(warehouse.backlog), np.int64)
        return assign_best_pairs(
            warehouse,
            lambda _: same,
            max_wait_s=self.max_wait_s,
            rank=self.rank(warehouse, rng),
            first=late(warehouse) if self.late_first else None,
            prefer=lambda position, station: drive(warehouse.backlog[position].id, station),
            fast_lane=self.fast_lane,
        )


def _best_pods(warehouse: WarehouseView, order: Order) -> list[Pod]:
    """Return the pods not in use with most items of an order; none where no such pod has any."""
    items: Counter[Pod] = Counter()
    for line in order.open_lines:
        for pod in warehouse.pods_with(line.sku):
            if pod.location is not None and not pod.bound_for:
                items[pod] += min(line.quantity, pod.free_items(line.sku))
    most = max(items.values(), default=0)
    return [pod for pod in items if items[pod] == most > 0]
