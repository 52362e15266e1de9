"""Filter ``most-covered``: the paper's prefilter."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field, validators

from rmfs_core import hookimpl
from rmfs_core.warehouse import lines_of

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, WarehouseView


@define
class MostCovered:
    """Keep the n orders with the highest share of lines that pods at the stations can serve.

    The share of an order is the number of its lines whose SKU is on a pod at or bound for any station, divided by the
    number of its lines. Ties go to the older order.

    Parameters
    ----------
    n
        How many orders to keep.
    lines
        Which lines of an order that was split over time count: ``"all"`` as the paper says, or only those that are
        still ``"open"``, which favours orders that can be completed. It matters to rules that split over time only.

    References
    ----------
    L. Xie, N. Thieme, R. Krenzler, H. Li: Efficient order picking methods in robotic mobile fulfillment systems,
    Section 4.2. arXiv:1902.03092, 2019. https://doi.org/10.48550/arXiv.1902.03092
    """

    n: int = field(validator=validators.ge(1))
    lines: str = field(default="all", validator=validators.in_(("all", "open")))

    @hookimpl
    def filter_backlog(self, warehouse: WarehouseView, orders: Sequence[Order]) -> Sequence[Order]:
        """Keep the orders with the highest shares."""
        pods = {pod for station in warehouse.stations for pod in station.inbound_pods}
        there = {sku for pod in pods for sku in pod.contents if pod.contents[sku] > 0}
        whole = len(orders) == len(warehouse.backlog)  # unless another filter was there first
        lines = warehouse.backlog_lines if whole else lines_of(orders)
        is_there = np.zeros(warehouse.n_skus, dtype=bool)
        is_there[list(there)] = True
        covered = np.bincount(lines.order, weights=is_there[lines.sku], minlength=len(orders))
        counted = np.bincount(lines.order, minlength=len(orders))
        if self.lines == "all":
            of_order = np.fromiter(map(len, map(attrgetter("lines"), orders)), np.int64, len(orders))
            for begun in np.flatnonzero(counted < of_order).tolist():
                covered[begun] = sum(line.sku in there for line in orders[begun].lines)
            counted = of_order
        best = np.argsort(-covered / counted, kind="stable")[: self.n]
        return [orders[position] for position in best.tolist()]
