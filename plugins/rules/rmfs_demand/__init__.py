"""PPS rule ``demand``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field

from rmfs_core import PodTrip, hookimpl
from rmfs_rule_helpers import send_pods, ticks_to_station

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, Station, WarehouseView


class Wanted:
    """How many items of pods are wanted. What is on them is kept as arrays, and read anew where it changed."""

    def __init__(self) -> None:
        self._pods: tuple[Pod, ...] = ()  # whose contents these are

    def update(self, warehouse: WarehouseView) -> None:
        """Take in what the open demand has become."""
        self._demand = warehouse.open_demand()
        if self._pods is not warehouse.pods:
            self._pods = warehouse.pods
            self._read = [-1] * len(self._pods)
            self._skus = np.zeros((len(self._pods), 1), np.int64)
            self._items = np.zeros_like(self._skus)

    def of(self, pods: Sequence[Pod]) -> list[int]:
        """Return how many items of each pod are wanted."""
        for pod in pods:
            if self._read[pod.id] != pod.changes():
                self._take_in(pod)
        rows = [pod.id for pod in pods]
        wanted: list[int] = np.minimum(self._demand[self._skus[rows]], self._items[rows]).sum(axis=1).tolist()
        return wanted

    def _take_in(self, pod: Pod) -> None:
        """Read what is on a pod."""
        self._read[pod.id] = pod.changes()
        while len(pod.contents) > self._skus.shape[1]:
            self._skus, self._items = (np.hstack([array, np.zeros_like(array)]) for array in (self._skus, self._items))
        self._skus[pod.id, : len(pod.contents)] = list(pod.contents)
        self._items[pod.id, : len(pod.contents)] = list(pod.contents.values())


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

        def most_wanted(station: Station, pods: Sequence[Pod]) -> Pod:
            if len(pods) == 1:
                return pods[0]
            wanted = self._wanted.of(pods)
            most = max(wanted)
            ties = [pod for pod, items in zip(pods, wanted, strict=True) if items == most]
            if len(ties) == 1:  # only ties need driving times
                return ties[0]
            return min(ties, key=lambda pod: (ticks_to_station(warehouse, pod, station), pod.id))

        return send_pods(warehouse, max_fetches, most_wanted)
