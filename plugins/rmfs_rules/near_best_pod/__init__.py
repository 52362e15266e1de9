"""POA rule ``near-best-pod``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define
from numpy.typing import NDArray

from rmfs_core import OrderAssignment, hookimpl
from rmfs_core.warehouse import STORED
from rmfs_rules.helpers.pairs import PairOptions
from rmfs_rules.helpers.sending import ticks_from

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, Stock, WarehouseView


@define
class NearBestPod(PairOptions):
    """Assign each order to the station that is nearest to a pod with most of it.

    The oldest order that fits anywhere (or as ``tie_break`` says) goes next. The best pods for it are those of the pods
    not in use with the highest

        sum over the SKUs i of the order of min(d_i, n_ip),

    d_i items wanted and n_ip free items on pod p. Of the stations where the order fits, the one is taken to which one
    of these pods has the shortest loaded driving time; ties go to the station with the lowest load, then to the one
    with the lowest id. This is repeated until nothing fits.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8
    """

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[OrderAssignment]:
        """Assign orders near their best pods; only the pods of orders whose turn it is are looked at."""
        lines, stock = warehouse.lines, warehouse.stock
        best: dict[int, NDArray[np.int64]] = {}

        def drive(row: int, station: Station) -> int:
            if row not in best:
                best[row] = with_most(stock, lines.of_order(row))
            return int(ticks_from(warehouse, stock.cell[best[row]], station).min()) if len(best[row]) else 0

        return self.assign(warehouse, rng, prefer=drive)


def with_most(stock: Stock, wanted: Iterable[tuple[int, int]]) -> NDArray[np.int64]:
    """Return the stored pods bound nowhere with most free items of what is wanted, SKUs and numbers, if any."""
    items = np.zeros(len(stock.at), np.int64)
    for sku, number in wanted:
        entries = stock.by_sku[stock.of_sku[sku] : stock.of_sku[sku + 1]]
        items[stock.pod[entries]] += np.minimum(stock.items[entries], number)
    items[stock.at != STORED] = 0
    return np.flatnonzero((items > 0) & (items == items.max(initial=0)))
