"""Counts per hour: rows of hours.csv."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rmfs_commands.details.spans import TICKS_PER_HOUR, Count, Handlers
from rmfs_core.events import (
    Event,
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCancelled,
    OrderCompleted,
    RobotsOnDuty,
    StationClosed,
    StationOpened,
    VisitStarted,
)
from rmfs_core.info import RunInfo

COUNTED = ("orders_in", "orders_out", "picks", "visits", "distance_m")
CANCELLED = "orders_cancelled"
"""Besides these where any order may be cancelled."""


class Hours:
    """Counts by the hour; what takes time counts in the hour in which it ends.

    The first is that of time 0, or that in which a run begins in a state: what was before it does not count.

    Parameters
    ----------
    run
        The run.
    """

    def __init__(self, run: RunInfo) -> None:
        self._rows: list[dict[str, Any]] = []
        self._began, self._since = run.began or 0, run.since
        self._first = self._began // TICKS_PER_HOUR
        self._over = 0  # when the last of them is
        self._backlog = 0
        cancelled = any(order.cancelled_tick is not None for order in run.instance.orders)
        self._counted = (*COUNTED, CANCELLED) if cancelled else COUNTED
        scenario, self._open, self._on_duty = run.scenario, Count(), Count()
        self._open.add(0, len(run.warehouse.stations))
        self._on_duty.add(0, len(run.warehouse.robots))
        opening = scenario.stations.open is not None or scenario.rules.activate is not None
        self._there = {
            **({"stations_open": self._open} if opening else {}),
            **({"robots_on_duty": self._on_duty} if scenario.robots.available is not None else {}),
        }
        self._until(self._first)
        self.handlers: Handlers = {
            OrderArrived: self._arrived,
            OrderAssigned: self._assigned,
            OrderCancelled: self._cancelled,
            OrderCompleted: lambda event: self._count(event, "orders_out"),
            ItemPicked: lambda event: self._count(event, "picks"),
            VisitStarted: lambda event: self._count(event, "visits"),
            StationOpened: lambda event: self._open.add(event.tick, 1),
            StationClosed: lambda event: self._open.add(event.tick, -1),
            RobotsOnDuty: lambda event: self._on_duty.add(event.tick, event.number - self._on_duty.number),
        }

    def _arrived(self, event: OrderArrived) -> None:
        self._count(event, "orders_in")
        self._backlog += 1

    def _assigned(self, event: OrderAssigned) -> None:
        self._until(event.tick // TICKS_PER_HOUR)
        self._backlog -= event.complete

    def _cancelled(self, event: OrderCancelled) -> None:
        self._count(event, CANCELLED)
        self._backlog -= 1

    def _count(self, event: Event, what: str) -> None:
        if event.tick >= self._over:
            self._until(event.tick // TICKS_PER_HOUR)
        self._row[what] += event.tick >= self._since

    def _until(self, hour: int) -> None:
        """Begin hours up to one, each with the backlog that the one before it has left."""
        while (begins := self._first + len(self._rows)) <= hour:
            if self._rows:
                self._rows[-1]["backlog"] = self._backlog
            begin = {"hour": begins, "start_s": begins * 3600}
            self._row: dict[str, Any] = {**begin, **dict.fromkeys(self._counted, 0), "backlog": 0}
            self._rows.append(self._row)
            self._over = (begins + 1) * TICKS_PER_HOUR

    def rows(
        self, end: int, metres: Mapping[int, int], more: Mapping[str, Count] | None = None
    ) -> list[dict[str, Any]]:
        """Return a row for each hour that the run has seen; ``backlog`` is that at the end of the hour.

        ``metres`` are those that robots drove, by hour. ``stations_open`` and ``robots_on_duty``, where stations or
        robots come and go, are means over the hour, and so are ``more``.
        """
        self._until(max([max(end - 1, 0) // TICKS_PER_HOUR, *metres]))
        self._rows[-1]["backlog"] = self._backlog
        for row in self._rows:
            begin = max(row["hour"] * TICKS_PER_HOUR, self._began)
            until = max(min((row["hour"] + 1) * TICKS_PER_HOUR, end), begin)
            row["distance_m"] = metres.get(row["hour"], 0)
            for column, number in {**self._there, **(more or {})}.items():
                row[column] = round(number.mean(begin, until), 3)
        return self._rows
