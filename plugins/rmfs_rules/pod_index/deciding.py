"""A period of pod-index: what is seen in the warehouse, as arrays, and what is decided."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_core import JointDecision, OrderAssignment, PodTrip
from rmfs_rules.pod_index.account import join, move, update
from rmfs_rules.pod_index.known import NEVER, NOWHERE, Known, weigh
from rmfs_rules.pod_index.period import (
    NONE,
    OF_LINES,
    PACKING_ROOM,
    new_account,
)
from rmfs_rules.pod_index.turns import decide
from rmfs_rules.pod_index.urging import next_urgent

if TYPE_CHECKING:
    from rmfs_core.traffic import Roads
    from rmfs_core.warehouse import Station, WarehouseView
    from rmfs_rules.pod_index.rule import PodIndex

NOBODY = np.zeros((0, 2), np.int64)
"""No pod that leaves a station."""


class Deciding:
    """A period under construction, around its compiled part.

    Parameters
    ----------
    known
        What is known of the run.
    warehouse
        The warehouse.
    without
        A station that takes nothing now.
    """

    def __init__(self, known: Known, warehouse: WarehouseView, without: Station | None = None) -> None:
        self.rule, self.known, self.warehouse, self._without = known.rule, known, warehouse, without
        self.account, self._moved = known.shown(warehouse)
        self.period = self.account.period

    def decision(self) -> JointDecision:
        """Let stations take lines and send pods, and return what was chosen as the kernel takes it."""
        known, need = self.known, self.known.need
        if need != NEVER and not (known.urge_ticks and known.at_work):
            need = NONE  # where no pod waits to be wanted enough
        self._begin()
        room = [0 if self._without and station == self._without.id else free for station, free in enumerate(known.room)]
        told = [self.warehouse.now_tick, known.at_work, need, *room, *known.load, *known.inbound]
        seen = *self.account.parts, np.array(told, np.int64), self._moved
        if decide(*seen, NOBODY, False):
            leaving = np.array([(pod.id, pod.cell) for pod in self.warehouse.leaving_pods], np.int64)
            decide(*seen, leaving.reshape(-1, 2), True)
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
        n_takes, n_sends, completed = period.numbers[:3].tolist()
        parts: dict[tuple[int, int], list[int]] = {}
        for _, station, order, sku in period.takes[:n_takes].tolist():
            parts.setdefault((order, station), []).append(sku)
        sends = period.sends[:n_sends].tolist()
        if (
            self.rule.elsewhere
            and self.rule.packing_capacity is None
            and not warehouse.filtered
            and not known.counts_orders
        ):
            left = warehouse.backlog_size - completed
            room, inbound = period.stations["room"].tolist(), period.stations["inbound"].tolist()
            known.settle(warehouse, left, room, inbound, nothing=not (parts or sends))
        return JointDecision(
            [OrderAssignment(order, station, tuple(skus)) for (order, station), skus in parts.items()],
            [PodTrip(pod, station) for pod, station, _ in sends],
        )


def prepare(rule: PodIndex, roads: Roads) -> None:
    """Call everything compiled once, with a warehouse of one pod, one line and one station, and search for the ways."""
    zero, one, none = np.zeros(1, np.int64), np.ones(1, np.int64), np.zeros(0, np.int64)
    one.setflags(write=False)  # as what the view shows; numba compiles for either kind
    account = new_account(zero, zero, 1, 1, np.zeros((1, 1), np.int64))
    weigh(account.period, rule)
    account.make_room(dict.fromkeys(OF_LINES, 1))
    update(*account.parts, 0, none, zero, one)
    move(*account.parts, NOWHERE)
    join(*account.parts, 0, np.zeros((3, 1), np.int64), np.zeros((1, 5)))
    next_urgent(*account.parts, 0, 1)
    decide(*account.parts, np.zeros(6, np.int64), NOWHERE, NOBODY, False)
    update(*account.parts, 0, zero, none, one)
    for station in roads.layout.stations:
        roads.travel.times_to(station.station, True)
