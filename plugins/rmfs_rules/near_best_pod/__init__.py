"""POA rule ``near-best-pod``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field

from rmfs_core import OrderAssignment, hookimpl
from rmfs_rules.helpers import assign_best_pairs
from rmfs_rules.helpers.kept_options import KeptPairs
from rmfs_rules.helpers.options import late
from rmfs_rules.helpers.pod_sending import Ids, KeptPods

if TYPE_CHECKING:
    from rmfs_core.traffic import Roads
    from rmfs_core.warehouse import Station, WarehouseView


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

    _pods: KeptPods = field(init=False, factory=KeptPods, repr=False, eq=False)

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[OrderAssignment]:
        """Assign orders near their best pods; only the pods of orders whose turn it is are looked at."""
        self._pods.update(warehouse)
        best: dict[int, Ids] = {}

        def drive(order: int, station: Station) -> int:
            if order not in best:
                wanted = warehouse.order(order).open_lines
                best[order] = self._pods.with_most((line.sku, line.quantity) for line in wanted)
            return int(self._pods.ticks(warehouse, best[order], station).min()) if len(best[order]) else 0

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

    def prepare(self, roads: Roads) -> None:
        """Load what is compiled, or compile it."""
        super().prepare(roads)
        self._pods.load()
