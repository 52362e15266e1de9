"""What was ordered until now: how much of each SKU, and which SKUs together."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field
from numpy.typing import NDArray

if TYPE_CHECKING:
    from rmfs_core.warehouse import Robot, WarehouseView


@define(eq=False)
class Ordered:
    """Counts items ordered by SKU, and orders by pairs of SKUs; each order is looked at once in a run."""

    _items: NDArray[np.float64] = field(init=False, factory=lambda: np.zeros(0))
    _pairs: dict[int, Counter[int]] = field(init=False, factory=dict)
    _counted: int = field(init=False, default=0)
    _robots: tuple[Robot, ...] = field(init=False, default=())

    def items(self, warehouse: WarehouseView) -> NDArray[np.float64]:
        """Return the number of items by SKU of all orders that have arrived."""
        self._look(warehouse)
        return self._items

    def together(self, warehouse: WarehouseView, sku: int) -> NDArray[np.float64]:
        """Return by SKU in how many orders that have arrived it is with a SKU; 0 for that itself."""
        self._look(warehouse)
        pairs = self._pairs.get(sku, Counter())
        together = np.zeros(warehouse.n_skus)
        together[list(pairs)] = list(pairs.values())
        return together

    def _look(self, warehouse: WarehouseView) -> None:
        if self._robots is not warehouse.robots:  # another run
            self._robots, self._counted = warehouse.robots, 0
            self._items, self._pairs = np.zeros(warehouse.n_skus), {}
        orders = warehouse.orders
        for order in orders[self._counted :]:
            skus = [line.sku for line in order.lines]
            for line in order.lines:
                self._items[line.sku] += line.quantity
                pairs = self._pairs.setdefault(line.sku, Counter())
                pairs.update(skus)
                del pairs[line.sku]
        self._counted = len(orders)
