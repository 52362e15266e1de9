"""What the turn-over time of each order went to: rows of delays.csv."""

from __future__ import annotations

from array import array
from operator import sub
from typing import Any

from rmfs_commands.details.spans import Handlers, Number, ratio
from rmfs_core.clock import TICKS_PER_S, to_seconds
from rmfs_core.events import (
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCompleted,
    OrderInStock,
    PodLifted,
    QueueJoined,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.info import RunInfo

COLUMNS = ("backlog_s", "other_parts_s", "fetch_s", "driving_s", "queueing_s", "station_s")
"""Columns besides order and turnover_s, in the order of time: they follow each other and add up to it.

``backlog_s``: from its arrival, or from ``stock_s`` on, until its first lines are assigned. ``other_parts_s``: from
then on, until its last lines are. What follows is that of the pod that its last item is picked from, on the way of that
pick: ``fetch_s`` until a robot sets out with the pod for the station, ``driving_s`` until it joins the queue,
``queueing_s`` until it stands at the station, and ``station_s`` until the pick is done. What of these came before the
last assignment counts as nothing."""

WAITED = "stock_s"
"""Column ahead of these where stock can run out: from the arrival until the pods hold enough for the order."""

HANDLING = "handling_s"
"""Further column where ``stations.release`` is ``"handled"``: from the last pick until its item is handled."""


class Delays:
    """Follows the orders and the pods on their way.

    Parameters
    ----------
    run
        The run.
    begin
        The time from which on orders that arrive count in means.
    """

    def __init__(self, run: RunInfo, begin: int) -> None:
        self._orders = run.instance.orders
        self._handled = run.scenario.stations.release == "handled"
        self._waits = run.instance.restocked and run.scenario.rules.wait_for_stock is not False
        self.columns = (*((WAITED,) if self._waits else ()), *COLUMNS, *((HANDLING,) if self._handled else ()))
        """Columns besides order and turnover_s."""
        self._begin = begin
        self._in_stock: dict[int, int] = {}
        self._waited = array("q")  # of completed orders that count in means
        self._arrival = {i: order.arrival_tick for i, order in enumerate(self._orders)}  # until it arrives otherwise
        self._first: dict[int, int] = {}
        self._last: dict[int, int] = {}
        self._way = [(0, 0, 0)] * len(run.instance.pods)  # of each pod: set out, joined the queue, at the station
        self._served: dict[int, tuple[int, int, int, int]] = {}
        self.times: dict[int, array[int]] = {}
        """Of each completed order, the ticks that the columns have in seconds."""
        self.handlers: Handlers = {
            OrderArrived: self._arrived,
            OrderInStock: self._joined_late,
            OrderAssigned: self._assigned,
            PodLifted: self._set_out,
            QueueJoined: self._joined,
            VisitStarted: self._started,
            ItemPicked: self._picked,
            VisitEnded: self._ended,
            OrderCompleted: self._completed,
        }

    def _arrived(self, event: OrderArrived) -> None:
        self._arrival[event.order] = event.tick

    def _joined_late(self, event: OrderInStock) -> None:
        self._in_stock[event.order] = event.tick

    def _assigned(self, event: OrderAssigned) -> None:
        self._first.setdefault(event.order, event.tick)
        self._last[event.order] = event.tick

    def _set_out(self, event: PodLifted) -> None:
        self._way[event.pod] = (event.tick, event.tick, event.tick)

    def _ended(self, event: VisitEnded) -> None:
        self._way[event.pod] = (event.tick, event.tick, event.tick)

    def _joined(self, event: QueueJoined) -> None:
        self._way[event.pod] = (self._way[event.pod][0], event.tick, event.tick)

    def _started(self, event: VisitStarted) -> None:
        self._way[event.pod] = (*self._way[event.pod][:2], event.tick)

    def _picked(self, event: ItemPicked) -> None:
        self._served[event.order] = (*self._way[event.pod], event.tick)

    def _completed(self, event: OrderCompleted) -> None:
        order = event.order
        last = self._last.pop(order)
        set_out, joined, started, picked = self._served.pop(order)
        ends = [self._first.pop(order), last, max(set_out, last), max(joined, last), max(started, last), picked]
        if self._handled:
            ends.append(event.tick)
        arrival = self._arrival.pop(order)
        if self._waits:
            ends.insert(0, self._in_stock.pop(order, arrival))
            if arrival >= self._begin:
                self._waited.append(ends[0] - arrival)
        self.times[order] = array("q", map(sub, ends, (arrival, *ends)))

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
