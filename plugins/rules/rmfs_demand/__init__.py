"""PPS rule ``demand``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field

from rmfs_core import PodTrip, hookimpl
from rmfs_rule_helpers.pod_sending import Ids, KeptPods, KeptSums

if TYPE_CHECKING:
    from rmfs_core.traffic import Roads
    from rmfs_core.warehouse import FreeItems, Pod, Station, WarehouseView


class Wanted:
    """How many items of pods are wanted. What is on them is kept, and read anew where it changed."""

    def __init__(self) -> None:
        self.pods = KeptPods()
        self._sums = KeptSums()
        self._of: FreeItems | None = None  # whose entries these are

    def load(self) -> None:
        """Load what is compiled, or compile it."""
        self.pods.load()
        self._sums.load()

    def update(self, warehouse: WarehouseView) -> None:
        """Take in what pods and the open demand have become."""
        self.pods.update(warehouse)
        changed: Sequence[Pod] = () if warehouse.unlimited_stock else self.pods.changed
        if self._of is not self.pods.items:
            self._of, changed = self.pods.items, warehouse.pods
            self._first = self._of.pod.searchsorted(np.arange(len(changed))).tolist()
            self._read = [-1] * len(changed)
        entries: list[int] = []
        items: list[int] = []
        for pod in changed:
            if self._read[pod.id] != pod.changes():
                self._read[pod.id] = pod.changes()
                entries += range(self._first[pod.id], self._first[pod.id] + len(pod.contents))
                items += [pod.contents[sku] for sku in sorted(pod.contents)]
        ids, numbers = np.array(entries, np.int64), np.array(items, np.int64)
        self.by_pod = self._sums.update(self.pods, ids, numbers, warehouse.open_demand())


@define
class Demand:
    """Send the pod whose contents are wanted most in the whole system.

    Among the pods not in use (or leaving a station with no next one) that can serve at least one uncovered request of
    the station, the pod p with the highest

        sum over the SKUs i of p of min(D_i, n_ip)

    is sent; D_i is the open demand of the whole system (items assigned, queued and in the backlog, not yet picked) and
    n_ip the number of items on the pod. Ties go to the pod with the shorter loaded driving time to the station, then to
    the lowest id. The station with the fewest inbound pods chooses first.

    References
    ----------
    L. Xie, N. Thieme, R. Krenzler, H. Li: Efficient order picking methods in robotic mobile fulfillment systems.
    arXiv:1902.03092, 2019. https://arxiv.org/abs/1902.03092

    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    _wanted: Wanted = field(init=False, factory=Wanted, repr=False, eq=False)

    @hookimpl
    def select_pods(self, warehouse: WarehouseView, max_fetches: int) -> Sequence[PodTrip]:
        """Send the most wanted pods to the stations that lack one."""
        self._wanted.update(warehouse)

        kept, by_pod = self._wanted.pods, self._wanted.by_pod

        def most_wanted(station: Station, pods: Ids) -> int:
            wanted = by_pod[pods]
            ties = pods[wanted == wanted.max()]
            if len(ties) == 1:  # only ties need driving times
                return int(ties[0])
            return int(ties[kept.ticks(warehouse, ties, station).argmin()])

        return kept.send(warehouse, max_fetches, most_wanted)

    def prepare(self, roads: Roads) -> None:  # noqa: ARG002
        """Load what is compiled, or compile it."""
        self._wanted.load()
