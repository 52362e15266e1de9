"""The rows of orders.csv, visits.csv and periods.csv. People's names of orders, pods and stations, times in seconds.

It is the entry point ``tables`` of the group ``rmfs.formats``: what tables a run's result has.
"""

from __future__ import annotations

import math
import sys
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rmfs_core.clock import to_seconds
from rmfs_core.events import (
    DecisionMade,
    Event,
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCancelled,
    OrderCompleted,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.hookspecs import hookimpl
from rmfs_core.world import Instance

if TYPE_CHECKING:
    from rmfs_core.info import RunInfo

Row = dict[str, Any]

ORDER_COLUMNS: dict[str, type] = {
    "order": str,
    "arrival_s": float,
    "items": int,
    "lines": int,
    "parts": int,
    "stations": str,
    "assigned_s": float,
    "completed_s": float,
    "turnover_s": float,
    "turnover_backlog_s": float,
    "turnover_station_s": float,
}
"""Columns of orders.csv. ``parts``: assignments (station and period); ``stations``: their numbers, first assigned
first, separated by blanks; ``assigned_s``: when the last line was assigned. Empty where it has not come to that."""

DUE_COLUMNS: dict[str, type] = {"due_s": float, "priority": int, "lateness_s": float}
"""Further columns of orders.csv where any order has a due time or a priority. Negative lateness is time to spare."""

ROUTE_COLUMNS: dict[str, type] = {"route": str}
"""A further column of orders.csv where any order goes with the trucks of a route."""

CANCELLED_COLUMNS: dict[str, type] = {"cancelled_s": float}
"""The last column of orders.csv where any order may be cancelled: when it left; empty for one that was picked."""

VISIT_COLUMNS: dict[str, type] = {
    "visit": int,
    "pod": str,
    "station": str,
    "robot": str,
    "start_s": float,
    "end_s": float,
    "picks": int,
}
"""Columns of visits.csv: one row a pod-station visit; ``end_s`` is empty where the run ended first."""

PERIOD_COLUMNS: dict[str, type] = {
    "period": int,
    "time_s": float,
    "decides": str,
    "rule": str,
    "backlog": int,
    "assignments": int,
    "trips": int,
    "status": str,
    "objective": float,
    "bound": float,
    "stopped_early": bool,
    "seconds": float,
}
"""Columns of periods.csv: one row a decision (`rmfs_core.events.DecisionMade`). ``seconds``, the last one, is
wall-clock time and the only column that differs from run to run."""


TABLE_FILES = {
    "orders": ("orders.csv", ORDER_COLUMNS),
    "visits": ("visits.csv", VISIT_COLUMNS),
    "periods": ("periods.csv", PERIOD_COLUMNS),
}

AT_ONCE = 256
"""Decisions that become rows of periods.csv together."""


class _Rows:
    """Rows kept as columns, numbers as bare ones (NaN where there is none): a run of days has very many."""

    def __init__(self, types: Mapping[str, type]) -> None:
        self.types, codes = types, {int: "q", float: "d", bool: "b"}
        self.columns: dict[str, Any] = {name: array(codes[t]) if t in codes else [] for name, t in types.items()}
        self._append = [column.append for column in self.columns.values()]

    def add(self, *values: Any) -> None:
        for append, value in zip(self._append, values, strict=True):
            append(value)

    def extend(self, rows: Iterable[tuple[Any, ...]]) -> None:
        for column, values in zip(self.columns.values(), zip(*rows, strict=True), strict=False):
            column.extend(values)

    def rows(self) -> list[Row]:
        shown = [(name, finite if kind is float else kind) for name, kind in self.types.items()]
        rows = zip(*self.columns.values(), strict=True)
        return [{name: show(value) for (name, show), value in zip(shown, row, strict=True)} for row in rows]


class Tables:
    """Observer that collects the rows."""

    def __init__(self) -> None:
        self.hears: Mapping[type[Event], Sequence[Callable[[Any], None]]] = {
            DecisionMade: (self._decided,),
            ItemPicked: (self._picked,),
            OrderArrived: (self._order_arrived,),
            OrderAssigned: (self._order_assigned,),
            OrderCompleted: (self._order_completed,),
            OrderCancelled: (self._order_cancelled,),
            VisitStarted: (self._visit_started,),
            VisitEnded: (self._visit_ended,),
        }
        self.begin(Instance((), (), ()))

    def begin(self, instance: Instance, *, refilled: bool = False) -> None:
        """Start afresh for an instance; ``refilled``: its orders do not know beforehand when they arrive."""
        self.instance = instance
        self._arrived = {} if refilled else {i: order.arrival_tick for i, order in enumerate(instance.orders)}
        self._visits, self._periods = _Rows(VISIT_COLUMNS), _Rows(PERIOD_COLUMNS)
        self._at: dict[int, int] = {}  # rows of visits that have not ended
        self._decisions: list[DecisionMade] = []
        self._parts: dict[int, dict[tuple[int, int], None]] = {}
        self._assigned: dict[int, int] = {}
        self._completed: dict[int, int] = {}
        self._cancelled: dict[int, int] = {}

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Start afresh."""
        self.begin(run.instance, refilled=run.scenario.instance.arrivals.backlog is not None)

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Add to the rows."""
        for add in self.hears.get(type(event), ()):
            add(event)

    def _picked(self, event: ItemPicked) -> None:
        if (row := self._at.get(event.visit)) is not None:  # else it ended before a run that began in a state
            self._visits.columns["picks"][row] += 1

    def _order_arrived(self, event: OrderArrived) -> None:
        self._arrived[event.order] = event.tick

    def _order_assigned(self, event: OrderAssigned) -> None:
        self._parts.setdefault(event.order, {})[event.station, event.period] = None
        if event.complete:
            self._assigned[event.order] = event.tick

    def _order_completed(self, event: OrderCompleted) -> None:
        self._completed[event.order] = event.tick

    def _order_cancelled(self, event: OrderCancelled) -> None:
        self._cancelled[event.order] = event.tick

    def _visit_started(self, event: VisitStarted) -> None:
        pod, self._at[event.visit] = self.instance.pods[event.pod].name, len(self._visits.columns["picks"])
        self._visits.add(event.visit, pod, event.station + 1, event.robot + 1, event.time_s, math.nan, 0)

    def _visit_ended(self, event: VisitEnded) -> None:
        if (row := self._at.pop(event.visit, None)) is not None:
            self._visits.columns["end_s"][row], self._visits.columns["picks"][row] = event.time_s, event.picks

    def _decided(self, event: DecisionMade) -> None:
        self._decisions.append(event)
        if len(self._decisions) == AT_ONCE:
            self._take_in()

    def _take_in(self) -> None:
        """Turn decisions into rows: many at once are quicker, and all of a run would take much memory."""
        self._periods.extend(map(_period, self._decisions))
        self._decisions.clear()

    @property
    def visits(self) -> list[Row]:
        """Rows of visits.csv."""
        return self._visits.rows()

    @property
    def periods(self) -> list[Row]:
        """Rows of periods.csv."""
        self._take_in()
        return self._periods.rows()

    @property
    def orders(self) -> list[Row]:
        """Rows of orders.csv, one for every order of the instance."""
        dated = self.instance.dated
        cancelled = any(order.cancelled_tick is not None for order in self.instance.orders)
        routed = any(order.route is not None for order in self.instance.orders)
        return [self._order(i, dated, routed, cancelled) for i in range(len(self.instance.orders))]

    def _order(self, i: int, dated: bool, routed: bool, cancelled: bool) -> Row:
        order = self.instance.orders[i]
        parts = self._parts.get(i, {})
        arrived, assigned, completed = self._arrived.get(i), self._assigned.get(i), self._completed.get(i)
        late = None if order.due_tick is None else _seconds(completed, order.due_tick)
        due = {"due_s": _seconds(order.due_tick), "priority": order.priority, "lateness_s": late}
        return {
            "order": order.name,
            "arrival_s": _seconds(arrived),
            "items": order.items,
            "lines": len(order.lines),
            "parts": len(parts),
            "stations": " ".join(str(s + 1) for s in dict.fromkeys(station for station, _ in parts)),
            "assigned_s": _seconds(assigned),
            "completed_s": _seconds(completed),
            "turnover_s": _seconds(completed, arrived),
            "turnover_backlog_s": _seconds(assigned, arrived),
            "turnover_station_s": _seconds(completed, assigned),
            **(due if dated else {}),
            **({"route": order.route or ""} if routed else {}),
            **({"cancelled_s": _seconds(self._cancelled.get(i))} if cancelled else {}),
        }


def _period(event: DecisionMade) -> tuple[Any, ...]:
    return (
        event.period,
        event.time_s,
        event.decides.label,
        event.rule,
        event.backlog,
        event.assignments,
        event.trips,
        sys.intern(event.status),
        math.nan if event.objective is None else event.objective,
        math.nan if event.bound is None else event.bound,
        bool(event.stopped_early),
        event.wall_s,
    )


def _seconds(tick: int | None, since: int | None = 0) -> float | None:
    return None if tick is None or since is None else to_seconds(tick - since)


def finite(value: float | None) -> float | None:
    """Return a number as a float; None for what JSON cannot say (a bound of infinity, for example)."""
    return float(value) if value is not None and math.isfinite(value) else None
