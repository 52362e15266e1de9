"""What pod-index remembers of a run, so that it need not look again."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import to_ticks
from rmfs_pod_index.compiled import grouped, sorted_by_sku, unknown
from rmfs_pod_index.period import NONE, Shelves, Weights
from rmfs_pod_index.urging import needed, next_urgent, urges

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, WarehouseView
    from rmfs_pod_index.rule import PodIndex

NEVER = 1 << 62
"""A tick that no run comes to."""


class Grouped(NamedTuple):
    """What `grouped` returns.

    Parameters
    ----------
    ids, open_items
        Of each order of the backlog.
    by_sku, first, wanted
        Its lines sorted by SKU; where those of SKU i begin; the SKUs that have any, ascending.
    """

    ids: NDArray[np.int64]
    open_items: NDArray[np.int64]
    by_sku: NDArray[np.int64]
    first: NDArray[np.int64]
    wanted: NDArray[np.int64]


class Known:
    """What was seen and worked out before: nothing here makes a decision another one, it is only found sooner."""

    def __init__(self, rule: PodIndex, warehouse: WarehouseView) -> None:
        free = warehouse.free_items
        by_sku, first_with = sorted_by_sku(free.sku, warehouse.n_skus)
        first = np.searchsorted(free.pod, np.arange(len(warehouse.pods) + 1))
        self.pods, self.held = warehouse.pods, free.pod
        self.shelves = Shelves(first, free.sku, free.pod, first_with, by_sku)
        self.rule = rule
        self.weights = weights_of(rule, waits=False)
        self.nothing = np.zeros(warehouse.n_skus, np.int64)
        self.ages_of_skus = np.zeros(warehouse.n_skus, np.int64)
        self.available = np.zeros((len(warehouse.stations), warehouse.n_skus), np.int64)
        self.in_available = np.zeros(0, np.int64)
        self._least = np.zeros(0)
        self._base_ticks = to_ticks(rule.base_s)
        self._looked_at: object = None
        self.cells = np.array([pod.cell for pod in self.pods], np.int64)
        self.moving = {pod.id for pod in self.pods if pod.location is None}
        self._ticks: NDArray[np.int64] | None = None
        self.arrival = np.zeros(0, np.int64)
        self.due_s = np.zeros(0)
        self.priority = np.zeros(0)
        self.equal = True
        self._settled: tuple[object, ...] | None = None
        self._largest = 0
        self._quiet: Sequence[Order] | None = None
        self._quiet_room: Sequence[int] = ()
        self._urged = self.nothing, self.nothing
        self._urged_tick = 0
        self._urged_of: Sequence[Order] | None = None

    def hear(self, warehouse: WarehouseView) -> None:
        """Let pods wait for lines to come once orders have come after the first ones."""
        if self.rule.urge_s and not self.weights.urge_ticks:
            orders = warehouse.orders
            if orders and orders[-1].arrival_tick > orders[0].arrival_tick:
                self.weights = weights_of(self.rule, waits=True)

    def look(self, warehouse: WarehouseView) -> Grouped:
        """Return what there is to know of the lines of the backlog, with every order known."""
        lines = warehouse.backlog_lines
        if lines is not self._looked_at:
            self._looked_at = lines
            self._looked = Grouped(*grouped(lines.order, lines.order_id, lines.sku, lines.quantity, warehouse.n_skus))
            self.learn(warehouse, self._looked.ids)
        return self._looked

    def ages(self, warehouse: WarehouseView) -> NDArray[np.int64]:
        """Of each order, its age in ticks, and what a line counts besides."""
        ages: NDArray[np.int64] = warehouse.now_tick + self._base_ticks - self.arrival[self.look(warehouse).ids]
        return ages

    def settle(
        self, warehouse: WarehouseView, left: int, room: Sequence[int], inbound: Sequence[int], *, nothing: bool
    ) -> None:
        """Note how a decision leaves the warehouse, in which nothing is left to decide, and whether it did nothing."""
        self._largest = int(warehouse.backlog_lines.quantity.max(initial=0))
        if nothing:
            self._quiet, self._quiet_room = warehouse.backlog, room
        else:
            self._settled = warehouse.now_tick, left, room, inbound

    def nothing_to_do(self, warehouse: WarehouseView, room: Sequence[int]) -> bool:
        """Whether the last decision left free what it could not fill, and nothing has come since that could.

        What pods have free at their stations only becomes less, so with the same backlog no line is covered that was
        not; and no pod is sent to a station that has enough of them, or before one is urgent. Replenished, they may.
        """
        backlog, inbound = warehouse.backlog, [len(station.inbound_pods) for station in warehouse.stations]
        settled, self._settled = self._settled, None
        if settled == (warehouse.now_tick, len(backlog), room, inbound):
            self._quiet, self._quiet_room = backlog, room
            return True
        if backlog is not self._quiet or warehouse.replenishment_stations:
            return False
        if any(then < now and then < self._largest for then, now in zip(self._quiet_room, room, strict=True)):
            return False
        needs = self.needs(warehouse, room, inbound)
        if not needs:
            return True
        if not self.weights.urge_ticks or not any(station.load for station in warehouse.stations):
            return False
        return not self.next_urgent(warehouse, min(needs))[1]

    def needs(self, warehouse: WarehouseView, room: Sequence[int], inbound: Sequence[int]) -> list[int]:
        """Return what ages have to add up to for each of the stations that one more pod could be sent to."""
        stations, ticks, full = warehouse.stations, self.weights.urge_ticks, self.weights.full
        few = [
            s for s, free, pods in zip(stations, room, inbound, strict=True) if free and pods < self.weights.most_pods
        ]
        return [needed(station.load, station.capacity, ticks, full) for station in few]

    def next_urgent(self, warehouse: WarehouseView, need: int) -> tuple[int, bool]:
        """Return when the ages of the lines of the next pod add up to so many, or NEVER; and whether one's do now."""
        if self._urged_of is not warehouse.backlog:
            found, items = self.look(warehouse), warehouse.free_items.number
            lines = warehouse.backlog_lines.order, self.ages(warehouse), found.by_sku, found.first, found.wanted
            enough = needed(1, 1, self.weights.urge_ticks, self.weights.full)
            self._urged = urges(lines, len(self.pods), self.shelves, items, enough)
            self._urged_of, self._urged_tick = warehouse.backlog, warehouse.now_tick
        passed = warehouse.now_tick - self._urged_tick
        total, number = self._urged
        soonest, now = next_urgent(total, number, passed, need)
        return NEVER if soonest == NONE else warehouse.now_tick + int(soonest), bool(now)

    def ticks(self, warehouse: WarehouseView) -> NDArray[np.int64]:
        """Shortest loaded driving time to each station from each cell, whatever way the robot faces."""
        if self._ticks is None:
            to = [warehouse.travel.times_to(station.cell, True).min(axis=1) for station in warehouse.stations]
            self._ticks = np.array(to)
        return self._ticks

    def find(self, busy: Iterable[int], leaving: Iterable[int]) -> None:
        """Look where pods are that were on the move when last seen, and those that leave a station."""
        for pod in self.moving.difference(busy).union(leaving):
            self.cells[pod] = self.pods[pod].cell
        self.moving = set(busy)

    def least_powers(self, items: int) -> NDArray[np.float64]:
        """Return the least that seconds are divided by, for orders with up to so many items left."""
        if items >= len(self._least):
            self._least = np.power(self.weights.handle_s * np.arange(2 * items + 2), self.weights.finish)
        return self._least

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


def weights_of(rule: PodIndex, *, waits: bool) -> Weights:
    """Return the rule's parameters as the compiled parts take them, and whether pods wait."""
    return Weights(
        float(rule.handle_s),
        float(rule.cost_s),
        float(rule.finish),
        float(rule.visit_s),
        float(rule.stay),
        float(rule.elsewhere),
        int(rule.most_pods),
        to_ticks(rule.urge_s) if waits else 0,
        float(rule.full),
        rule.packing_capacity is not None,
        float(rule.near),
    )
