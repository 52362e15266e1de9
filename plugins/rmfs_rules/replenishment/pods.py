"""RPS: which pod a bundle is stored on.

Each rule has a cost of storing a bundle on each pod; `rmfs_rules.helpers.store_bundles` takes the lowest.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import define
from numpy.typing import NDArray

from rmfs_core import StoreBundle, hookimpl
from rmfs_rules.helpers import StoragePods, store_bundles
from rmfs_rules.helpers.classes import by_share, class_borders, turn
from rmfs_rules.helpers.sending import ByStock

if TYPE_CHECKING:
    from rmfs_core.warehouse import Bundle, WarehouseView

Values = NDArray[np.float64] | NDArray[np.int64]


@define
class ByCost(ByStock, ABC):
    """RPS by the cost of storing a bundle on each pod; a rule says what that is."""

    @hookimpl
    def select_replenishment_pods(self, warehouse: WarehouseView, max_fetches: int) -> Sequence[StoreBundle]:
        """Choose a pod for each bundle that lacks one."""
        return store_bundles(warehouse, max_fetches, self.cost)

    @abstractmethod
    def cost(self, pods: StoragePods, bundle: Bundle) -> Values:
        """Return the cost on each pod. Shape (pods,)."""


@define
class EmptiestPod(ByCost):
    """Store each bundle on the pod with the most free space, among the pods that have space for it and can come.

    Ties, and so all pods where they have no capacity, go to the shortest loaded driving time to the bundle's station,
    then to the lowest id. Bundles choose in the order in which they were assigned, station by station.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    def cost(self, pods: StoragePods, bundle: Bundle) -> Values:  # noqa: ARG002
        """Return the lower cost the more space."""
        return -pods.room


@define
class NearestPodWithRoom(ByCost):
    """Store each bundle on the pod with the shortest drive to its station, among the pods that have space and can come.

    That is the loaded driving time from where the pod is; ties go to the lowest id. Bundles choose in the order in
    which they were assigned, station by station.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    def cost(self, pods: StoragePods, bundle: Bundle) -> Values:  # noqa: ARG002
        """Return the same for all: ties go to the nearest."""
        return np.zeros_like(pods.room)


@define
class SameSku(ByCost):
    """Store each bundle where most of its SKU is: few pods hold a SKU.

    The pod is taken, among the pods that have space and can come, that has most items of the SKU which no request was
    promised, with those of bundles to come. Ties, and so all pods where none has any, go to the shortest loaded driving
    time to the bundle's station, then to the lowest id. Bundles choose in the order in which they were assigned,
    station by station.

    References
    ----------
    T. Lamballais Tessensohn, D. Roy, R. de Koster: Inventory allocation in robotic mobile fulfillment systems. IISE
    Transactions 52(1), 1-17, 2020. https://doi.org/10.1080/24725854.2018.1560517. Over how many pods a SKU is best
    spread is asked there.
    """

    def cost(self, pods: StoragePods, bundle: Bundle) -> Values:
        """Return the lower cost the more items of the SKU."""
        return -pods.items(bundle.sku)


@define
class SpreadSku(ByCost):
    """Store each bundle where least of its SKU is: many pods hold a SKU, and so one is near, or on its way anyway.

    The pod is taken, among the pods that have space and can come, that has fewest items of the SKU which no request was
    promised, with those of bundles to come: one without any, as long as there is one. Ties go to the shortest loaded
    driving time to the bundle's station, then to the lowest id. Bundles choose in the order in which they were
    assigned, station by station.

    References
    ----------
    T. Lamballais Tessensohn, D. Roy, R. de Koster: Inventory allocation in robotic mobile fulfillment systems. IISE
    Transactions 52(1), 1-17, 2020. https://doi.org/10.1080/24725854.2018.1560517
    """

    def cost(self, pods: StoragePods, bundle: Bundle) -> Values:
        """Return the lower cost the fewer items of the SKU."""
        return pods.items(bundle.sku)


@define
class Correlated(ByCost):
    """Store each bundle with SKUs that are bought together with its own.

    The pod p is taken, among the pods that have space and can come, with the largest

        sum over the SKUs j on p, other than the bundle's SKU i, of (orders until now with both i and j),

    of which j counts that p has free items of, or that is to come in a bundle. Ties go to the shortest loaded driving
    time to the bundle's station, then to the lowest id. Bundles choose in the order in which they were assigned,
    station by station.

    References
    ----------
    M. Mirzaei, N. Zaerpour, R. de Koster: The impact of integrated cluster-based storage allocation on parts-to-picker
    warehouse performance. Transportation Research Part E 146, 102207, 2021. https://doi.org/10.1016/j.tre.2020.102207

    RAWSim-O, https://github.com/merschformann/RAWSim-O: ``CorrelativeStorageManager``.
    """

    def cost(self, pods: StoragePods, bundle: Bundle) -> Values:
        """Return the lower cost the more orders want both."""
        together = np.zeros(pods.warehouse.n_skus, np.int64)
        for order in pods.warehouse.orders:
            skus = [sku for sku, _ in order.lines]
            if bundle.sku in skus:
                together[skus] += 1
        together[bundle.sku] = 0
        return -pods.sums(together)


@define
class LeastDemand(ByCost):
    """Store each bundle on the pod whose SKUs are wanted least now: it is missed least while it is away.

    Of the pods that have space and can come, the one is taken with the fewest items wanted of the SKUs that it has free
    items of or that are to come in a bundle: of all orders that have arrived, less what was picked. Ties go to the
    shortest loaded driving time to the bundle's station, then to the lowest id. Bundles choose in the order in which
    they were assigned, station by station.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    def cost(self, pods: StoragePods, bundle: Bundle) -> Values:  # noqa: ARG002
        """Return the items wanted."""
        return pods.sums(pods.warehouse.open_demand())


@define
class TurnoverPod(ByCost):
    """Store each bundle on a pod of its class: fast movers together.

    SKUs, sorted by the items ordered until now, and pods, sorted by the sum of these over the SKUs that they have free
    items of or that are to come in a bundle, most first, are cut into classes at the same shares. A bundle goes to a
    pod of its SKU's class that has space and can come. Where there is none, the next class down is tried,
    then the next one up, and so on to both sides. In a class the shortest loaded driving time to the bundle's station
    decides, then the lowest id. Bundles choose in the order in which they were assigned, station by station.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    borders: tuple[float, ...] = class_borders("SKUs and of all pods")

    def cost(self, pods: StoragePods, bundle: Bundle) -> Values:
        """Return when each pod's class is looked at: the bundle's own first, then to both sides, down before up."""
        ordered = pods.warehouse.ordered()
        of_pods, of_skus = (
            by_share(np.argsort(-speed, kind="stable"), self.borders) for speed in (pods.sums(ordered), ordered)
        )
        return turn(of_pods - of_skus[bundle.sku], better_first=False)


POD_RULES: dict[str, Callable[[], Any]] = {
    "emptiest-pod": EmptiestPod,
    "nearest-pod-with-room": NearestPodWithRoom,
    "same-sku": SameSku,
    "spread-sku": SpreadSku,
    "correlated": Correlated,
    "turnover-pod": TurnoverPod,
    "least-demand": LeastDemand,
}
"""The rules that choose by a cost, by their names in scenarios."""
