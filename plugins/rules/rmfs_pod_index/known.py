"""What pod-index remembers of a run, so that it need not look again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_pod_index.compiled import NONE, Shelves, sorted_by_sku, unknown

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, WarehouseView

NEVER = 1 << 62
"""A tick that no run comes to."""


class Known:
    """What does not change in a run: nothing here makes a decision another one, it is only found sooner."""

    def __init__(self, warehouse: WarehouseView) -> None:
        free = warehouse.free_items
        by_sku, first_with = sorted_by_sku(free.sku, warehouse.n_skus)
        first = np.searchsorted(free.pod, np.arange(len(warehouse.pods) + 1))
        self.shelves = Shelves(first, free.sku, free.pod, first_with, by_sku)
        self.nothing = np.zeros(warehouse.n_skus, np.int64)
        self.arrival = np.zeros(0, np.int64)
        self.due_s = np.zeros(0)
        self.priority = np.zeros(0)
        self.equal = True
        self.largest = 0
        self.settled: tuple[object, ...] | None = None
        self.quiet: Sequence[Order] | None = None
        self.quiet_until = NEVER

    def nothing_to_do(self, warehouse: WarehouseView, room: Sequence[int]) -> bool:
        """Whether the last decision left free what it could not fill, and nothing has come since that could.

        What pods have free at their stations only becomes less, so with the same backlog no line is covered that was
        not; and no pod is sent until one is urgent.
        """
        backlog, tick = warehouse.backlog, warehouse.now_tick
        if self.settled == (tick, len(backlog), *room, *(len(station.inbound_pods) for station in warehouse.stations)):
            self.settled = None
            self.quiet = backlog if self.quiet_until != NEVER else None
            return True
        self.settled = None
        at_work = any(station.load for station in warehouse.stations)
        return backlog is self.quiet and tick < self.quiet_until and at_work and min(room) >= self.largest

    def learn(self, warehouse: WarehouseView, ids: NDArray[np.int64]) -> None:
        """Look at the orders that have come since the last time."""
        for i in unknown(ids, self.arrival).tolist():
            if i >= len(self.arrival):
                more = 2 * i + 64 - len(self.arrival)
                self.arrival = np.append(self.arrival, np.full(more, NONE))
                self.due_s, self.priority = (np.append(old, np.zeros(more)) for old in (self.due_s, self.priority))
            order = warehouse.order(i)
            self.arrival[i] = order.arrival_tick
            self.due_s[i] = np.inf if order.due_s is None else order.due_s
            self.priority[i] = order.priority
            self.equal = self.equal and order.due_s is None and not order.priority
