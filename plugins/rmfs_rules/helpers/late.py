"""Orders that have waited too long: they go first, and stations are kept for orders that fit nowhere."""

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
        How long an order may wait. None: as long as it takes, except for the oldest order if it is larger than any
        station: it waits `OVERSIZE_WAIT_S`, and as long as a station picks another one as large. Under overload such
        orders would else take all stations, and all others wait.
    """
    lines, largest = warehouse.lines, warehouse.largest_capacity
    items = lines.items
    if max_wait_s is not None:
        return [*np.flatnonzero((items > 0) & (warehouse.now_s - lines.arrival_s >= max_wait_s)).tolist()]
    if not len(items) or items[items.argmax()] <= largest:  # `max` takes ten times as long
        return []
    oldest = int((items > 0).argmax())
    if items[oldest] <= largest or warehouse.now_s - lines.arrival_s[oldest] < OVERSIZE_WAIT_S:
        return []
    at_work = (request.order for station in warehouse.stations for request in station.open_requests)
    return [] if any(order.items > largest for order in at_work) else [oldest]


def assign_late(
    warehouse: WarehouseView,
    max_wait_s: float | None,
    free: NDArray[np.int64],
    assign: Callable[[int], bool],
) -> None:
    """Assign the orders that are `late`, oldest first.

    Each that fits nowhere keeps one station, the one with most free capacity that could take it, from taking anything
    else.

    Parameters
    ----------
    warehouse, max_wait_s
        See there.
    free
        Free capacity by station; `SHUT` for stations that are kept from then on.
    assign
        Assigns the order at a row if it fits anywhere, and says whether it does.
    """
    kept: set[int] = set()
    for row in late(warehouse, max_wait_s):
        if not assign(row):
            order = warehouse.order(int(warehouse.lines.order_id[row]))
            at = station_to_keep(warehouse, order, dict(enumerate(free)), kept)
            if at is not None:
                kept.add(at)
                free[at] = SHUT
        if len(kept) == sum(station.open for station in warehouse.stations):
            break


def station_to_keep(
    warehouse: WarehouseView, order: Order, free: Mapping[int, int], kept: Container[int]
) -> int | None:
    """Return the station with most free capacity that could take an order if it took nothing else."""
    sizes = {station: warehouse.size_at(order, station) for station in warehouse.stations if station.open}
    able = [
        (size - free.get(station.id, 0), station.id)
        for station, size in sizes.items()
        if station.id not in kept and size <= station.capacity
    ]
    return min(able)[1] if able else None
