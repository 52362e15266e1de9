"""RPS rule ``the-rule``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field, validators
from rmfs import StoreBundle, hookimpl
from rmfs.helpers import StoragePods, store_bundles

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from rmfs.warehouse import Bundle, WarehouseView


@define
class TheRule:
    """Store a bundle on a pod that has space, few items of its SKU, and is on its way anyway if possible.

    The pod with the lowest ``items of the SKU on it + fetching`` is taken, where ``fetching`` counts for pods that a
    robot would have to fetch for this. Ties go to the nearest pod.

    Parameters
    ----------
    fetching
        How many items more a pod may have that need not be fetched.
    """

    fetching: float = field(default=10.0, validator=validators.ge(0))

    @hookimpl
    def select_replenishment_pods(self, warehouse: WarehouseView, max_fetches: int) -> Sequence[StoreBundle]:
        """Choose a pod for each bundle that lacks one: the pod with the lowest cost that can take it."""
        stored = np.zeros(len(warehouse.pods), dtype=bool)
        stored[[pod.id for pod in warehouse.free_pods]] = True

        def cost(pods: StoragePods, bundle: Bundle) -> NDArray[np.float64]:
            items: NDArray[np.float64] = pods.items(bundle.sku) + self.fetching * stored
            return items

        return store_bundles(warehouse, max_fetches, cost)
