"""A period of pod-index: what is seen in the warehouse, as arrays, and what is decided."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_core import JointDecision, OrderAssignment, PodTrip
from rmfs_pod_index.account import join, update
from rmfs_pod_index.known import NEVER, Known, weigh
from rmfs_pod_index.period import (
    ASKED,
    COMPLETED,
    NONE,
    OF_LINES,
    PACKING_ROOM,
    SENDS,
    TAKES,
    new_account,
)
from rmfs_pod_index.turns import decide
from rmfs_pod_index.urging import next_urgent

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView
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
        self.account = known.shown(warehouse)
        self.period = self.account.period
        self.bound: dict[int, int] = {}
        for station, there in enumerate(known.inbound):
            for pod in there:  # one may be bound for several, to be replenished
                self.bound[pod] = station if pod not in self.bound else known.last_of(pod)

    def busy(self) -> list[int]:
        """Pods that may not be sent: those that are bound for somewhere or that robots have, but for leaving ones."""
        busy = {robot.task for robot in self.warehouse.robots} | self.bound.keys()
        busy.difference_update([pod.id for pod in self.warehouse.leaving_pods])
        return [pod for pod in busy if pod is not None]

    def decision(self) -> JointDecision:
        """Let stations take lines and send pods, and return what was chosen as the kernel takes it."""
        known, period = self.known, self.period
        bound = np.array(list(self.bound.items()), np.int64).reshape(-1, 2)
        busy, need = np.array(self.busy(), np.int64), known.need
        if need != NEVER and not (known.urge_ticks and known.at_work):
            need = NONE  # where no pod waits to be wanted enough
        moved: list[int] | None = None
        while moved is None or moved:
            self._begin()
            decide(*self.account.parts, self.warehouse.now_tick, self.known.at_work, bound, busy, need)
            # Only of pods that are equally good it matters where they are: if one has moved, all is decided again
            moved = []
            if period.numbers[ASKED]:
                asked = np.flatnonzero(period.pods["asked"])
                period.pods["asked"][asked] = False
                moved = [pod for pod in asked.tolist() if known.pods[pod].cell != period.pods["cell"][pod]]
                period.pods["cell"][moved] = [known.pods[pod].cell for pod in moved]
        return self._told()

    def _begin(self) -> None:
        """Fill in how stations and orders are before anything is decided."""
        period, warehouse, orders = self.period, self.warehouse, self.period.orders
        if self.known.counts_orders:
            self.account.place(self._placed())
        if self.rule.packing_capacity is not None:
            period.numbers[PACKING_ROOM] = self.rule.packing_capacity - warehouse.split_orders_open
            for order in warehouse.backlog:
                orders["split"][order.id] = orders["ever"][order.id] = bool(order.parts)
                orders["single"][order.id], orders["parts"][order.id] = len(order.open_lines) == 1, 0

    def _placed(self) -> NDArray[np.bool_]:
        """Which orders have a place at each station, shape (stations, orders)."""
        placed = np.zeros((len(self.known.room), len(self.account.period.orders)), np.bool_)
        for station in self.warehouse.stations:
            here = {request.order.id for request in station.open_requests}
            placed[station.id, [order for order in here if order < placed.shape[1]]] = True
        return placed

    def _told(self) -> JointDecision:
        """Return the decision, and remember what it leaves."""
        known, period, warehouse = self.known, self.period, self.warehouse
        takes = period.takes[: period.numbers[TAKES]].tolist()
        sends = period.sends[: period.numbers[SENDS]].tolist()
        parts: dict[tuple[int, int], list[int]] = {}
        for line, station in takes:
            order, sku, *_ = period.lines[line].item()
            parts.setdefault((order, station), []).append(sku)
        if (
            self.rule.elsewhere
            and self.rule.packing_capacity is None
            and not warehouse.filtered
            and not known.counts_orders
        ):
            left = warehouse.backlog_size - int(period.numbers[COMPLETED])
            room, inbound = period.stations["room"].tolist(), period.stations["inbound"].tolist()
            known.settle(warehouse, left, room, inbound, nothing=not (parts or sends))
        return JointDecision(
            [OrderAssignment(order, station, tuple(skus)) for (order, station), skus in parts.items()],
            [PodTrip(pod, station) for pod, station in sends],
        )


def prepare(rule: PodIndex) -> None:
    """Call everything compiled once, with a warehouse of one pod, one line and one station."""
    zero, one, none = np.zeros(1, np.int64), np.ones(1, np.int64), np.zeros(0, np.int64)
    one.setflags(write=False)  # as what the view shows; numba compiles for either kind
    account = new_account(zero, zero, 1, 1, np.zeros((1, 1), np.int64))
    weigh(account.period, rule)
    account.make_room(dict.fromkeys(OF_LINES, 1))
    account.period.orders["left"] = -1.0
    update(*account.parts, none, zero, one)
    join(*account.parts, 0, 1)
    next_urgent(*account.parts, 0, 1)
    decide(*account.parts, 0, True, none.reshape(-1, 2), none, 1)
    update(*account.parts, zero, none, one)
