"""Joint POA+PPS rule ``pod-index``."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from attrs import define, field, validators
from numpy.typing import NDArray

from rmfs_core import JointDecision, OrderAssignment, PodTrip, hookimpl
from rmfs_core.clock import to_seconds, to_ticks
from rmfs_pod_index.compiled import (
    AT,
    AT_WORK,
    COMPLETED,
    FOUND,
    LINE,
    NONE,
    PACKING_ROOM,
    SENDS,
    TAKES,
    Period,
    Shelves,
    Weights,
    brought_so_far,
    next_urgent,
    sorted_by_sku,
    unknown,
    visit_shares,
    wanted_skus,
)
from rmfs_pod_index.known import NEVER, Known
from rmfs_pod_index.turns import DONE, TIE, advance, bring_pods
from rmfs_rule_helpers import ticks_to_station

if TYPE_CHECKING:
    from rmfs_core.traffic import Roads
    from rmfs_core.warehouse import WarehouseView


@define(kw_only=True)
class PodIndex:
    """Take the lines that finish orders, and send the pods that bring most of them in the least time.

    A greedy rule without a solver, for few visits and a short turn-over at once. It may leave lines of an order for
    later. A line of SKU i with q items costs c seconds: handle_s * q, and, where no pod at or bound for a station has
    i, cost_s / (open lines on the pod with most of them that has i). c is fixed at the start of a call. Line l of
    order o is worth

        w = c_l / (sum of c over the open lines of o) ** finish,

    most when it is the last one, times priority_factor ** (its order's priority) and, with a due time,
    1 + (due_factor - 1) * exp(-max(seconds until it is due, 0) / due_s). The index of a pod for a station is the worth
    that it brings a second: the largest ratio, over the sets of lines that the pod would cover and the station does
    not, of

        sum of w to visit_s + handle_s * items,

    in which lines that another station covers count ``elsewhere`` times. (Of a SKU of which the pod has too few items,
    the lines that add most come first.)

    Stations take turns, fewest pods first. The one whose turn it is takes the covered line that is worth most. But when
    fewer than most_pods pods are there or on their way, and the largest index of a pod that is stored or leaving is
    above stay * w / (handle_s * q) of that line (above 0 where none is covered), it sends that pod, the nearest of
    equals, and takes its best line. Where neither is to be had, its places stay free. While stations are at work, pods
    wait until it pays: one is sent only when the ages of its open lines, and base_s for each, add up to urge_s; the
    rule wakes up then.

    A line that no single pod can serve is brought by several, when there is nothing else to send.

    References
    ----------
    W. E. Smith: Various optimizers for single-stage production. Naval Research Logistics Quarterly 3, 59-66, 1956.
    https://doi.org/10.1002/nav.3800030106 (weighted shortest processing time first: the idea behind the index)

    W. Dinkelbach: On nonlinear fractional programming. Management Science 13, 492-498, 1967.
    https://doi.org/10.1287/mnsc.13.7.492 (how the largest ratio is found)

    A. P. J. Vepsalainen, T. E. Morton: Priority rules for job shops with weighted tardiness costs. Management Science
    33, 1035-1047, 1987. https://doi.org/10.1287/mnsc.33.8.1035 (how a job is worth more the sooner it is due)
    """

    splits_over_time: ClassVar[bool] = True

    visit_s: float = field(
        default=300.0,
        validator=validators.ge(0),
        metadata={
            "unit": "s",
            "doc": "What a visit counts in a pod's index: the larger, the more lines a pod must bring",
        },
    )
    cost_s: float = field(
        default=1000.0,
        validator=validators.ge(0),
        metadata={
            "unit": "s",
            "doc": "What a visit costs the lines that need it: the larger, the more rare SKUs are worth",
        },
    )
    finish: float = field(
        default=0.85,
        validator=validators.ge(0),
        metadata={
            "doc": "How much more a line is worth the less its order has left: 0 not at all, 1 as in Smith's rule"
        },
    )
    stay: float = field(
        default=1.0,
        validator=validators.ge(0),
        metadata={
            "doc": "How many times better than the best covered line a pod must be: the larger, the fewer visits"
        },
    )
    elsewhere: float = field(
        default=0.5,
        validator=validators.and_(validators.ge(0), validators.le(1)),
        metadata={
            "doc": "What a line that another station covers counts in a pod's index: the smaller, the fewer visits"
        },
    )
    most_pods: int = field(
        default=2,
        validator=validators.ge(1),
        metadata={"doc": "Pods at or bound for a station from which on no further one is sent"},
    )
    urge_s: float = field(
        default=200.0,
        validator=validators.ge(0),
        metadata={"unit": "s", "doc": "What the ages of a pod's lines add up to before it is sent; 0: no waiting"},
    )
    base_s: float = field(
        default=10.0,
        validator=validators.gt(0),
        metadata={"unit": "s", "doc": "What a line counts in `urge_s` besides its age"},
    )
    handle_s: float = field(
        default=13.0,
        validator=validators.gt(0),
        metadata={"unit": "s", "doc": "How long a picker is busy with an item"},
    )
    packing_capacity: int | None = field(
        default=None,
        validator=validators.optional(validators.ge(1)),
        metadata={
            "doc": "Split orders that the packing stations have room for, those already open included; none by default"
        },
    )

    priority_factor: float = field(
        default=2.0,
        validator=validators.gt(0),
        metadata={"doc": "How many times more a line is worth with each step of its order's priority"},
    )
    due_factor: float = field(
        default=3.0,
        validator=validators.ge(1),
        metadata={"doc": "How many times more a line is worth when its order is due or late"},
    )
    due_s: float = field(
        default=1800.0,
        validator=validators.gt(0),
        metadata={
            "unit": "s",
            "doc": "How long before an order is due what its lines are worth more has fallen to 37 %",
        },
    )
    _known: Known | None = field(default=None, init=False, eq=False, repr=False)

    @hookimpl
    def assign_orders_and_pods(self, warehouse: WarehouseView) -> JointDecision:
        """Take lines and send pods, one after another, until the places are taken or left free."""
        room = [station.free_capacity for station in warehouse.stations]
        known = self._about(warehouse)
        if not any(room) or known.nothing_to_do(warehouse, room):
            return JointDecision()
        return _Deciding(self, known, warehouse, room).decision()

    @hookimpl
    def wake_at(self, warehouse: WarehouseView) -> float | None:
        """Return when the ages of the lines of a pod will add up, if a station could take it then."""
        stations, backlog = warehouse.stations, warehouse.backlog
        waits = self.urge_s and backlog and any(station.load for station in stations)
        if not waits or not any(s.free_capacity and len(s.inbound_pods) < self.most_pods for s in stations):
            return None
        known = self._about(warehouse)
        if backlog is not known.quiet:
            seen = _Seen(self, known, warehouse)
            tick, _ = seen.next_urgent(seen.ages(), np.ones(len(seen.lines.order), np.bool_))
        else:
            tick = known.quiet_until
        return None if tick == NEVER else to_seconds(tick)

    def prepare(self, roads: Roads) -> None:  # noqa: ARG002
        """Load the compiled period, or compile it."""
        prepare(self)

    def _about(self, warehouse: WarehouseView) -> Known:
        """Return what is known of a run, and begin anew with another."""
        if self._known is None or self._known.shelves.sku is not warehouse.free_items.sku:
            self._known = Known(warehouse)
        return self._known


class _Seen:
    """What a call finds in the warehouse, as arrays."""

    def __init__(self, rule: PodIndex, known: Known, warehouse: WarehouseView) -> None:
        self.rule, self.known, self.warehouse = rule, known, warehouse
        self.lines, self.items = warehouse.backlog_lines, warehouse.free_items.number
        known.learn(warehouse, self.lines.order_id)
        by_sku, first = sorted_by_sku(self.lines.sku, warehouse.n_skus)
        self.sorted = by_sku, first, wanted_skus(first)

    @cached_property
    def ids(self) -> NDArray[np.int64]:
        """Id of each order of the backlog."""
        order = self.lines.order
        return self.lines.order_id[np.flatnonzero(np.diff(order, prepend=-1))]

    def ages(self) -> NDArray[np.int64]:
        """Of each order, its age in ticks, and what a line counts besides."""
        return self.warehouse.now_tick + to_ticks(self.rule.base_s) - self.known.arrival[self.ids]

    def next_urgent(self, ages: NDArray[np.int64], untaken: NDArray[np.bool_]) -> tuple[int, bool]:
        """Return the tick at which the ages of the lines of the next pod add up, or NEVER; and whether one's do now."""
        lines = (self.lines.order, ages, untaken, *self.sorted)
        pods, shelves = len(self.warehouse.pods), self.known.shelves
        ticks, urgent_now = next_urgent(lines, pods, shelves, self.items, to_ticks(self.rule.urge_s))
        return NEVER if ticks == NONE else self.warehouse.now_tick + int(ticks), bool(urgent_now)

    def factors(self) -> NDArray[np.float64]:
        """Of each order, how many times more a line of it is worth; empty where all are equal."""
        if self.known.equal:
            return np.zeros(0)
        rule, known = self.rule, self.known
        slack_s = np.maximum(known.due_s[self.ids] - self.warehouse.now_s, 0.0)
        due = 1.0 + (rule.due_factor - 1.0) * np.exp(-slack_s / rule.due_s)
        priority: NDArray[np.float64] = rule.priority_factor ** np.clip(known.priority[self.ids], -20, 20)
        return due * priority

    def movable(self) -> NDArray[np.bool_]:
        """Pods that may be sent: stored or leaving, and bound nowhere else."""
        movable = np.ones(len(self.warehouse.pods), np.bool_)
        busy = [pod.id for station in self.warehouse.stations for pod in station.inbound_pods]
        movable[busy + [robot.task for robot in self.warehouse.robots if robot.task is not None]] = False
        movable[[pod.id for pod in self.warehouse.leaving_pods]] = True
        return movable


class _Deciding(_Seen):
    """A period under construction, around its compiled part."""

    def __init__(self, rule: PodIndex, known: Known, warehouse: WarehouseView, room: Sequence[int]) -> None:
        super().__init__(rule, known, warehouse)
        stations, pods, lines = warehouse.stations, warehouse.pods, self.lines
        orders, packing = len(self.ids), rule.packing_capacity is not None
        waits = bool(rule.urge_s)
        bound = {pod.id: pod.bound_for[-1] for station in stations for pod in station.inbound_pods}
        inbound, last = np.array([*bound], np.int64), np.full(len(pods), NONE)
        last[inbound] = [*bound.values()]
        available = brought_so_far(inbound, last, len(stations), known.shelves, self.items)
        by_sku, first, wanted = self.sorted
        counts_orders = np.array([station.counts_orders for station in stations], np.bool_)
        backlog = warehouse.backlog if packing else ()
        split = np.array([bool(order.parts) for order in backlog], np.bool_)
        self.period = Period(
            order=lines.order,
            sku=lines.sku,
            quantity=lines.quantity,
            age=self.ages() if waits else np.zeros(0, np.int64),
            factor=self.factors(),
            by_sku=by_sku,
            first=first,
            wanted=wanted,
            share=visit_shares(first, wanted, available, known.shelves, self.items, rule.cost_s),
            left=np.full(orders, -1.0),
            power=np.empty(orders),
            untaken=np.ones(len(lines.order), np.bool_),
            items=self.items,
            movable=self.movable(),
            last=last,
            available=available,
            room=np.array(room, np.int64),
            inbound=np.array([len(station.inbound_pods) for station in stations], np.int64),
            counts_orders=counts_orders,
            open=np.array(room, np.int64) > 0,
            placed=self._placed(orders) if counts_orders.any() else np.zeros((0, 0), np.bool_),
            split=split,
            single=np.array([len(order.open_lines) == 1 for order in backlog], np.bool_),
            before=split.copy(),
            parts=np.zeros(len(backlog), np.int64),
            turn=np.zeros(len(stations), np.int64),
            takes=np.empty((len(lines.order), 2), np.int64),
            sends=np.empty((len(pods), 2), np.int64),
            found=np.empty(len(pods), np.int64),
            numbers=np.zeros(9, np.int64),
        )
        self.period.numbers[AT_WORK] = any(station.load for station in stations)
        self.period.numbers[PACKING_ROOM] = (rule.packing_capacity or 0) - warehouse.split_orders_open

    def decision(self) -> JointDecision:
        """Let stations take lines and send pods, and return what was chosen as the kernel takes it."""
        rule, known, period, warehouse = self.rule, self.known, self.period, self.warehouse
        weights, found = _weights(rule), period.found
        while (end := advance(period, known.shelves, weights, known.nothing)) != DONE:
            station = int(period.turn[period.numbers[AT]])
            pods = self._by_distance(found[: period.numbers[FOUND]].tolist(), station)
            chosen = pods[:1] if end == TIE else self._enough(pods, int(period.numbers[LINE]), station)
            found[: len(chosen)], period.numbers[FOUND] = chosen, len(chosen)
            bring_pods(period, known.shelves, weights)
        parts: dict[tuple[int, int], list[int]] = {}
        takes = period.takes[: period.numbers[TAKES]]
        for (_, station), order, sku in zip(
            takes.tolist(), self.lines.order_id[takes[:, 0]].tolist(), self.lines.sku[takes[:, 0]].tolist(), strict=True
        ):
            parts.setdefault((order, station), []).append(sku)
        trips = [PodTrip(pod, station) for pod, station in period.sends[: period.numbers[SENDS]].tolist()]
        known.quiet, known.quiet_until = None, NEVER
        if rule.elsewhere and rule.packing_capacity is None and not warehouse.filtered:
            left = len(warehouse.backlog) - int(period.numbers[COMPLETED])
            known.settled = warehouse.now_tick, left, *period.room.tolist(), *period.inbound.tolist()
            if rule.urge_s and not period.counts_orders.any():
                until, urgent_now = self.next_urgent(period.age, period.untaken)
                known.quiet_until = NEVER if urgent_now else until
                known.largest = int(self.lines.quantity.max(initial=0))
                if not (parts or trips or urgent_now):
                    known.quiet = warehouse.backlog
        return JointDecision(
            [OrderAssignment(order, station, tuple(skus)) for (order, station), skus in parts.items()], trips
        )

    def _placed(self, orders: int) -> NDArray[np.bool_]:
        """Which orders have a place at each station that counts orders."""
        position = {order.id: i for i, order in enumerate(self.warehouse.backlog)}
        placed = np.zeros((len(self.warehouse.stations), orders), np.bool_)
        for station in self.warehouse.stations:
            here = {request.order.id for request in station.open_requests}
            placed[station.id, [position[order] for order in here & position.keys()]] = True
        return placed

    def _by_distance(self, pods: Sequence[int], station: int) -> list[int]:
        given, to = self.warehouse.pods, self.warehouse.stations[station]
        ticks = {pod: ticks_to_station(self.warehouse, given[pod], to) for pod in pods}
        return sorted(ticks, key=lambda pod: (ticks[pod], pod))

    def _enough(self, pods: Sequence[int], line: int, station: int) -> list[int]:
        """Return pods, those with the most items first, that have what a line needs together."""
        sku, shelves = self.lines.sku[line], self.known.shelves
        missing = int(self.lines.quantity[line] - self.period.available[station, sku])
        entries = shelves.by_sku[shelves.first_with[sku] : shelves.first_with[sku + 1]]
        held = dict(zip(shelves.pod[entries].tolist(), self.items[entries].tolist(), strict=True))
        chosen = []
        for pod in sorted(pods, key=lambda pod: -held[pod]):
            if missing > 0:
                chosen.append(pod)
                missing -= held[pod]
        return chosen


def _weights(rule: PodIndex) -> Weights:
    return Weights(
        float(rule.handle_s),
        float(rule.cost_s),
        float(rule.finish),
        float(rule.visit_s),
        float(rule.stay),
        float(rule.elsewhere),
        int(rule.most_pods),
        to_ticks(rule.urge_s),
        rule.packing_capacity is not None,
    )


def prepare(rule: PodIndex) -> None:
    """Call everything compiled once, with a warehouse of one pod, one line and one station."""
    zero, one = np.zeros(1, np.int64), np.ones(1, np.int64)
    for shown in (zero, one):
        shown.setflags(write=False)  # as what the view shows; numba compiles for either kind
    unknown(zero, np.zeros(0, np.int64))
    by_sku, first = sorted_by_sku(zero, 1)
    wanted = wanted_skus(first)
    shelves = Shelves(np.array([0, 1]), zero, zero, first, by_sku)
    free = np.ones(1, np.bool_)
    available = brought_so_far(np.zeros(0, np.int64), np.zeros(1, np.int64), 1, shelves, one)
    share = visit_shares(first, wanted, available, shelves, one, rule.cost_s)
    ages = np.ones(1, np.int64)
    next_urgent((zero, ages, free, by_sku, first, wanted), 1, shelves, one, 1)
    none, no_orders = np.zeros(0, np.bool_), np.zeros((0, 0), np.bool_)
    period = Period(
        zero, zero, one, ages, np.zeros(0), by_sku, first, wanted, share, np.full(1, -1.0), np.empty(1), free.copy(),
        one, free.copy(), np.full(1, NONE), available, np.ones(1, np.int64), np.zeros(1, np.int64), ~free, free.copy(),
        no_orders, none, none, none, np.zeros(0, np.int64), np.zeros(1, np.int64), np.empty((1, 2), np.int64),
        np.empty((1, 2), np.int64), np.empty(1, np.int64), np.zeros(9, np.int64),
    )  # fmt: skip
    weights = _weights(rule)
    advance(period, shelves, weights, np.zeros(1, np.int64))
    period.numbers[AT], period.numbers[FOUND] = 0, 0
    bring_pods(period, shelves, weights)
