"""How much pods are wanted: by what was ordered until now, and by what is open."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field
from numpy.typing import NDArray

if TYPE_CHECKING:
    from rmfs_core.warehouse import Robot, WarehouseView

Values = NDArray[np.float64]


@define(eq=False)
class Ordered:
    """Counts the items ordered until now by SKU; each order is looked at once in a run."""

    _items: Values = field(init=False, factory=lambda: np.zeros(0))
    _counted: int = field(init=False, default=0)
    _robots: tuple[Robot, ...] = field(init=False, default=())

    def items(self, warehouse: WarehouseView) -> Values:
        """Return the number of items by SKU of all orders that have arrived."""
        if self._robots is not warehouse.robots:  # another run
            self._robots, self._counted, self._items = warehouse.robots, 0, np.zeros(warehouse.n_skus)
        orders = warehouse.orders
        for order in orders[self._counted :]:
            for line in order.lines:
                self._items[line.sku] += line.quantity
        self._counted = len(orders)
        return self._items


def speed(warehouse: WarehouseView, ordered: Values) -> Values:
    """Return the sum over the SKUs that each pod has free of the items of them ordered until now, by pod."""
    free = warehouse.free_items
    return _by_pod(warehouse, np.where(free.number > 0, ordered[free.sku], 0.0))


def demand(warehouse: WarehouseView) -> Values:
    """Return the items that are wanted in the whole system and free on each pod, by pod."""
    free = warehouse.free_items
    return _by_pod(warehouse, np.minimum(warehouse.open_demand()[free.sku], free.number))


def combined(warehouse: WarehouseView, ordered: Values, weight_speed: float, weight_demand: float) -> Values:
    """Return the weighted sum of speed and demand by pod, each as a share of the largest."""
    total = np.zeros(len(warehouse.pods))
    for weight, values in ((weight_speed, speed(warehouse, ordered)), (weight_demand, demand(warehouse))):
        if weight and values.max(initial=0.0) > 0:
            total += weight * values / values.max()
    return total


def _by_pod(warehouse: WarehouseView, values: NDArray[np.generic]) -> Values:
    return np.bincount(warehouse.free_items.pod, weights=values, minlength=len(warehouse.pods)).astype(np.float64)
