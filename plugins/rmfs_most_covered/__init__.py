"""Filter ``most-covered``: the paper's prefilter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field, validators

from rmfs_core import hookimpl
from rmfs_core.warehouse import lines_of

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, WarehouseView


@define
class MostCovered:
    """Keep the n orders with the highest share of lines that pods at the stations can serve already.

    The share of an order is the number of its open lines whose SKU is on a pod at or bound for any station, divided by
    the number of its open lines. Ties go to the older order.

    Parameters
    ----------
    n
        How many orders to keep.

    References
    ----------
    L. Xie, N. Thieme, R. Krenzler, H. Li: Efficient order picking methods in robotic mobile fulfillment systems,
    Section 4.2. arXiv:1902.03092, 2019. https://doi.org/10.48550/arXiv.1902.03092
    """

    n: int = field(validator=validators.ge(1))

    @hookimpl
    def filter_backlog(self, warehouse: WarehouseView, orders: Sequence[Order]) -> Sequence[Order]:
        """Keep the orders with the highest shares."""
        there = np.zeros(warehouse.n_skus, dtype=bool)
        for pod in {pod for station in warehouse.stations for pod in station.inbound_pods}:
            there[[sku for sku in pod.contents if pod.contents[sku] > 0]] = True
        whole = len(orders) == len(warehouse.backlog)  # unless another filter was there first
        lines = warehouse.backlog_lines if whole else lines_of(orders)
        covered = np.bincount(lines.order, weights=there[lines.sku], minlength=len(orders))
        shares = covered / np.bincount(lines.order, minlength=len(orders))
        best = np.argsort(-shares, kind="stable")[: self.n]
        return [orders[position] for position in best.tolist()]
