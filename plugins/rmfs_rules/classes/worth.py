"""How much pods are wanted: by what was ordered until now, and by what is open."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_core.warehouse import STORED
from rmfs_rules.helpers.sending import held, worth

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView

Values = NDArray[np.float64]


def combined(warehouse: WarehouseView, weight_speed: float, weight_demand: float) -> Values:
    """Return how much each pod is wanted: the weighted sum of two sums by pod, each as a share of the largest.

    These are the items ordered until now of the SKUs that it has free, and the items on it that are wanted now.
    """
    stock, total = warehouse.stock, np.zeros(len(warehouse.pods))
    if weight_speed and (speed := held(stock, warehouse.ordered())).any():
        total += weight_speed * speed / speed.max()
    if weight_demand and (demand := worth(stock, np.arange(len(total)), warehouse.open_demand())).any():
        total += weight_demand * demand / demand.max()
    return total


def movable(warehouse: WarehouseView) -> NDArray[np.bool_]:
    """Return whether each pod is stored, bound nowhere, and fetched by nobody, by pod."""
    free: NDArray[np.bool_] = warehouse.stock.at == STORED
    for robot in warehouse.robots:  # one that is on its way to move a pod
        if robot.task is not None:
            free[robot.task] = False
    return free
