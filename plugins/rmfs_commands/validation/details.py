"""Metrics and delays of `rmfs_commands.details`, worked out anew from a trace."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter, defaultdict

import numpy as np

from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.robots import recompute_robots
from rmfs_commands.validation.stock import joined_at, lets_wait
from rmfs_commands.validation.tables import (
    FOR_ROOM,
    STATES,
    Row,
    arrivals_of,
    cancelled_in,
    due_in,
    goes_on,
    has_batteries,
    has_hours,
    may_cancel,
    measured_from,
    none_free,
    recompute_outages,
    stations_of,
    waiting_ticks,
)
from rmfs_core.clock import TICKS_PER_S, to_ticks
from rmfs_core.events import (
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCompleted,
    PodLifted,
    QueueJoined,
    RobotMoved,
    TaskAssigned,
    VisitEnded,
    VisitStarted,
)

PARTS = (
    *("backlog_s", "other_parts_s", "robot_s", "pod_s", "to_pod_s", "room_s"),
    *("driving_s", "queueing_s", "station_s"),
)
HANDLED = (*PARTS, "handling_s")
"""Where orders are complete only when their last item is handled."""
WAY = ("Beneath", "Lifting", "PodLifted", "QueueJoined", "VisitStarted")
"""Steps of a pod after a robot was asked for."""
WAITED = "stock_s"
"""The first part, where orders may wait for stock."""


def recompute_details(trace: Trace) -> dict[str, float | None]:
    """Every metric of `rmfs_commands.details` by name."""
    begin = measured_from(trace)
    orders, arrivals = trace.instance.orders, arrivals_of(trace)
    done = {event.order: event.tick for event in trace.events if isinstance(event, OrderCompleted)}
    assigned = {event.order: event.tick for event in trace.events if isinstance(event, OrderAssigned)}
    after = [order for order in done if done[order] >= begin]
    timed = [order for order in after if goes_on(trace) or arrivals.get(order, done[order]) >= begin]
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
        | _cancelled(trace, begin)
        | _opening(trace)
        | _lateness(trace, begin, done)
        | recompute_robots(trace, begin, len(after))
        | recompute_outages(trace)
    )


def _left(trace: Trace, done: dict[int, int]) -> dict[str, float | None]:
    """Return what is open at the end."""
    arrived = {event.order: event.tick for event in trace.events if isinstance(event, OrderArrived)}
    whole = {event.order for event in trace.events if isinstance(event, OrderAssigned) and event.complete}
    gone = done | cancelled_in(trace)
    ages = [(trace.tick - tick) / TICKS_PER_S for order, tick in arrived.items() if order not in gone]
    return {
        "open_orders_end": len(ages),
        "backlog_end": len(arrived.keys() - whole - cancelled_in(trace).keys()),
        "open_age_sum_h": sum(ages) / 3600,
        "open_age_s": float(np.mean(ages)) if ages else None,
        "open_age_max_s": max(ages, default=None),
    }


def _cancelled(trace: Trace, begin: int) -> dict[str, float | None]:
    number = sum(tick >= begin for tick in cancelled_in(trace).values())
    return {"orders_cancelled": number} if may_cancel(trace) else {}


def _opening(trace: Trace) -> dict[str, float | None]:
    if not has_hours(trace):
        return {}
    rows = stations_of(trace)
    opened, busy = (sum(float(row[column] or 0) for row in rows) for column in ("open_s", "busy_s"))
    return {"station_open_h": opened / 3600, "open_utilisation_percent": 100 * busy / opened if opened else None}


def _lateness(trace: Trace, begin: int, done: dict[int, int]) -> dict[str, float | None]:
    if all(order.due_tick is None for order in trace.instance.orders):
        return {}
    counted = due_in(trace, done)
    end, until_s = max(trace.tick, begin), trace.scenario.get("run", {}).get("until_s")
    last = [] if until_s is None else [to_ticks(until_s)]  # what is due later nobody knows but of early orders
    if counted.keys() - done.keys():
        last.append(end)
    known = [i for i, tick in counted.items() if (i in done or tick < end) and all(tick <= one for one in last)]
    late = {i for i in known if i not in done or done[i] > counted[i]}
    tardiness = [max(0, done[i] - counted[i]) for i in counted if i in done]
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
    """Return the rows of delays.csv: what the turn-over time of each order went to.

    With batteries ``robot_s`` and ``pod_s`` are one: no event tells when a robot has too little charge to be free.
    """
    steps: dict[int, list[tuple[int, int, str]]] = defaultdict(list)  # pod -> line of the trace, tick, kind
    assigned: dict[int, list[int]] = defaultdict(list)
    last_pick: dict[int, tuple[int, int, int]] = {}
    still: dict[int, int] = {}  # robot -> when it last came to rest
    handled = trace.scenario.get("stations", {}).get("release") == "handled"
    waits = lets_wait(trace)
    columns = (*((WAITED,) if waits else ()), *(HANDLED if handled else PARTS))
    if charged := has_batteries(trace):
        columns = tuple("robot_s + pod_s" if name == "robot_s" else name for name in columns if name != "pod_s")
    arrivals, joined, without = arrivals_of(trace), joined_at(trace) if waits else {}, none_free(trace)
    found: list[Row] = []
    for place, event in enumerate(trace.events):
        match event:
            case PodLifted():
                beneath = min(still.get(event.robot, event.start_tick), event.start_tick)
                steps[event.pod] += [(place, beneath, "Beneath"), (place, event.start_tick, "Lifting")]
                steps[event.pod].append((place, event.tick, "PodLifted"))
            case TaskAssigned() | QueueJoined() | VisitStarted() | VisitEnded():
                steps[event.pod].append((place, event.tick, type(event).__name__))
                if isinstance(event, TaskAssigned):
                    still[event.robot] = event.tick
            case RobotMoved():
                still[event.robot] = event.tick
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
        last = assigned[i][-1]
        at = _way(steps[pod], place, last)
        robot = without(at["asked"]) - without(last)
        room = at["Lifting"] - at["Beneath"]
        ticks = [
            *([joined.get(i, arrivals[i]) - arrivals[i]] if waits else []),
            assigned[i][0] - joined.get(i, arrivals[i]),
            last - assigned[i][0],
            *([at["asked"] - last] if charged else [robot, at["asked"] - last - robot]),
            at["PodLifted"] - at["asked"] - room,
            room,
            at["QueueJoined"] - at["PodLifted"],
            at["VisitStarted"] - at["QueueJoined"],
            picked - at["VisitStarted"],
            *([done[i] - picked] if handled else []),
        ]
        parts = [number / TICKS_PER_S for number in ticks]
        whole = (done[i] - arrivals[i]) / TICKS_PER_S
        found.append({"order": order.name, "turnover_s": whole, **dict(zip(columns, parts, strict=True))})
    return found


def _way(steps: list[tuple[int, int, str]], place: int, last: int) -> dict[str, int]:
    """Return when a pod took each step before a line of the trace, none earlier than the tick of the last assignment.

    A pod that comes from another station is asked for, and lifted, when it leaves that.
    """
    at: dict[str, int] = {}
    begun = 0
    for _, tick, kind in reversed(steps[: bisect_left(steps, (place,))]):
        if kind not in WAY:
            begun = tick
            break
        at.setdefault(kind, tick)
    return {kind: max(at.get(kind, begun), last) for kind in ("asked", *WAY)}
