"""PPS rule ``demand``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field
from numpy.typing import NDArray

from rmfs_core import PodTrip, hookimpl
from rmfs_rule_helpers import send_pods, ticks_to_station

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, Station, WarehouseView


class _Wanted:
    """How many items of each pod are wanted; kept from call to call, and changed where the demand did."""

    def __init__(self) -> None:
        self._pods: tuple[Pod, ...] = ()  # whose sums these are
        self._demand: NDArray[np.int64] = np.zeros(0, np.int64)
        self._sums: dict[int, tuple[int, int]] = {}  # pod -> items picked from it by then, sum

    def update(self, warehouse: WarehouseView) -> None:
        """Take in what the open demand has become."""
        if self._pods is not warehouse.pods:
            self._pods, self._sums = warehouse.pods, {}
            self._demand = warehouse.open_demand()
            return
        demand = warehouse.open_demand()
        for sku in np.flatnonzero(demand != self._demand).tolist():
            before, now = int(self._demand[sku]), int(demand[sku])
            least, sums = min(before, now), self._sums
            for pod in warehouse.pods_with(sku):
                items = pod.contents.get(sku, 0)
                if items > least and pod.id in sums:  # a sum that is out of date stays so
                    picked, wanted = sums[pod.id]
                    sums[pod.id] = picked, wanted + min(now, items) - min(before, items)
        self._demand = demand

    def of(self, pod: Pod) -> int:
        """Return how many items of a pod are wanted."""
        picked, wanted = self._sums.get(pod.id, (-1, 0))
        if picked != pod.changes():
            wanted = sum(min(int(self._demand[sku]), items) for sku, items in pod.contents.items())
            self._sums[pod.id] = pod.changes(), wanted
        return wanted


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

    _wanted: _Wanted = field(init=False, factory=_Wanted, repr=False, eq=False)

    @hookimpl
    def select_pods(self, warehouse: WarehouseView, max_fetches: int) -> Sequence[PodTrip]:
        """Send the most wanted pods to the stations that lack one."""
        self._wanted.update(warehouse)

        def most_wanted(station: Station, pods: Sequence[Pod]) -> Pod:
            wanted = [self._wanted.of(pod) for pod in pods]
            most = max(wanted)
            ties = [pod for pod, items in zip(pods, wanted, strict=True) if items == most]
            if len(ties) == 1:  # only ties need driving times
                return ties[0]
            return min(ties, key=lambda pod: (ticks_to_station(warehouse, pod, station), pod.id))

        return send_pods(warehouse, max_fetches, most_wanted)
