"""Pairs of order and station by lot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_core import OrderAssignment
from rmfs_rule_helpers import DOES_NOT_FIT

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView
    from rmfs_rule_helpers.open_orders import OpenOrders

LOTS = 1 << 62
"""Lots are whole numbers below this: two are hardly ever the same."""


def draw(rng: np.random.Generator, number: int) -> NDArray[np.int64]:
    """Draw lots."""
    if isinstance(rng.bit_generator, np.random.PCG64):  # the same numbers, in less than half the time
        return (rng.bit_generator.random_raw(number) >> np.uint64(2)).astype(np.int64)
    return rng.integers(LOTS, size=number)


def skip(rng: np.random.Generator, number: int) -> None:
    """Leave out lots that nobody looks at."""
    if isinstance(rng.bit_generator, np.random.PCG64):
        kept = rng.bit_generator.state  # half a number that a small draw has left over, which the others go past
        rng.bit_generator.advance(number)
        rng.bit_generator.state = {**kept, "state": rng.bit_generator.state["state"]}
    else:
        draw(rng, number)


def assign_by_lots(warehouse: WarehouseView, orders: OpenOrders, rng: np.random.Generator) -> list[OrderAssignment]:
    """Assign whole orders, again and again the pair of order and station with the highest lot that fits.

    That is what `assign_best_pairs` does with lots as scores, where no order is larger than any station.
    """
    number, chosen = len(orders.ids), []
    smallest = orders.items.min(initial=LOTS)
    free, load = [station.free_capacity for station in warehouse.stations], [s.load for s in warehouse.stations]
    lots: dict[int, NDArray[np.int64]] = {}
    for station in warehouse.stations:
        room = free[station.id]
        if room >= (1 if station.counts_orders else smallest):
            lots[station.id] = draw(rng, number)
            if not station.counts_orders:
                lots[station.id][orders.items > room] = DOES_NOT_FIT
        elif room > 0 or station.counts_orders:
            skip(rng, number)
    while lots and number:
        highest = {at: int(column.argmax()) for at, column in lots.items()}
        at = min(lots, key=lambda at: (-lots[at][highest[at]], highest[at], load[at], at))
        position = highest[at]
        if lots[at][position] == DOES_NOT_FIT:
            break
        chosen.append(OrderAssignment(int(orders.ids[position]), at))
        size = 1 if warehouse.stations[at].counts_orders else int(orders.items[position])
        free[at] -= size
        load[at] += size
        for column in lots.values():
            column[position] = DOES_NOT_FIT
        if free[at] == 0:
            del lots[at]
        elif not warehouse.stations[at].counts_orders:
            lots[at][orders.items > free[at]] = DOES_NOT_FIT
    return chosen
