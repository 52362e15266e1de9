"""Shares of each station's time: rows of stations.csv."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from typing import Any

from rmfs_commands.details.spans import Count, Number, Span, length, merged, outside, overlap, ratio, within
from rmfs_commands.processes.events import StationDown, StationUp
from rmfs_core.clock import to_seconds
from rmfs_core.events import (
    BundleStored,
    Event,
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCancelled,
    OrderInStock,
    QueueJoined,
    StationClosed,
    StationOpened,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.info import RunInfo


class Followed:
    """State of a station: visits, picks, when its picker was busy, it was open and out of service, requests, queue."""

    def __init__(self) -> None:
        self.visits, self.picks = array("q"), array("q")
        self.begun, self.free = array("q"), array("q")  # when its picker took an item, and had handled it
        self.stored: list[Span] = []  # when bundles were stored
        self.requests = Count()
        self.queue = Count()
        self.open = Count()
        self.open.add(0, 1)
        self.down, self.pods = Count(), Count()  # the second, pods at the station, only where stations may fail


class Stations:
    """Follows the stations.

    Parameters
    ----------
    run
        The run.
    """

    def __init__(self, run: RunInfo) -> None:
        self._names = [station.name for station in run.warehouse.stations]
        self.followed = [Followed() for _ in self._names]
        self._backlog, self._view = Count(), run.warehouse
        self._waiting: set[int] = set()  # orders that wait for stock
        self._fails = run.scenario.stations.outages is not None
        self._has_hours = run.scenario.stations.open is not None or run.scenario.rules.activate is not None
        for station, known in zip(run.warehouse.stations, self.followed, strict=True):
            known.queue.add(0, len(station.line))
        self.handlers: dict[type[Event], Callable[[Any], None]] = {
            OrderArrived: self._arrived,
            OrderInStock: self._in_stock,
            OrderAssigned: self._assigned,
            OrderCancelled: self._cancelled,
            QueueJoined: lambda event: self.followed[event.station].queue.add(event.tick, 1),
            VisitStarted: self._started,
            ItemPicked: self._picked,
            BundleStored: lambda event: self.followed[event.station].stored.append((event.start_tick, event.tick)),
            StationOpened: lambda event: self.followed[event.station].open.add(event.tick, 1),
            StationClosed: lambda event: self.followed[event.station].open.add(event.tick, -1),
            StationDown: lambda event: self.followed[event.station].down.add(event.tick, 1),
            StationUp: lambda event: self.followed[event.station].down.add(event.tick, -1),
        }
        if self._fails:
            self.handlers |= {VisitEnded: lambda event: self.followed[event.station].pods.add(event.tick, -1)}

    def _arrived(self, event: OrderArrived) -> None:
        if self._view.order(event.order).waits_for_stock:
            self._waiting.add(event.order)
        else:
            self._backlog.add(event.tick, 1)

    def _in_stock(self, event: OrderInStock) -> None:
        self._waiting.discard(event.order)
        self._backlog.add(event.tick, 1)

    def _cancelled(self, event: OrderCancelled) -> None:
        if event.order not in self._waiting:
            self._backlog.add(event.tick, -1)

    def _assigned(self, event: OrderAssigned) -> None:
        self.followed[event.station].requests.add(event.tick, event.items)
        if event.complete:
            self._backlog.add(event.tick, -1)

    def _started(self, event: VisitStarted) -> None:
        station = self.followed[event.station]
        station.queue.add(event.tick, -1)
        station.visits.append(event.tick)
        if self._fails:
            station.pods.add(event.tick, 1)

    def _picked(self, event: ItemPicked) -> None:
        station = self.followed[event.station]
        station.requests.add(event.tick, -1)
        station.picks.append(event.tick)
        station.begun.append(event.start_tick)
        station.free.append(event.picker_free_tick)

    def rows(self, begin: int, end: int) -> list[dict[str, Any]]:
        """Return a row for each station, of what there was between two times.

        ``busy_s``, ``waiting_s`` and ``idle_s`` add up to the time between them: the picker handles an item; or does
        not, though items are to be picked there (they wait for pods); or nothing is to be picked. ``starved_s`` is
        the part of ``idle_s`` in which orders are in the backlog, without orders that wait for stock. Where stations
        open and close, the three add up to ``open_s``, the time in which a station is open or still finishes what it
        has. ``down_s``, where stations may fail, is the time out of service, and in none of the others.
        """
        orders_wait = self._backlog.above_zero(begin, end)
        found = []
        for name, station in zip(self._names, self.followed, strict=True):
            busy = merged(within(zip(station.begun, station.free, strict=True), begin, end))
            down = outside(station.down.above_zero(begin, end), busy)  # it finishes the item in hand
            wanted = outside(station.requests.above_zero(begin, end), down)
            either = merged([*busy, *wanted])
            there = merged([*either, *station.open.above_zero(begin, end)])
            times = {
                "busy_s": length(busy),
                "waiting_s": length(either) - length(busy),
                "idle_s": length(there) - length(either),
                "starved_s": overlap(orders_wait, there) - overlap(orders_wait, either),
                **({"open_s": length(there)} if self._has_hours else {}),
                **({"down_s": length(down)} if self._fails else {}),
            }
            found.append(
                {
                    "station": name,
                    "picks": sum(tick >= begin for tick in station.picks),
                    "visits": sum(tick >= begin for tick in station.visits),
                    **{column: to_seconds(ticks) for column, ticks in times.items()},
                    "queue_mean": round(station.queue.mean(begin, end), 6),
                    "queue_max": station.queue.largest(begin, end),
                }
            )
        return found

    def paid_ticks(self, begin: int, end: int) -> int:
        """Return the time in which pickers are paid between two times, summed over stations.

        A picker is paid while the station is open, finishes what it has or stores a bundle, and through an outage that
        begins then.
        """
        found = 0
        for station in self.followed:
            busy, counts = zip(station.begun, station.free, strict=True), (station.requests, station.open)
            there = merged([*busy, *station.stored, *(span for one in counts for span in one.above_zero(0, end))])
            failed = [down for down in station.down.above_zero(0, end) if any(a < down[0] <= b for a, b in there)]
            found += length(within(merged([*there, *failed]), begin, end))
        return found

    def values(self, begin: int, end: int) -> dict[str, Number]:
        """Return the metrics of opening hours; none where stations are always open."""
        if not self._has_hours:
            return {}
        rows = self.rows(begin, end)
        opened, busy = (sum(row[column] for row in rows) for column in ("open_s", "busy_s"))
        return {"station_open_h": opened / 3600, "open_utilisation_percent": ratio(100 * busy, opened)}
