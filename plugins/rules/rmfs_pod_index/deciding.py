"""A period of pod-index: what is seen in the warehouse, as arrays, and what is decided."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_core import JointDecision, OrderAssignment, PodTrip
from rmfs_pod_index.compiled import grouped, sorted_by_sku, unknown
from rmfs_pod_index.known import Known, weights_of
from rmfs_pod_index.period import (
    AT_WORK,
    COMPLETED,
    NONE,
    PACKING_ROOM,
    SENDS,
    TAKES,
    Period,
    Shelves,
)
from rmfs_pod_index.turns import decide
from rmfs_pod_index.urging import needed, next_urgent, urges

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, WarehouseView
    from rmfs_pod_index.rule import PodIndex


class Deciding:
    """A period under construction, around its compiled part."""

    def __init__(self, known: Known, warehouse: WarehouseView, room: Sequence[int]) -> None:
        self.rule, self.known, self.warehouse = known.rule, known, warehouse
        self.lines, self.items = warehouse.backlog_lines, warehouse.free_items.number
        self.ids, open_items, by_sku, first, wanted = known.look(warehouse)
        rule, stations, pods, lines = self.rule, warehouse.stations, known.pods, self.lines
        n_orders, packing = len(self.ids), rule.packing_capacity is not None
        inbound = [station.inbound_pods for station in stations]
        bound = {pod.id: pod for there in inbound for pod in there}  # one may be bound for several, to be replenished
        self.bound = list(bound)
        last = np.full(len(pods), NONE)
        last[self.bound] = [_last_of(pod, len(stations)) for pod in bound.values()]
        number = [len(there) for there in inbound]
        counts_orders = np.array([station.counts_orders for station in stations], np.bool_)
        backlog = warehouse.backlog if packing else ()
        split = np.array([bool(order.parts) for order in backlog], np.bool_)
        self.period = Period(
            order=lines.order,
            sku=lines.sku,
            quantity=lines.quantity,
            age=known.ages(warehouse) if known.weights.urge_ticks else np.zeros(0, np.int64),
            factor=self.factors(),
            by_sku=by_sku,
            first=first,
            wanted=wanted,
            share=np.zeros(warehouse.n_skus),
            left=np.full(n_orders, -1.0),
            power=np.empty(n_orders),
            open_items=open_items.copy(),
            least=known.least_powers(int(open_items.max(initial=0))),
            untaken=np.ones(len(lines.order), np.bool_),
            items=self.items,
            movable=self.movable() if known.needs(warehouse, room, number) else np.zeros(len(pods), np.bool_),
            last=last,
            ages=known.ages_of_skus,
            urge=np.zeros(len(pods), np.int64),
            available=known.available,
            room=np.array(room, np.int64),
            load=np.array([station.load for station in stations], np.int64),
            capacity=np.array([station.capacity for station in stations], np.int64),
            inbound=np.array(number, np.int64),
            counts_orders=counts_orders,
            open=np.array(room, np.int64) > 0,
            placed=self._placed(n_orders) if counts_orders.any() else np.zeros((0, 0), np.bool_),
            split=split,
            single=np.array([len(order.open_lines) == 1 for order in backlog], np.bool_),
            before=split.copy(),
            parts=np.zeros(len(backlog), np.int64),
            turn=np.zeros(len(stations), np.int64),
            takes=np.empty((len(lines.order), 2), np.int64),
            sends=np.empty((len(pods), 2), np.int64),
            found=np.empty(len(pods), np.int64),
            numbers=np.zeros(8, np.int64),
        )
        self.period.numbers[AT_WORK] = any(station.load for station in stations)
        self.period.numbers[PACKING_ROOM] = (rule.packing_capacity or 0) - warehouse.split_orders_open

    def factors(self) -> NDArray[np.float64]:
        """Of each order, how many times more a line of it is worth; empty where all are equal."""
        if self.known.equal:
            return np.zeros(0)
        rule, known = self.rule, self.known
        slack_s = np.maximum(known.due_s[self.ids] - self.warehouse.now_s, 0.0)
        due = 1.0 + (rule.due_factor - 1.0) * np.exp(-slack_s / rule.due_s)
        priority = np.minimum(np.maximum(known.priority[self.ids], -20), 20)
        factors: NDArray[np.float64] = due * rule.priority_factor**priority
        return factors

    def movable(self) -> NDArray[np.bool_]:
        """Pods that may be sent: stored or leaving, and bound nowhere else."""
        movable = np.ones(len(self.known.pods), np.bool_)
        busy = [*self.bound, *(robot.task for robot in self.warehouse.robots if robot.task is not None)]
        leaving = [pod.id for pod in self.warehouse.leaving_pods]
        movable[busy] = False
        movable[leaving] = True
        self.known.find(busy, leaving)
        return movable

    def decision(self) -> JointDecision:
        """Let stations take lines and send pods, and return what was chosen as the kernel takes it."""
        rule, known, period, warehouse = self.rule, self.known, self.period, self.warehouse
        numbers, bound = period.numbers, np.array(self.bound, np.int64)
        ticks = known.ticks(warehouse)
        decide(period, known.in_available, bound, known.nothing, ticks, known.cells, known.shelves, known.weights)
        sends = period.sends[: numbers[SENDS]].tolist()
        known.in_available = np.append(bound, period.sends[: numbers[SENDS], 0])
        known.moving.update(pod for pod, _ in sends)
        parts: dict[tuple[int, int], list[int]] = {}
        takes = period.takes[: numbers[TAKES]]
        for (_, station), order, sku in zip(
            takes.tolist(), self.lines.order_id[takes[:, 0]].tolist(), self.lines.sku[takes[:, 0]].tolist(), strict=True
        ):
            parts.setdefault((order, station), []).append(sku)
        if rule.elsewhere and not known.weights.packing and not warehouse.filtered and not period.counts_orders.any():
            left = len(self.ids) - int(numbers[COMPLETED])
            known.settle(warehouse, left, period.room.tolist(), period.inbound.tolist(), nothing=not (parts or sends))
        return JointDecision(
            [OrderAssignment(order, station, tuple(skus)) for (order, station), skus in parts.items()],
            [PodTrip(pod, station) for pod, station in sends],
        )

    def _placed(self, orders: int) -> NDArray[np.bool_]:
        """Which orders have a place at each station that counts orders."""
        position = {order.id: i for i, order in enumerate(self.warehouse.backlog)}
        placed = np.zeros((len(self.warehouse.stations), orders), np.bool_)
        for station in self.warehouse.stations:
            here = {request.order.id for request in station.open_requests}
            placed[station.id, [position[order] for order in here & position.keys()]] = True
        return placed


def _last_of(pod: Pod, stations: int) -> int:
    """Return the last picking station that a pod is bound for; those where bundles are stored have higher ids."""
    return [at for at in pod.bound_for if at < stations][-1]


def prepare(rule: PodIndex) -> None:
    """Call everything compiled once, with a warehouse of one pod, one line and one station."""
    zero, one = np.zeros(1, np.int64), np.ones(1, np.int64)
    for shown in (zero, one):
        shown.setflags(write=False)  # as what the view shows; numba compiles for either kind
    unknown(one.copy(), np.zeros(0, np.int64))
    by_sku, first_with = sorted_by_sku(zero, 1)
    _, open_items, by_sku, first, wanted = grouped(zero, zero, zero, one, 1)
    shelves, weights = Shelves(np.array([0, 1]), zero, zero, first_with, by_sku), weights_of(rule, waits=True)
    free, available = np.ones(1, np.bool_), np.zeros((1, 1), np.int64)
    ages = np.ones(1, np.int64)
    total, number = urges((zero, ages, by_sku, first, wanted), 1, shelves, one, 1)
    next_urgent(total, number, 0, needed(0, 1, weights.urge_ticks, weights.full))
    none, no_orders = np.zeros(0, np.bool_), np.zeros((0, 0), np.bool_)
    period = Period(
        zero, zero, one, ages, np.zeros(0), by_sku, first, wanted, np.zeros(1), np.full(1, -1.0), np.empty(1),
        open_items, np.ones(2), free.copy(), one, free.copy(), np.full(1, NONE), ages.copy(), np.zeros(1, np.int64),
        available, ages.copy(), ages.copy(), ages.copy(), np.zeros(1, np.int64), ~free, free.copy(), no_orders, none,
        none, none, np.zeros(0, np.int64), np.zeros(1, np.int64), np.empty((1, 2), np.int64),
        np.empty((1, 2), np.int64), np.empty(1, np.int64), np.zeros(8, np.int64),
    )  # fmt: skip
    decide(period, one.copy()[:0], one.copy()[:0], np.zeros(1, np.int64), available, one.copy(), shelves, weights)
