"""PPS rule ``demand``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define, field

from rmfs_core import PodTrip, hookimpl
from rmfs_rules.helpers.pod_sending import Ids, KeptPods, KeptSums, may_send

if TYPE_CHECKING:
    from rmfs_core.traffic import Roads
    from rmfs_core.warehouse import Station, WarehouseView


@define
class Demand:
    """Send the pod whose contents are wanted most in the whole system.

    Among the pods not in use (or leaving a station with no next one) that can serve at least one uncovered request of
    the station, the pod p with the highest

        sum over the SKUs i of p of min(D_i, n_ip)

    is sent; D_i is the open demand of the whole system (items of all orders that have arrived, not yet picked; orders
    that wait for stock count as well) and n_ip the number of items on the pod. Ties go to the pod with the shorter
    loaded driving time to the station, then to the lowest id. The station with the fewest inbound pods chooses first.

    References
    ----------
    L. Xie, N. Thieme, R. Krenzler, H. Li: Efficient order picking methods in robotic mobile fulfillment systems.
    arXiv:1902.03092, 2019. https://arxiv.org/abs/1902.03092

    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    _pods: KeptPods = field(init=False, factory=KeptPods, repr=False, eq=False)
    _wanted: KeptSums = field(init=False, factory=KeptSums, repr=False, eq=False)

    @hookimpl
    def select_pods(self, warehouse: WarehouseView, max_fetches: int) -> Sequence[PodTrip]:
        """Send the most wanted pods to the stations that lack one."""
        if not may_send(warehouse, max_fetches):
            return []
        kept = self._pods
        kept.update(warehouse)
        wanted = self._wanted.of_free(kept, warehouse.open_demand())  # nothing on a pod that can be sent is promised

        def most_wanted(station: Station, pods: Ids) -> int:
            ties = kept.highest(pods, wanted)
            if len(ties) == 1:  # only ties need driving times
                return int(ties[0])
            return int(ties[kept.ticks(warehouse, ties, station).argmin()])

        return kept.send(warehouse, max_fetches, most_wanted)

    def prepare(self, roads: Roads) -> None:  # noqa: ARG002
        """Load what is compiled, or compile it."""
        self._pods.load()
        self._wanted.load()
