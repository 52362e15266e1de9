"""What happens in each hour: rows of hours.csv."""

from __future__ import annotations

from typing import Any

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.events import (
    Event,
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCompleted,
    RobotMoved,
    VisitStarted,
)
from rmfs_details.spans import Handlers

COUNTED = ("orders_in", "orders_out", "picks", "visits", "distance_m")
_HOUR = 3600 * TICKS_PER_S


class Hours:
    """Counts by the hour, from time 0 on; what takes time counts in the hour in which it ends."""

    def __init__(self) -> None:
        self._rows: list[dict[str, Any]] = []
        self._backlog = 0
        self.handlers: Handlers = {
            OrderArrived: self._arrived,
            OrderAssigned: self._assigned,
            OrderCompleted: lambda event: self._count(event, "orders_out"),
            ItemPicked: lambda event: self._count(event, "picks"),
            VisitStarted: lambda event: self._count(event, "visits"),
            RobotMoved: lambda event: self._count(event, "distance_m", event.distance_m),
        }

    def _arrived(self, event: OrderArrived) -> None:
        self._count(event, "orders_in")
        self._backlog += 1

    def _assigned(self, event: OrderAssigned) -> None:
        self._until(event.tick // _HOUR)
        self._backlog -= event.complete

    def _count(self, event: Event, what: str, number: int = 1) -> None:
        self._until(event.tick // _HOUR)
        self._rows[-1][what] += number

    def _until(self, hour: int) -> None:
        """Begin hours up to one, each with the backlog that the one before it has left."""
        while len(self._rows) <= hour:
            if self._rows:
                self._rows[-1]["backlog"] = self._backlog
            begin = {"hour": len(self._rows), "start_s": len(self._rows) * 3600}
            self._rows.append({**begin, **dict.fromkeys(COUNTED, 0), "backlog": 0})

    def rows(self, end: int) -> list[dict[str, Any]]:
        """Return a row for each hour that the run has seen; ``backlog`` is that at the end of the hour."""
        self._until(max(end - 1, 0) // _HOUR)
        self._rows[-1]["backlog"] = self._backlog
        return self._rows
