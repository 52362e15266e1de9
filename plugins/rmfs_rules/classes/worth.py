"""How much pods are wanted: by what was ordered until now, and by what is open."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_rules.helpers.pod_sending import Ids, KeptPods, KeptSums

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView

Values = NDArray[np.float64]


class Ordered:
    """Counts the items ordered until now by SKU; each order is looked at once in a run."""

    def __init__(self) -> None:
        self._run: object = None

    def items(self, warehouse: WarehouseView) -> Ids:
        """Return the number of items by SKU of all orders that have arrived."""
        run = warehouse.free_items_log()
        if run is not self._run:  # another run
            self._run, self._counted, self._items = run, 0, np.zeros(warehouse.n_skus, np.int64)
        for order in warehouse.orders_since(self._counted):
            self._counted += 1
            for sku, quantity in order.lines:
                self._items[sku] += quantity
        return self._items


class Worth:
    """How much each pod is wanted. What did not change is not read again.

    Attributes
    ----------
    ordered
        The items ordered until now.
    pods
        What is kept of the pods, as they were when this was asked last.
    """

    def __init__(self) -> None:
        self.ordered, self.pods = Ordered(), KeptPods()
        self._speed, self._demand = KeptSums(), KeptSums()

    def load(self) -> None:
        """Load what is compiled, or compile it."""
        self.pods.load()
        self._speed.load()

    def speed(self, warehouse: WarehouseView) -> Ids:
        """Return the sum over the SKUs that each pod has free of the items of them ordered until now, by pod."""
        self.pods.update(warehouse)
        return self._speed.of_held(self.pods, self.ordered.items(warehouse))

    def demand(self, warehouse: WarehouseView) -> Ids:
        """Return the items that are wanted in the whole system and free on each pod, by pod."""
        self.pods.update(warehouse)
        return self._demand.of_free(self.pods, warehouse.open_demand())

    def combined(self, warehouse: WarehouseView, weight_speed: float, weight_demand: float) -> Values:
        """Return the weighted sum of speed and demand by pod, each as a share of the largest."""
        total = np.zeros(len(warehouse.pods))
        if not weight_speed and not weight_demand:
            self.pods.update(warehouse)
        for weight, values in ((weight_speed, self.speed), (weight_demand, self.demand)):
            if weight and (of_pods := values(warehouse)).max(initial=0) > 0:
                total += weight * of_pods / of_pods.max()
        return total


def rank_of(pod: int, wanted: Ids | Values) -> int:
    """Return how many pods are wanted more than one, or as much and have a lower id."""
    more = np.count_nonzero(wanted > wanted[pod]) + np.count_nonzero(wanted[:pod] == wanted[pod])
    return int(more)
