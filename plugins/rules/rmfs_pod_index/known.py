"""What pod-index remembers of a run, so that it need not look again."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import to_ticks
from rmfs_pod_index.account import join, sorted_by_sku, update
from rmfs_pod_index.period import (
    CLOSE,
    NONE,
    OF_LINES,
    OF_ORDERS,
    PACKED,
    Period,
    Shelves,
    Weights,
    new_period,
    with_arrays,
    with_room,
)
from rmfs_pod_index.urging import next_urgent

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView
    from rmfs_pod_index.rule import PodIndex

NEVER = 1 << 62
"""A tick that no run comes to."""
MOST_SECONDS = 4096
"""Of how many seconds the power is kept in a table."""


class Seen(NamedTuple):
    """The picking stations at one moment.

    Parameters
    ----------
    room, load, inbound
        Of each: free places, places that are taken, pods at or bound for it.
    need
        What the ages of a pod's lines have to add up to for it to be sent anywhere; None where none may be sent.
    """

    room: list[int]
    load: list[int]
    inbound: list[int]
    need: int | None


class Known:
    """What was seen and worked out before: nothing here makes a decision another one, it is only found sooner.

    Attributes
    ----------
    period
        The account of the lines of the backlog and of free items.
    shelves, weights, pods
        Which pods have which SKUs; the rule's parameters; the pods.
    cells
        Of each pod: where it was when it was asked last.
    seen
        The stations as they are.
    wakes
        When to wake up, or NEVER.
    """

    def __init__(self, rule: PodIndex, warehouse: WarehouseView) -> None:
        free = warehouse.free_items
        by_sku, first_with = sorted_by_sku(free.sku, warehouse.n_skus)
        first = np.searchsorted(free.pod, np.arange(len(warehouse.pods) + 1))
        self.pods, self._held = warehouse.pods, free.pod
        self.shelves = Shelves(first, free.sku, free.pod, first_with, by_sku)
        self.rule = rule
        self.weights = weights_of(rule, waits=False)
        self.period = self._empty(warehouse)
        self.cells = np.array([pod.cell for pod in self.pods], np.int64)
        self._log = warehouse.backlog_log()
        self._joined = self._left = self._largest = 0
        self._leaving: list[int] = []
        self._items: object = None
        self._no_items = free.number[:0]
        self._ticks: NDArray[np.int64] | None = None
        self._settled: tuple[object, ...] | None = None
        self._quiet_room: list[int] | None = None
        self._next: tuple[int, int, bool] | None = None
        self.seen, self.wakes = Seen([], [], [], None), NEVER
        self._changes = -1
        self._quiet_until = self._wakes_until = 0

    def is_of(self, warehouse: WarehouseView) -> bool:
        """Whether it is what is known of a run, in which no pod was given a new SKU."""
        if self._log is not warehouse.backlog_log():
            return False
        return not warehouse.replenishment_stations or warehouse.free_items.pod is self._held

    def hear(self, warehouse: WarehouseView) -> None:
        """Take in what joined and left the backlog since the last time, and look at the stations."""
        if self._changes == warehouse.changes():
            return
        self._changes, self._quiet_until, self._wakes_until = warehouse.changes(), 0, 0
        joined, left = self._log.joined(self._joined), self._log.left(self._left)
        if joined.size:
            self.period = self.with_lines(self.period, warehouse, joined, self._joined)
            self._joined += joined.shape[1]
            if self.rule.urge_s and not self.weights.urge_ticks:
                orders = warehouse.orders
                # Pods wait for lines to come once some have come
                self.weights = weights_of(self.rule, waits=orders[-1].arrival_tick > orders[0].arrival_tick)
        if left:
            self._leaving += left
            self._left += len(left)
        if joined.size or left:
            self._quiet_room = self._next = None
        self.seen = self._see(warehouse)

    def look(self, warehouse: WarehouseView) -> None:
        """Bring the account of lines and free items up to date."""
        items = warehouse.free_items.number
        if items is not self._items or self._leaving:
            changed = items if items is not self._items else self._no_items
            update(self.period, np.array(self._leaving, np.int64), changed, self.shelves)
            self._items, self._leaving, self._next = items, [], None
            self._quiet_until = self._wakes_until = 0

    def with_lines(self, period: Period, warehouse: WarehouseView, rows: NDArray[np.int64], begin: int) -> Period:
        """Return a period with more lines, whose order, SKU and number of items are given; ``begin`` are there."""
        ids, n_orders, end = list(dict.fromkeys(rows[0].tolist())), int(rows[0].max()) + 1, begin + rows.shape[1]
        period = with_room(period, OF_LINES, end)
        period = with_room(period, OF_ORDERS + (PACKED if self.weights.packing else ()), n_orders)
        period.order[begin:end], period.sku[begin:end], period.quantity[begin:end] = rows
        for i in ids:
            order = warehouse.order(i)
            period.arrival[i] = order.arrival_tick
            period.due_s[i] = np.inf if order.due_s is None else order.due_s
            period.worth[i] = self.rule.priority_factor ** min(max(order.priority, -20), 20)
            period.highest[i] = (
                (1 + CLOSE) * period.worth[i] * (1.0 if order.due_s is None else self.weights.due_factor)
            )
        period.left[ids] = -1.0
        join(period, begin, end, self.shelves)
        self._largest = max(self._largest, int(rows[2].max()))
        return period

    def shown(self, warehouse: WarehouseView) -> Period:
        """Return the account, or one of the lines that filters have left."""
        self.look(warehouse)
        if not warehouse.filtered:
            return self.period
        period = self._empty(warehouse)
        update(period, np.zeros(0, np.int64), warehouse.free_items.number, self.shelves)
        lines = warehouse.backlog_lines
        if not len(lines.order):
            return period
        return self.with_lines(period, warehouse, np.array([lines.order_id, lines.sku, lines.quantity]), 0)

    def _empty(self, warehouse: WarehouseView) -> Period:
        """Return an account without lines, and without items."""
        least = (np.arange(MOST_SECONDS) ** self.weights.finish).astype(np.float64)
        period = new_period(warehouse.n_skus, len(self.pods), len(warehouse.stations), len(self.shelves.sku))
        return with_arrays(period, {"least": least})

    def settle(
        self, warehouse: WarehouseView, left: int, room: list[int], inbound: list[int], *, nothing: bool
    ) -> None:
        """Note how a decision leaves the warehouse, in which nothing is left to decide, and whether it did nothing."""
        if nothing:
            self._quiet_room = room
        else:
            self._settled = warehouse.now_tick, left, room, inbound

    def still_nothing(self, warehouse: WarehouseView) -> bool:
        """Whether there was nothing to do, nothing has changed, and no pod is urgent that was not."""
        return warehouse.now_tick < self._quiet_until and self._same(warehouse) and not warehouse.filtered

    def still_wakes(self, warehouse: WarehouseView) -> bool:
        """Whether nothing has changed since it was worked out when to wake up, and that is not over."""
        return warehouse.now_tick < self._wakes_until and self._same(warehouse)

    def _same(self, warehouse: WarehouseView) -> bool:
        return warehouse.changes() == self._changes and warehouse.backlog_log() is self._log

    def nothing_to_do(self, warehouse: WarehouseView) -> bool:
        """Whether the last decision left free what it could not fill, and nothing has come since that could.

        What pods have free at their stations only becomes less, so with the same backlog no line is covered that was
        not; and no pod is sent to a station that has enough of them, or before one is urgent. Replenished, they may.
        """
        (room, load, inbound, need), settled, self._settled = self.seen, self._settled, None
        if warehouse.filtered:
            return False
        if settled is not None and settled == (warehouse.now_tick, warehouse.backlog_size, room, inbound):
            self._quiet_room = room
            return True
        quiet = self._quiet_room
        if quiet is None or warehouse.replenishment_stations:
            return False
        if room != quiet and any(a < b and a < self._largest for a, b in zip(quiet, room, strict=True)):
            return False
        until, urgent = NEVER, False
        if need is not None:
            if not (self.weights.urge_ticks and any(load)):
                return False
            until, urgent = self.next_urgent(warehouse, need)
        self._quiet_until = 0 if urgent else until
        return not urgent

    def wake(self, warehouse: WarehouseView) -> None:
        """Work out when the ages of the lines of a pod will add up, if a station could take it then."""
        waits, need = self.weights.urge_ticks and warehouse.backlog_size and any(self.seen.load), self.seen.need
        self.wakes = self.next_urgent(warehouse, need)[0] if waits and need is not None else NEVER
        self._wakes_until = 0 if warehouse.replenishment_stations else self.wakes

    def _see(self, warehouse: WarehouseView) -> Seen:
        """Look at the stations."""
        most_pods, ticks, more = self.weights.most_pods, self.weights.urge_ticks, self.weights.full - 1
        stations = warehouse.stations
        room, load = [station.free_capacity for station in stations], [station.load for station in stations]
        inbound = [len(station.inbound_pods) for station in stations]
        shares = [
            min(taken, station.capacity) / station.capacity
            for station, free, taken, pods in zip(stations, room, load, inbound, strict=True)
            if free and pods < most_pods
        ]
        return Seen(room, load, inbound, int(ticks * (1 + more * min(shares))) if shares else None)

    def next_urgent(self, warehouse: WarehouseView, need: int) -> tuple[int, bool]:
        """Return when the ages of the lines of the next pod add up to so many, or NEVER; and whether one's do now."""
        now, known = warehouse.now_tick, self._next
        # With the same backlog, what pods have free that are bound for no station only changes by replenishment
        if known is None or known[0] != need or now >= known[1] or warehouse.replenishment_stations:
            self.look(warehouse)
            period, base = self.period, self.weights.base_ticks
            soonest, urgent = next_urgent(period.lines_of, period.arrivals_of, now, need, base)
            known = self._next = need, NEVER if soonest == NONE else int(soonest), bool(urgent)
        return known[1:]

    def ticks(self, warehouse: WarehouseView) -> NDArray[np.int64]:
        """Shortest loaded driving time to each station from each cell, whatever way the robot faces."""
        if self._ticks is None:
            to = [warehouse.travel.times_to(station.cell, True).min(axis=1) for station in warehouse.stations]
            self._ticks = np.array(to)
        return self._ticks


def weights_of(rule: PodIndex, *, waits: bool) -> Weights:
    """Return the rule's parameters as the compiled parts take them, and whether pods wait."""
    return Weights(
        handle_s=float(rule.handle_s),
        cost_s=float(rule.cost_s),
        finish=float(rule.finish),
        visit_s=float(rule.visit_s),
        stay=float(rule.stay),
        elsewhere=float(rule.elsewhere),
        most_pods=int(rule.most_pods),
        urge_ticks=to_ticks(rule.urge_s) if waits else 0,
        full=float(rule.full),
        base_ticks=to_ticks(rule.base_s),
        due_factor=float(rule.due_factor),
        due_s=float(rule.due_s),
        packing=rule.packing_capacity is not None,
        near=float(rule.near),
    )
