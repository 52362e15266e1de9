"""A period of pod-index: what is seen in the warehouse, as arrays, and what is decided."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_core import JointDecision, OrderAssignment, PodTrip
from rmfs_pod_index.account import join, sorted_by_sku, update
from rmfs_pod_index.known import Known, weights_of
from rmfs_pod_index.period import (
    ASKED,
    AT_WORK,
    COMPLETED,
    NONE,
    NOW,
    OF_LINES,
    OF_ORDERS,
    PACKED,
    PACKING_ROOM,
    SENDS,
    TAKES,
    URGENT,
    Shelves,
    new_period,
    with_arrays,
    with_room,
)
from rmfs_pod_index.turns import decide
from rmfs_pod_index.urging import find_urgent, next_urgent

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, WarehouseView
    from rmfs_pod_index.rule import PodIndex


class Deciding:
    """A period under construction, around its compiled part.

    Parameters
    ----------
    known
        What is known of the run.
    warehouse
        The warehouse.
    """

    def __init__(self, known: Known, warehouse: WarehouseView) -> None:
        self.rule, self.known, self.warehouse = known.rule, known, warehouse
        self.room, self.load, self.inbound, self.need = known.seen
        self.period, stations = known.shown(warehouse), warehouse.stations
        inbound = [station.inbound_pods for station in stations]
        bound = {pod.id: pod for there in inbound for pod in there}  # one may be bound for several, to be replenished
        self.bound = list(bound)
        self.last = [_last_of(pod, len(stations)) for pod in bound.values()]
        counts_orders = [station.counts_orders for station in stations]
        if any(counts_orders):
            placed = np.zeros((len(stations), len(self.period.begin)), np.bool_)
            self.period = with_arrays(self.period, {"placed": placed})
        self.period.counts_orders[:] = counts_orders
        self.period.capacity[:] = [station.capacity for station in stations]

    def movable(self, wanted: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Which of some pods may be sent: stored or leaving, and bound nowhere else; of others it says nothing."""
        pods, bound = self.known.pods, set(self.bound)
        busy = [pod for pod in wanted.tolist() if pod in bound or pods[pod].robot is not None]
        movable = np.ones(len(pods), np.bool_)
        if busy:
            movable[busy] = False
            movable[[pod.id for pod in self.warehouse.leaving_pods]] = True
        return movable

    def decision(self) -> JointDecision:
        """Let stations take lines and send pods, and return what was chosen as the kernel takes it."""
        known, period, warehouse, movable = self.known, self.period, self.warehouse, None
        numbers, pods, cells = period.numbers, known.pods, known.cells
        bound, last = np.array(self.bound, np.int64), np.array(self.last, np.int64)
        moved: list[int] | None = None
        while moved is None or moved:
            self._begin()
            if self._find_urgent():
                movable = self.movable(period.urgent[: numbers[URGENT]]) if movable is None else movable
                period.movable[:] = movable
            decide(period, bound, last, known.ticks(warehouse), cells, known.shelves, known.weights)
            # Only of pods that are equally good it matters where they are: if one has moved, all is decided again
            moved = []
            if numbers[ASKED]:
                asked = np.flatnonzero(period.asked)
                period.asked[asked] = False
                moved = [pod for pod in asked.tolist() if pods[pod].cell != cells[pod]]
                cells[moved] = [pods[pod].cell for pod in moved]
        return self._told()

    def _begin(self) -> None:
        """Fill in how stations and orders are before anything is decided."""
        period, warehouse = self.period, self.warehouse
        period.room[:], period.load[:], period.inbound[:] = self.room, self.load, self.inbound
        np.greater(period.room, 0, out=period.open)
        period.numbers[NOW], period.numbers[AT_WORK] = warehouse.now_tick, any(self.load)
        if self.known.weights.packing:
            period.numbers[PACKING_ROOM] = (self.rule.packing_capacity or 0) - warehouse.split_orders_open
            for order in warehouse.backlog:
                period.split[order.id] = period.ever[order.id] = bool(order.parts)
                period.single[order.id], period.parts[order.id] = len(order.open_lines) == 1, 0
        if period.placed.size:
            period.placed[:] = False
            for station in warehouse.stations:
                here = {request.order.id for request in station.open_requests}
                period.placed[station.id, [order for order in here if order < period.placed.shape[1]]] = True

    def _find_urgent(self) -> bool:
        """List the pods that are wanted enough to be sent somewhere: all where no pod waits for that."""
        period, weights, least = self.period, self.known.weights, NONE
        if self.need is None:
            period.numbers[URGENT] = 0
            return False
        if weights.urge_ticks and period.numbers[AT_WORK]:
            least = self.need
        since = self.warehouse.now_tick + weights.base_ticks
        period.numbers[URGENT] = find_urgent(
            period.urge, period.urgent, period.lines_of, period.arrivals_of, since, least
        )
        return bool(period.numbers[URGENT])

    def _told(self) -> JointDecision:
        """Return the decision, and remember what it leaves."""
        known, period, warehouse = self.known, self.period, self.warehouse
        takes, sends = (period.takes[: period.numbers[TAKES]], period.sends[: period.numbers[SENDS]].tolist())
        parts: dict[tuple[int, int], list[int]] = {}
        orders, skus = period.order[takes[:, 0]].tolist(), period.sku[takes[:, 0]].tolist()
        for order, sku, station in zip(orders, skus, takes[:, 1].tolist(), strict=True):
            parts.setdefault((order, station), []).append(sku)
        if self.rule.elsewhere and not known.weights.packing and not warehouse.filtered and not period.placed.size:
            left = warehouse.backlog_size - int(period.numbers[COMPLETED])
            room, inbound = period.room.tolist(), period.inbound.tolist()
            known.settle(warehouse, left, room, inbound, nothing=not (parts or sends))
        return JointDecision(
            [OrderAssignment(order, station, tuple(skus)) for (order, station), skus in parts.items()],
            [PodTrip(pod, station) for pod, station in sends],
        )


def _last_of(pod: Pod, stations: int) -> int:
    """Return the last picking station that a pod is bound for; those where bundles are stored have higher ids."""
    return [at for at in pod.bound_for if at < stations][-1]


def prepare(rule: PodIndex) -> None:
    """Call everything compiled once, with a warehouse of one pod, one line and one station."""
    zero, one = np.zeros(1, np.int64), np.ones(1, np.int64)
    for shown in (zero, one):
        shown.setflags(write=False)  # as what the view shows; numba compiles for either kind
    by_sku, first_with = sorted_by_sku(zero, 1)
    shelves, weights = Shelves(np.array([0, 1]), zero, zero, first_with, by_sku), weights_of(rule, waits=True)
    period = with_room(with_room(new_period(1, 1, 1, 1), OF_LINES, 1), OF_ORDERS + PACKED, 1)
    period = with_arrays(period, {"least": np.ones(1)})
    period.left[:] = -1.0
    none = np.zeros(0, np.int64)
    update(period, none, one, shelves)
    join(period, 0, 1, shelves)
    next_urgent(period.lines_of, period.arrivals_of, 0, 1, weights.base_ticks)
    find_urgent(period.urge, period.urgent, period.lines_of, period.arrivals_of, 1, 1)
    decide(period, none, none, np.zeros((1, 1), np.int64), np.zeros(1, np.int64), shelves, weights)
    update(period, np.zeros(1, np.int64), one[:0], shelves)
