"""Parts of the turn-over time of each order: rows of delays.csv."""

from __future__ import annotations

from array import array
from typing import Any, NamedTuple

from rmfs_commands.details.robots import Robots
from rmfs_commands.details.spans import Handlers, Number, goes_on, ratio
from rmfs_core.clock import TICKS_PER_S, to_seconds
from rmfs_core.events import (
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCancelled,
    OrderCompleted,
    OrderInStock,
    PodLifted,
    QueueJoined,
    TaskAssigned,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.info import RunInfo

COLUMNS = (
    "backlog_s",
    "other_parts_s",
    "robot_s",
    "pod_s",
    "to_pod_s",
    "room_s",
    "driving_s",
    "queueing_s",
    "station_s",
)
"""Columns besides order and turnover_s, in the order of time: they add up to it.

``backlog_s``: from its arrival, or from ``stock_s`` on, until its first lines are assigned. ``other_parts_s``: from
then on, until its last lines are. What follows is that of the pod that its last item is picked from, on the way of that
pick. Until a robot has the task to fetch it, or carries it on from another station: ``robot_s`` while no robot is free,
``pod_s`` while one is. Then ``to_pod_s``: the robot drives to the pod and lifts it; ``room_s``: it stands under the
pod for a queue cell. ``driving_s`` until it joins the queue, ``queueing_s`` until it stands at the station,
and ``station_s`` until the pick is done. What of these came before the last assignment counts as nothing."""

BEFORE = "before_s"
"""Column ahead of these where a run begins in a state: from the arrival until then. The others tell of what came after;
no state tells what an order waited for before."""

WAITED = "stock_s"
"""Column ahead of these where stock can run out: from the arrival until the pods hold enough for the order."""

HANDLING = "handling_s"
"""Further column where ``stations.release`` is ``"handled"``: from the last pick until its item is handled."""

_Way = tuple[int, ...]
"""Of a pod: when a robot had the task to fetch it, or it left another station; `Robots.none_free` then; when the robot
began and ended to wait for a queue cell, had lifted it, joined the queue, and stood at the station. All ticks."""


class Last(NamedTuple):
    """An order's last assignment: when, `Robots.none_free` then, to which station, and whether no line is left."""

    tick: int
    none_free: int
    station: int
    whole: bool


class Delays:
    """Follows the orders and the pods on their way.

    Parameters
    ----------
    run
        The run.
    begin
        The time from which on orders that arrive count in means.
    robots
        The robots, which are told of an event before this.
    """

    def __init__(self, run: RunInfo, begin: int, robots: Robots) -> None:
        self._orders, self._robots = run.instance.orders, robots
        self._handled = run.scenario.stations.release == "handled"
        self._waits = run.instance.restocked and run.scenario.rules.wait_for_stock is not False
        self.columns = (*((WAITED,) if self._waits else ()), *COLUMNS, *((HANDLING,) if self._handled else ()))
        self.began = run.began
        """Tick of the state in which the run begins; None: it begins afresh."""
        self.columns = self.columns if self.began is None else (BEFORE, *self.columns)
        """Columns besides order and turnover_s."""
        self._begin, self._goes_on = begin, goes_on(run, begin)
        self._waited = array("q")  # of completed orders that count in means
        self._known = known = run.scenario.instance.arrivals.backlog is None
        self.arrival = {i: order.arrival_tick for i, order in enumerate(self._orders)} if known else {}
        """When each order arrives; only of orders that have arrived, where that is not known beforehand."""
        self.in_stock: dict[int, int] = {}
        """When orders that had to wait for stock joined the backlog."""
        self.out_of_stock: set[int] = set()
        """Orders that wait for stock, or did when they were cancelled."""
        self.cancelled: dict[int, int] = {}
        """When orders were cancelled."""
        self._view = run.warehouse
        self._first: dict[int, int] = {}
        self.last: dict[int, Last] = {}
        """The last assignment so far of each order that is not complete."""
        self._way: list[_Way] = [(0,) * 7] * len(run.instance.pods)
        # Of the last pick: the pod's way, station, tick, visit, and how many items of the order were picked in that
        self._served: dict[int, tuple[_Way, int, int, int, int]] = {}
        self.all_done: int | None = None
        """When the last of all orders that are known beforehand was complete, or cancelled."""
        self.times: dict[int, array[int]] = {}
        """Of each completed order, the ticks that the columns have in seconds."""
        self._over_before: set[int] = set()
        self.picks: dict[int, tuple[int, int]] = {}
        """Of each completed order, the station of its last pick, and how many of its items that visit served."""
        self.handlers: Handlers = {
            OrderArrived: self._arrived,
            OrderInStock: self._joined_late,
            OrderAssigned: self._assigned,
            TaskAssigned: self._begin_way,
            PodLifted: self._set_out,
            QueueJoined: self._joined,
            VisitStarted: self._started,
            ItemPicked: self._picked,
            VisitEnded: self._begin_way,
            OrderCompleted: self._completed,
            OrderCancelled: self._cancelled,
        }

    def _arrived(self, event: OrderArrived) -> None:
        self.arrival[event.order] = event.tick
        if self._waits and self._view.order(event.order).waits_for_stock:
            self.out_of_stock.add(event.order)

    def _joined_late(self, event: OrderInStock) -> None:
        self.in_stock[event.order] = event.tick
        self.out_of_stock.discard(event.order)

    def counts(self, order: int) -> bool:
        """Whether an order counts in means: it arrived in the time that does, or was open in the state."""
        return self.arrival[order] >= self._begin or (self._goes_on and order not in self._over_before)

    def since(self, tick: int) -> int:
        """Return a tick, or that of the state if it is earlier."""
        return tick if self.began is None else max(tick, self.began)

    def _cancelled(self, event: OrderCancelled) -> None:
        self.cancelled[event.order] = event.tick
        if self.began is not None and event.tick <= self.began:
            self._over_before.add(event.order)
        self._note_done(event.tick)

    def _assigned(self, event: OrderAssigned) -> None:
        self._first.setdefault(event.order, event.tick)
        none_free = self._robots.none_free(self.since(event.tick))
        self.last[event.order] = Last(event.tick, none_free, event.station, event.complete)

    def _begin_way(self, event: TaskAssigned | VisitEnded) -> None:
        tick = self.since(event.tick)
        self._way[event.pod] = (tick, self._robots.none_free(tick), tick, tick, tick, tick, tick)

    def _set_out(self, event: PodLifted) -> None:
        asked, none_free, *_ = self._way[event.pod]
        tick = event.tick
        self._way[event.pod] = (asked, none_free, *self._robots.beneath[event.pod], tick, tick, tick)

    def _joined(self, event: QueueJoined) -> None:
        self._way[event.pod] = (*self._way[event.pod][:5], event.tick, event.tick)

    def _started(self, event: VisitStarted) -> None:
        self._way[event.pod] = (*self._way[event.pod][:6], event.tick)

    def _picked(self, event: ItemPicked) -> None:
        before = self._served.get(event.order)
        items = before[4] + 1 if before is not None and before[3] == event.visit else 1
        self._served[event.order] = self._way[event.pod], event.station, event.tick, event.visit, items

    def _completed(self, event: OrderCompleted) -> None:
        order, arrival = event.order, self.since(self.arrival[event.order])
        if self.began is not None and event.tick <= self.began:
            self._over_before.add(order)
            self.last.pop(order, None)
            return
        last, none_free, *_ = self.last.pop(order)
        (asked, none_asked, *way), station, picked, _, items = self._served.pop(order)
        last, picked = self.since(last), self.since(picked)
        self.picks[order] = station, items
        robot = none_asked - none_free if asked > last else 0
        asked, begun, ended, lifted, joined, started = [tick if tick > last else last for tick in (asked, *way)]
        room = ended - begun
        joins = self.since(self.in_stock.get(order, arrival)) if self._waits else arrival
        first = self.since(self._first.pop(order))
        times = [] if self.began is None else [arrival - self.arrival[order]]
        times += [joins - arrival] if self._waits else []
        times += first - joins, last - first, robot, asked - last - robot, lifted - asked - room, room
        times += joined - lifted, started - joined, picked - started
        if self._handled:
            times.append(event.tick - picked)
        if self._waits and self.counts(order):
            self._waited.append(joins - arrival)
        self.times[order] = array("q", times)
        self._note_done(event.tick)

    def _note_done(self, tick: int) -> None:
        if self._known and len(self.times) + len(self.cancelled.keys() | self._over_before) == len(self._orders):
            self.all_done = tick
            self._robots.picked(tick)

    def values(self) -> dict[str, Number]:
        """Return the mean time for which completed orders waited for stock; nothing where none can."""
        mean = ratio(sum(self._waited), len(self._waited) * TICKS_PER_S)
        return {"turnover_stock_s": mean} if self._waits else {}

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each order; no times where it is not complete."""
        found: list[dict[str, Any]] = []
        for i, order in enumerate(self._orders):
            times = self.times.get(i)
            row = {"order": order.name, "turnover_s": None if times is None else to_seconds(sum(times))}
            seconds = (
                dict.fromkeys(self.columns) if times is None else zip(self.columns, map(to_seconds, times), strict=True)
            )
            found.append(row | dict(seconds))
        return found
