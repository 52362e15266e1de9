"""Rule ``the-rule`` for ROA and RPS together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from attrs import define
from rmfs import BundleAssignment, BundleDecision, StoreBundle, hookimpl
from rmfs.helpers import StoragePods, cheapest, store_bundles

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from rmfs.warehouse import Bundle, WarehouseView


@define
class TheRule:
    """Bring the oldest bundle that fits a pod to the station with the most free capacity, together with that pod.

    The pod is the emptiest that can come; ties go to the nearest. Each decision assigns one bundle; the rule
    is asked again in the next round.
    """

    @hookimpl
    def assign_bundles_and_pods(self, warehouse: WarehouseView, max_fetches: int) -> BundleDecision:
        """Choose pods for bundles that are at a station without one; only then a bundle that waits."""

        def cost(pods: StoragePods, _bundle: Bundle) -> NDArray[np.int64]:
            return -pods.room

        stores = store_bundles(warehouse, max_fetches, cost)
        station = max(warehouse.replenishment_stations, key=lambda station: (station.free_bundle_capacity, -station.id))
        if not stores and station.free_bundle_capacity > 0:
            pods = StoragePods(warehouse, max_fetches)
            for bundle in warehouse.bundles:
                pod = cheapest(pods, bundle, cost, (station,))
                if pod is not None:
                    return BundleDecision([BundleAssignment(bundle.id, station.id)], [StoreBundle(bundle.id, pod)])
        return BundleDecision(stores=stores)
