"""What pod-index remembers of a run, so that it need not look again."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rmfs_core.clock import to_ticks
from rmfs_rules.helpers import largest_capacity
from rmfs_rules.pod_index.account import join, move, update
from rmfs_rules.pod_index.period import CLOSE, NONE, OF_LINES, Account, Ints, Period, new_account
from rmfs_rules.pod_index.urging import next_urgent

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView
    from rmfs_rules.pod_index.rule import PodIndex

NEVER = 1 << 62
"""A tick that no run comes to."""
NOWHERE = np.zeros((0, 3), np.int64)
"""No pod that is elsewhere."""
NO_SHARE = 2.0
"""Share of its places that are taken of a station to which no pod may be sent."""


class Known:
    """What was seen and worked out before: nothing here makes a decision another one, it is only found sooner.

    Attributes
    ----------
    account
        The lines of the backlog, the free items, and where pods are.
    room, load, inbound, at_work
        Of each picking station: free places, places that are taken, pods at or bound for it; whether any has places
        that are taken.
    counts_orders
        Whether places of any of them are for orders.
    need
        What the ages of a pod's lines have to add up to for it to be sent anywhere; NEVER where none may be sent.
    wakes
        When to wake up, or NEVER.
    """

    def __init__(self, rule: PodIndex, warehouse: WarehouseView) -> None:
        self.rule, self._pods, self._stations = rule, warehouse.pods, warehouse.stations
        self._log, self._free = warehouse.backlog_log(), warehouse.free_items_log()
        to = [warehouse.travel.times_to(station.cell, True).min(axis=1) for station in self._stations]
        free = self._free.items
        self._entries, self._order = len(free.sku), np.lexsort((free.sku, free.pod))  # as the account has them
        self._place, self._ordered = self._order.argsort(), self._free.ordered == len(free.sku)
        self.account = new_account(
            free.pod[self._order], free.sku[self._order], len(self._pods), warehouse.n_skus, np.array(to)
        )
        for name in ("capacity", "counts_orders"):
            self.account.period.stations[name] = [getattr(station, name) for station in self._stations]
        weigh(self.account.period, rule)
        self._joined = self._left = self._largest = self._changed = 0
        self._lines_left: list[int] = []
        self._moved, self._moves = [*range(len(self._pods))], len(warehouse.changed_pods())
        self.urge_ticks = 0
        self._settled: tuple[object, ...] | None = None
        self._quiet_room: list[int] | None = None
        self._first: tuple[int, int] | None = None
        self._front: list[tuple[int, int]] | None = None
        self._base, self._size = int(self.account.period.weights["base_ticks"][0]), NONE
        n_stations = len(to)
        self.room, self.load, self.inbound = [0] * n_stations, [0] * n_stations, [0] * n_stations
        self._counted, self._shares = [-1] * n_stations, [NO_SHARE] * n_stations
        self.counts_orders = any(station.counts_orders for station in self._stations)
        self._limit = largest_capacity(warehouse)
        self.at_work, self.need, self.wakes = False, NEVER, NEVER
        self._changes = -1
        self._quiet_until = self._wakes_until = 0

    def is_of(self, warehouse: WarehouseView) -> bool:
        """Whether it is what is known of a run, in which no pod was given a new SKU since."""
        known = self._log is warehouse.backlog_log() and self._free is warehouse.free_items_log()
        return known and self._entries == len(self._free.items.sku)

    @property
    def oversize(self) -> bool:
        """Whether some line, of an order that may be gone, has more items than any station takes."""
        return self._largest > self._limit

    def hear(self, warehouse: WarehouseView) -> None:
        """Take in what joined and left the backlog since the last time, and look at the stations."""
        if self._changes == warehouse.changes():
            return
        self._changes, self._quiet_until, self._wakes_until = warehouse.changes(), 0, 0
        left, size, before = self._log.left(self._left), warehouse.backlog_size, self._size
        self._size = NONE if warehouse.filtered else size
        # Orders have joined only if there are more than before: none has gone where no line has
        if left or size != before or warehouse.filtered:
            self._hear_lines(warehouse, left)
        self._see()

    def _hear_lines(self, warehouse: WarehouseView, left: list[int]) -> None:
        """Take in the lines that joined and left the backlog."""
        joined = self._log.joined(self._joined)
        if joined.size:
            self._take_in(self.account, warehouse, joined, self._joined)
            self._joined += joined.shape[1]
            if self.rule.urge_s and not self.urge_ticks:
                orders = warehouse.orders
                # Pods wait for lines to come once some have come
                if orders[-1].arrival_tick > orders[0].arrival_tick:
                    self.urge_ticks = to_ticks(self.rule.urge_s)
                    self.account.period.weights["urge_ticks"] = self.urge_ticks
        if left:
            self._lines_left += left
            self._left += len(left)
        if joined.size or left:
            self._quiet_room = self._first = self._front = None

    def _look(self, warehouse: WarehouseView) -> None:
        """Bring the account of lines and free items up to date."""
        changed = self._free.changed(self._changed)
        if len(changed) or self._lines_left or self._front is None:
            left, items = np.array(self._lines_left, np.int64), self._free.items.number
            places = changed
            if not self._ordered:
                places, items = self._place[changed], items[self._order]
                items.setflags(write=False)  # as the log's, so that nothing is compiled for it
            number = update(*self.account.parts, warehouse.now_tick, left, places, items)
            self._changed += len(changed)
            self._lines_left, self._first, self._front = [], None, self.account.period.front[:number].tolist()
            self._quiet_until = self._wakes_until = 0

    def shown(self, warehouse: WarehouseView) -> tuple[Account, Ints]:
        """Return the account, or one of the lines that filters have left, and the pods to be moved in it."""
        self._look(warehouse)
        moved = self._where(warehouse)
        if not warehouse.filtered:
            return self.account, moved
        move(*self.account.parts, moved)
        account = self.account.without_lines()
        lines = warehouse.backlog_lines
        if len(lines.order):
            self._take_in(account, warehouse, np.array([lines.order_id, lines.sku, lines.quantity]), 0)
        return account, NOWHERE

    def _where(self, warehouse: WarehouseView) -> Ints:
        """Return the pods that may be elsewhere than before, where each goes last, and its cell if it is free."""
        moved, rows = warehouse.changed_pods(self._moves), []
        self._moves += len(moved)
        for i in {*self._moved, *moved}:
            pod, last = self._pods[i], NONE
            for station in pod.bound_for:
                if station < len(self.room):  # those where bundles are stored and nothing is picked have higher ids
                    last = station
            rows.append((i, last, pod.cell if last == NONE and pod.robot is None else NONE))
        self._moved = []
        return np.array(rows, np.int64) if rows else NOWHERE

    def _take_in(self, account: Account, warehouse: WarehouseView, rows: Ints, begin: int) -> None:
        """Take lines into an account, whose order, SKU and number of items are given; ``begin`` are there."""
        ids, _, items = rows.tolist()
        account.make_room(dict.fromkeys(OF_LINES, begin + len(ids)) | dict.fromkeys(("orders", "looked"), max(ids) + 1))
        orders = []
        for i in dict.fromkeys(ids):
            order = warehouse.order(i)
            worth = self.rule.priority_factor ** min(max(order.priority, -20), 20)
            due_s, most = (np.inf, 1.0) if order.due_s is None else (order.due_s, self.rule.due_factor)
            orders.append((i, order.arrival_tick, due_s, worth, (1 + CLOSE) * worth * most))
        join(*account.parts, begin, rows, np.array(orders, np.float64))
        self._largest = max(self._largest, *items)

    def settle(
        self, warehouse: WarehouseView, left: int, room: list[int], inbound: list[int], *, nothing: bool
    ) -> None:
        """Note how a decision leaves the warehouse, in which nothing is left to decide, and whether it did nothing."""
        if nothing:
            self._quiet_room = room.copy()
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
        room, settled, self._settled = self.room, self._settled, None
        if warehouse.filtered:
            return False
        if settled is not None and settled == (warehouse.now_tick, warehouse.backlog_size, room, self.inbound):
            self._quiet_room = room.copy()
            return True
        quiet = self._quiet_room
        if quiet is None or warehouse.replenishment_stations:
            return False
        if room != quiet and any(a < b and a < self._largest for a, b in zip(quiet, room, strict=True)):
            return False
        until = NEVER
        if self.need != NEVER:
            if not (self.urge_ticks and self.at_work):
                return False
            until = self._first_urgent(warehouse)
        self._quiet_until = until
        return until > warehouse.now_tick

    def wake(self, warehouse: WarehouseView) -> None:
        """Work out when the ages of the lines of a pod will add up, if a station could take it then."""
        waits = self.urge_ticks and warehouse.backlog_size and self.at_work and self.need != NEVER
        self.wakes = self._first_urgent(warehouse) if waits else NEVER
        if self.wakes <= warehouse.now_tick:
            soonest = next_urgent(*self.account.parts, warehouse.now_tick, self.need)
            self.wakes = NEVER if soonest == NONE else int(soonest)
        self._wakes_until = 0 if warehouse.replenishment_stations else self.wakes

    def _see(self) -> None:
        """Look at the stations that have changed."""
        for i, station in enumerate(self._stations):
            changes = station.changes()
            if changes != self._counted[i]:
                room, load, inbound = station.free_capacity, station.load, len(station.inbound_pods)
                self._counted[i], self.room[i], self.load[i], self.inbound[i] = changes, room, load, inbound
                able = room and inbound < self.rule.most_pods
                self._shares[i] = min(load / station.capacity, 1.0) if able else NO_SHARE
        self.at_work, share = any(self.load), min(self._shares)
        self.need = NEVER if share == NO_SHARE else int(self.urge_ticks * (1 + (self.rule.full - 1) * share))

    def _first_urgent(self, warehouse: WarehouseView) -> int:
        """Return when the ages of the lines of a pod first add up to so many, which may be over, or NEVER."""
        need, known = self.need, self._first
        # With the same backlog, what pods have free that are bound for no station only changes by replenishment
        if known is None or known[0] != need or warehouse.now_tick >= known[1] or warehouse.replenishment_stations:
            self._look(warehouse)
            times = [-(-(need + arrivals) // lines) for lines, arrivals in self._front or ()]
            known = self._first = need, min(times) - self._base if times else NEVER
        return known[1]


def weigh(period: Period, rule: PodIndex) -> None:
    """Fill in the rule's parameters as the compiled parts take them; no pod waits."""
    weights = period.weights
    for name in ("handle_s", "cost_s", "finish", "visit_s", "stay", "elsewhere", "full", "near", "due_factor", "due_s"):
        weights[name] = getattr(rule, name)
    weights["most_pods"], weights["base_ticks"] = rule.most_pods, to_ticks(rule.base_s)
    weights["packing"] = rule.packing_capacity is not None
    period.least[:] = np.arange(len(period.least)) ** float(rule.finish)
