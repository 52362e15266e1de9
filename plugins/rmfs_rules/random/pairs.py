"""Pairs of order and station that are drawn one after another."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_core import OrderAssignment
from rmfs_rules.helpers.late import assign_late
from rmfs_rules.helpers.pairs import places_taken

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView


def draw_pairs(warehouse: WarehouseView, rng: np.random.Generator, max_wait_s: float | None) -> list[OrderAssignment]:
    """Assign whole orders, again and again one of the pairs of order and station that fit; late orders first.

    Parameters
    ----------
    warehouse
        The warehouse now.
    rng
        Draws lots.
    max_wait_s
        How long an order may wait, as `assign_late` has it.
    """
    lines, stations, drawn = warehouse.lines, warehouse.stations, list[OrderAssignment]()
    left, free = lines.items > 0, np.array([station.free_capacity for station in stations])
    sizes = np.empty((len(stations), len(left)), np.int64)
    placed = places_taken(warehouse)
    for at, station in enumerate(stations):
        sizes[at] = np.where(lines.items > warehouse.largest_capacity, station.capacity, lines.items)
        if station.counts_orders:
            sizes[at] = ~placed[at] if placed.size else 1

    def draw(among: NDArray[np.bool_]) -> bool:
        """Assign one of some orders, if any fits; say whether. Lots count stations, then sizes, then orders by id."""
        fits = among & (sizes <= free[:, None])
        up_to = np.count_nonzero(fits, axis=1).cumsum()
        if not len(up_to) or not up_to[-1]:
            return False
        lot = int(rng.integers(up_to[-1]))
        at = int(up_to.searchsorted(lot, side="right"))
        rows = np.flatnonzero(fits[at])
        rows = rows[np.lexsort((lines.order_id[rows], lines.items[rows]))]
        row = rows[lot - up_to[at]]  # counted from the last one
        drawn.append(OrderAssignment(int(lines.order_id[row]), at))
        free[at] -= sizes[at, row]
        left[row] = False
        return True

    assign_late(warehouse, max_wait_s, free, lambda row: draw(left & (np.arange(len(left)) == row)))
    while draw(left):
        pass
    return drawn
