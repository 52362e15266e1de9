"""Filter ``most-covered``: the paper's prefilter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import NOTHING, define, validators

from rmfs_core import hookimpl
from rmfs_core.warehouse import columns_of
from rmfs_rules.helpers.parameters import AT_LEAST_1, parameter

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, WarehouseView


@define
class MostCovered:
    """Keep the n orders with the highest share of lines that pods at the stations can serve.

    The share of an order is the number of its lines whose SKU is on a pod at or bound for any station, divided by the
    number of its lines. Ties go to the older order.

    References
    ----------
    L. Xie, N. Thieme, R. Krenzler, H. Li: Efficient order picking methods in robotic mobile fulfillment systems,
    Section 4.2. arXiv:1902.03092, 2019. https://doi.org/10.48550/arXiv.1902.03092
    """

    n: int = parameter(NOTHING, AT_LEAST_1, "How many orders to keep")
    lines: str = parameter(
        "all",
        validators.in_(("all", "open")),
        'Which lines of an order that was split over time count: "all" as the paper says, or only lines that are still '
        '"open", which favours orders that can be completed. It matters to rules that split over time only',
    )

    @hookimpl
    def filter_backlog(self, warehouse: WarehouseView, orders: Sequence[Order]) -> Sequence[Order]:
        """Keep the orders with the highest shares."""
        pods = {pod for station in warehouse.stations for pod in station.inbound_pods}
        is_there = np.zeros(warehouse.n_skus, np.bool_)
        is_there[[sku for pod in pods for sku, items in pod.contents.items() if items > 0]] = True
        whole = len(orders) == warehouse.backlog_size  # unless another filter was there first
        lines = warehouse.lines if whole else columns_of(orders, warehouse.n_skus)
        counted = np.diff(lines.begin) if self.lines == "all" else lines.open_lines
        counts = is_there[lines.sku] if self.lines == "all" else is_there[lines.sku] & (lines.quantity > 0)
        covered = np.bincount(lines.order[counts], minlength=len(counted))
        waiting = lines.open_lines > 0
        some = np.flatnonzero(waiting & (covered > 0))
        best = some[np.argsort(-covered[some] / counted[some], kind="stable")]
        if len(best) < self.n:  # and the oldest of those with none
            best = np.concatenate([best, np.flatnonzero(waiting & (covered == 0))])
        return [warehouse.order(order) for order in lines.order_id[best[: self.n]].tolist()]
