"""Orders that have waited too long: they go first, and stations are kept for those that fit nowhere."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rmfs_core.warehouse import Order, WarehouseView

OVERSIZE_WAIT_S = 600.0
"""How long an order that is larger than any station waits for an empty one before one is emptied for it, by default."""
SHUT = -1
"""Capacity of a station that is kept for an order: not even orders fit that take up none."""


def late(warehouse: WarehouseView, max_wait_s: float | None) -> list[int]:
    """Return the rows of the orders that have waited too long, oldest first.

    Parameters
    ----------
    warehouse
        The warehouse now.
    max_wait_s
        How long an order may wait. None: as long as it takes, but for an order that is larger than any station, which
        waits `OVERSIZE_WAIT_S`.
    """
    lines, limit_s, least = warehouse.lines, max_wait_s, 0
    if limit_s is None:
        limit_s, least = OVERSIZE_WAIT_S, warehouse.largest_capacity
        if lines.items.max(initial=0) <= least:
            return []  # nobody's arrival matters
    waited_s = warehouse.now_s - lines.arrival_s
    return [*np.flatnonzero((lines.items > least) & (waited_s >= limit_s)).tolist()]


def assign_late(
    warehouse: WarehouseView,
    max_wait_s: float | None,
    free: NDArray[np.int64],
    assign: Callable[[int], bool],
) -> None:
    """Assign the orders that are `late`, oldest first.

    Each that fits nowhere keeps one station, that with most room of those that could take it, from taking anything
    else. Without ``max_wait_s`` one order at a time does.

    Parameters
    ----------
    warehouse, max_wait_s
        See there.
    free
        Free capacity by station; `SHUT` for those that are kept from then on.
    assign
        Assigns the order at a row if it fits anywhere, and says whether it does.
    """
    lines, largest = warehouse.lines, warehouse.largest_capacity
    kept: dict[int, bool] = {}  # stations that are kept, and whether for an order that is larger than any station
    for row in late(warehouse, max_wait_s):
        if not assign(row) and (max_wait_s is not None or not any(kept.values())):
            order = warehouse.order(int(lines.order_id[row]))
            at = station_to_keep(warehouse, order, dict(enumerate(free)), kept)
            if at is not None:
                kept[at], free[at] = bool(lines.items[row] > largest), SHUT
        if len(kept) == sum(station.open for station in warehouse.stations):
            break


def station_to_keep(
    warehouse: WarehouseView, order: Order, free: Mapping[int, int], kept: Container[int]
) -> int | None:
    """Return the station with most room of those that could take an order if they took nothing else."""
    room = {station.id: free.get(station.id, 0) for station in warehouse.stations}
    lacking = {
        station.id: warehouse.size_at(order, station) - room[station.id]
        for station in warehouse.stations
        if station.open and station.id not in kept
    }
    able = [i for i in lacking if lacking[i] <= warehouse.stations[i].capacity - room[i]]
    return min(able, key=lambda identifier: (lacking[identifier], identifier), default=None)
