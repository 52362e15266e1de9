"""What was ordered until now: which SKUs together."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field
from numpy.typing import NDArray

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView


@define(eq=False)
class Ordered:
    """Counts orders by pairs of SKUs; each order is looked at once in a run."""

    _pairs: dict[int, Counter[int]] = field(init=False, factory=dict)
    _counted: int = field(init=False, default=0)
    _run: object = field(init=False, default=None)

    def together(self, warehouse: WarehouseView, sku: int) -> NDArray[np.int64]:
        """Return by SKU in how many orders that have arrived it is with a SKU; 0 for that itself."""
        self._look(warehouse)
        pairs = self._pairs.get(sku, Counter())
        together = np.zeros(warehouse.n_skus, np.int64)
        together[list(pairs)] = list(pairs.values())
        return together

    def _look(self, warehouse: WarehouseView) -> None:
        run = warehouse.robots
        if run is not self._run:  # another run
            self._run, self._counted, self._pairs = run, 0, {}
        for order in warehouse.orders_since(self._counted):
            self._counted += 1
            wanted = dict(order.lines)
            for sku in wanted:
                pairs = self._pairs.setdefault(sku, Counter())
                pairs.update(wanted.keys())
                del pairs[sku]
