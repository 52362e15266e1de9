"""orders.csv, visits.csv and periods.csv, worked out anew from a trace."""

from __future__ import annotations

from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.tables import Row, arrivals_of, cancelled_in, may_cancel
from rmfs_core.clock import to_seconds
from rmfs_core.events import DecisionMade, ItemPicked, OrderAssigned, OrderCompleted, VisitEnded, VisitStarted


def orders_of(trace: Trace) -> list[Row]:
    """Return the rows of orders.csv; due times and priorities where any order has one."""
    parts: dict[int, dict[tuple[int, int], None]] = {}
    assigned: dict[int, int] = {}
    for event in trace.events:
        if isinstance(event, OrderAssigned):
            parts.setdefault(event.order, {})[event.station, event.period] = None
            if event.complete:
                assigned[event.order] = event.tick
    done = {event.order: event.tick for event in trace.events if isinstance(event, OrderCompleted)}
    dated = any(order.due_tick is not None or order.priority for order in trace.instance.orders)
    arrivals, cancelled = arrivals_of(trace), cancelled_in(trace)
    rows: list[Row] = []
    for i, order in enumerate(trace.instance.orders):
        arrival = arrivals.get(i)
        stations = dict.fromkeys(station for station, _ in parts.get(i, {}))
        rows.append(
            {
                "order": order.name,
                "arrival_s": _between(0, arrival),
                "items": sum(quantity for _, quantity in order.lines),
                "lines": len(order.lines),
                "parts": len(parts.get(i, {})),
                "stations": " ".join(str(station + 1) for station in stations),
                "assigned_s": _between(0, assigned.get(i)),
                "completed_s": _between(0, done.get(i)),
                "turnover_s": _between(arrival, done.get(i)),
                "turnover_backlog_s": _between(arrival, assigned.get(i)),
                "turnover_station_s": _between(assigned.get(i), done.get(i)),
            }
        )
        if dated:
            rows[-1] |= {
                "due_s": _between(0, order.due_tick),
                "priority": order.priority,
                "lateness_s": _between(order.due_tick, done.get(i)),
            }
        if any(one.route is not None for one in trace.instance.orders):
            rows[-1]["route"] = order.route or ""
        if may_cancel(trace):
            rows[-1]["cancelled_s"] = _between(0, cancelled.get(i))
    return rows


def visits_of(trace: Trace) -> list[Row]:
    """Return the rows of visits.csv."""
    rows: dict[int, Row] = {}
    picks: dict[int, int] = {}
    begun: dict[int, int] = {}
    for event in trace.events:
        match event:
            case VisitStarted():
                if trace.state is not None:
                    begun[event.visit] = event.tick
                rows[event.visit] = {
                    "visit": event.visit,
                    "pod": trace.instance.pods[event.pod].name,
                    "station": str(event.station + 1),
                    "robot": str(event.robot + 1),
                    "start_s": to_seconds(event.tick),
                    "end_s": None,
                }
            case VisitEnded() if event.visit in rows:
                rows[event.visit]["end_s"] = to_seconds(event.tick)
                if begun.get(event.visit, event.tick) <= trace.began:  # some were picked before the run began
                    picks[event.visit] = event.picks
            case ItemPicked():
                picks[event.visit] = picks.get(event.visit, 0) + 1
    return [row | {"picks": picks.get(visit, 0)} for visit, row in rows.items()]


def periods_of(trace: Trace) -> list[Row]:
    """Return the rows of periods.csv, except for the seconds that the wall clock says."""
    return [
        {
            "period": event.period,
            "time_s": to_seconds(event.tick),
            "decides": event.decides.label,
            "rule": event.rule,
            "backlog": event.backlog,
            "assignments": event.assignments,
            "trips": event.trips,
            "status": event.status,
            "objective": None if event.objective is None else float(event.objective),
            "bound": None if event.bound is None else float(event.bound),
            "stopped_early": str(event.stopped_early).lower(),
        }
        for event in trace.events
        if isinstance(event, DecisionMade)
    ]


def _between(earlier: int | None, later: int | None) -> float | None:
    return None if earlier is None or later is None else to_seconds(later - earlier)
