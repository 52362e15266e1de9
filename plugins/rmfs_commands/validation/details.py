"""Metrics and delays of `rmfs_commands.details`, worked out anew from a trace."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Container
from itertools import pairwise

import numpy as np

from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.robots import recompute_robots
from rmfs_commands.validation.stock import joined_at, lets_wait
from rmfs_commands.validation.tables import (
    FOR_ROOM,
    STATES,
    Row,
    arrivals_of,
    has_hours,
    measured_from,
    stations_of,
    waiting_ticks,
)
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.events import (
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCompleted,
    PodLifted,
    QueueJoined,
    VisitEnded,
    VisitStarted,
)

PARTS = ("backlog_s", "other_parts_s", "fetch_s", "driving_s", "queueing_s", "station_s")
HANDLED = (*PARTS, "handling_s")
"""Where orders are complete only when their last item is handled."""
WAITED = "stock_s"
"""The first part, where orders may wait for stock."""


def recompute_details(trace: Trace) -> dict[str, float | None]:
    """Every metric of `rmfs_commands.details` by name."""
    begin = measured_from(trace)
    orders, arrivals = trace.instance.orders, arrivals_of(trace)
    done = {event.order: event.tick for event in trace.events if isinstance(event, OrderCompleted)}
    assigned = {event.order: event.tick for event in trace.events if isinstance(event, OrderAssigned)}
    after = [order for order in done if done[order] >= begin]
    timed = [order for order in after if arrivals.get(order, done[order]) >= begin]
    times = {
        "turnover": [done[i] - arrivals.get(i, done[i]) for i in timed],
        "turnover_backlog": [assigned.get(i, done[i]) - arrivals.get(i, done[i]) for i in timed],
        "turnover_station": [done[i] - assigned.get(i, done[i]) for i in timed],
    }
    picking = len(trace.stations) - trace.layout.replenishing
    started = [event for event in trace.events if isinstance(event, VisitStarted) and event.station < picking]
    visits = sum(event.tick >= begin for event in started)
    waiting: Counter[str] = Counter()
    for (_, state), ticks in waiting_ticks(trace).items():
        waiting[state] += ticks
    lines = [quantity for order in after for _, quantity in orders[order].lines]
    found: dict[str, float | None] = {
        "items_per_line": float(np.mean(lines)) if lines else None,
        "orders_per_visit": len(after) / visits if visits else None,
        "waiting_per_visit_s": sum(waiting[state] for state in STATES) / TICKS_PER_S / visits if visits else None,
        "waiting_for_room_per_visit_s": waiting[FOR_ROOM] / TICKS_PER_S / visits if visits else None,
    }
    for name, values in times.items():
        found[f"{name}_median_s"] = _percentile(values, 50)
        found[f"{name}_p95_s"] = _percentile(values, 95)
    return (
        found
        | _left(trace, done)
        | _opening(trace)
        | _lateness(trace, begin, done)
        | recompute_robots(trace, begin, len(after))
    )


def _left(trace: Trace, done: Container[int]) -> dict[str, float | None]:
    """Return what is open at the end."""
    arrived = {event.order: event.tick for event in trace.events if isinstance(event, OrderArrived)}
    whole = {event.order for event in trace.events if isinstance(event, OrderAssigned) and event.complete}
    ages = [(trace.tick - tick) / TICKS_PER_S for order, tick in arrived.items() if order not in done]
    return {
        "open_orders_end": len(ages),
        "backlog_end": len(arrived.keys() - whole),
        "open_age_s": float(np.mean(ages)) if ages else None,
        "open_age_max_s": max(ages, default=None),
    }


def _opening(trace: Trace) -> dict[str, float | None]:
    if not has_hours(trace):
        return {}
    rows = stations_of(trace)
    opened, busy = (sum(float(row[column] or 0) for row in rows) for column in ("open_s", "busy_s"))
    return {"station_open_h": opened / 3600, "open_utilisation_percent": 100 * busy / opened if opened else None}


def _lateness(trace: Trace, begin: int, done: dict[int, int]) -> dict[str, float | None]:
    due = {i: order.due_tick for i, order in enumerate(trace.instance.orders) if order.due_tick is not None}
    if not due:
        return {}
    arrivals = arrivals_of(trace)
    counted = {i: tick for i, tick in due.items() if arrivals.get(i, -1) >= begin}
    known = [i for i, tick in counted.items() if i in done or tick < max(trace.tick, begin)]
    late = {i for i in known if i not in done or done[i] > due[i]}
    tardiness = [max(0, done[i] - due[i]) for i in known if i in done]
    priorities = Counter(trace.instance.orders[i].priority for i in known)
    late_of = Counter(trace.instance.orders[i].priority for i in late)
    return {
        "late_orders": len(late),
        "late_percent": 100 * len(late) / len(known) if known else None,
        "on_time_percent": 100 - 100 * len(late) / len(known) if known else None,
        "tardiness_s": float(np.mean(tardiness)) / TICKS_PER_S if tardiness else None,
        "tardiness_p95_s": _percentile(tardiness, 95),
        **{f"on_time_percent_priority_{one}": 100 - 100 * late_of[one] / n for one, n in priorities.items()},
    }


def _percentile(values: list[int], percent: float) -> float | None:
    return float(np.percentile(values, percent)) / TICKS_PER_S if values else None


def delays_of(trace: Trace) -> list[Row]:
    """Return the rows of delays.csv: what the turn-over time of each order went to."""
    steps: dict[int, list[tuple[int, int, str]]] = defaultdict(list)  # pod -> place in the trace, tick, kind
    assigned: dict[int, list[int]] = defaultdict(list)
    last_pick: dict[int, tuple[int, int, int]] = {}
    handled = trace.scenario.get("stations", {}).get("release") == "handled"
    waits = lets_wait(trace)
    columns = (*((WAITED,) if waits else ()), *(HANDLED if handled else PARTS))
    arrivals, joined = arrivals_of(trace), joined_at(trace)
    found: list[Row] = []
    for place, event in enumerate(trace.events):
        match event:
            case PodLifted() | QueueJoined() | VisitStarted() | VisitEnded():
                steps[event.pod].append((place, event.tick, type(event).__name__))
            case OrderAssigned():
                assigned[event.order].append(event.tick)
            case ItemPicked():
                last_pick[event.order] = (place, event.pod, event.tick)
    done = {event.order: event.tick for event in trace.events if isinstance(event, OrderCompleted)}
    for i, order in enumerate(trace.instance.orders):
        if i not in done or i not in last_pick or i not in arrivals or not assigned[i]:
            found.append({"order": order.name, **dict.fromkeys(("turnover_s", *columns))})
            continue
        place, pod, picked = last_pick[i]
        at = []
        for kinds in (("VisitStarted",), ("QueueJoined",), ("PodLifted", "VisitEnded")):
            place, tick = next(((p, t) for p, t, kind in reversed(steps[pod]) if p < place and kind in kinds), (-1, 0))
            at.append(tick)
        bounds = [arrivals[i], *([joined.get(i, arrivals[i])] if waits else []), assigned[i][0], assigned[i][-1]]
        bounds += [max(tick, assigned[i][-1]) for tick in reversed(at)]
        bounds += [picked, done[i]] if handled else [done[i]]
        parts = [(later - earlier) / TICKS_PER_S for earlier, later in pairwise(bounds)]
        whole = (done[i] - arrivals[i]) / TICKS_PER_S
        found.append({"order": order.name, "turnover_s": whole, **dict(zip(columns, parts, strict=True))})
    return found
