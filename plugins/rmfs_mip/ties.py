"""Second objectives: which of the many optima of objective (1) is taken.

Lexicographic and exact: objective (1) is fixed at its optimum by a row, then the second objective is maximised.
``oldest``: sum over the assigned items of the number of orders in the backlog that are not older than theirs.
``demand``: sum over the new visits of the items that the whole backlog wants of the pod's SKUs.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rmfs_mip.period import Period
from rmfs_mip.solution import Part

TieBreak = Literal["solver", "oldest", "demand"]


def order_gains(period: Period) -> NDArray[np.float64]:
    """Return what an item of each order is worth under ``oldest``: n for the oldest, 1 for the youngest."""
    n = len(period.orders)
    return np.arange(n, 0, -1, dtype=np.float64)


def pod_gains(period: Period) -> NDArray[np.float64]:
    """Return what a visit of each pod is worth under ``demand``."""
    wanted = np.bincount(
        period.line_sku, weights=period.line_quantity.astype(np.float64), minlength=period.stock.n_skus
    )
    gains: NDArray[np.float64] = period.stock.holds @ wanted
    return gains


def seniority(period: Period, parts: tuple[Part, ...]) -> float:
    """Return the second objective of ``oldest``."""
    gains, lines = order_gains(period), period.lines
    return float(sum(gains[part.order] * dict(lines[part.order])[sku] for part in parts for sku in part.skus))


def demand_covered(period: Period, visits: tuple[tuple[int, int], ...]) -> float:
    """Return the second objective of ``demand``."""
    gains = pod_gains(period)
    return float(sum(gains[pod] for pod, station in visits if pod not in period.inbound[station]))
