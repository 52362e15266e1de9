"""How much pods are wanted: by what was ordered until now, and by what is open."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_core.warehouse import STORED
from rmfs_rules.helpers.sending import Ids, held, worth

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView

Values = NDArray[np.float64]


def speed(warehouse: WarehouseView) -> Ids:
    """Return the sum over the SKUs that each pod has free of the items of them ordered until now, by pod."""
    return held(warehouse.stock, warehouse.ordered())


def demand(warehouse: WarehouseView) -> Ids:
    """Return the items that are wanted in the whole system and free on each pod, by pod."""
    return worth(warehouse.stock, np.arange(len(warehouse.pods)), warehouse.open_demand())


def combined(warehouse: WarehouseView, weight_speed: float, weight_demand: float) -> Values:
    """Return the weighted sum of speed and demand by pod, each as a share of the largest."""
    total = np.zeros(len(warehouse.pods))
    for weight, values in ((weight_speed, speed), (weight_demand, demand)):
        if weight and (of_pods := values(warehouse)).max(initial=0) > 0:
            total += weight * of_pods / of_pods.max()
    return total


def movable(warehouse: WarehouseView) -> NDArray[np.bool_]:
    """Return whether each pod is stored, bound nowhere, and fetched by nobody, by pod."""
    free: NDArray[np.bool_] = warehouse.stock.at == STORED
    for robot in warehouse.robots:  # one that is on its way to move a pod
        if robot.task is not None:
            free[robot.task] = False
    return free


def rank_of(pod: int, wanted: Ids | Values) -> int:
    """Return how many pods are wanted more than one, or as much and have a lower id."""
    more = np.count_nonzero(wanted > wanted[pod]) + np.count_nonzero(wanted[:pod] == wanted[pod])
    return int(more)
