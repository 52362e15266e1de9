"""Metrics and delays of `rmfs_details`, worked out anew from a trace."""

from __future__ import annotations

import csv
import io
from collections import Counter, defaultdict
from itertools import pairwise
from pathlib import Path

import numpy as np

from rmfs_core.clock import TICKS_PER_S, to_ticks
from rmfs_core.errors import InputError
from rmfs_core.events import (
    ItemPicked,
    OrderAssigned,
    OrderCompleted,
    PodLifted,
    PodStored,
    QueueJoined,
    RobotMoved,
    TaskAssigned,
    VisitEnded,
    VisitStarted,
)
from rmfs_trace.reader import Trace
from rmfs_validation.case import Case

DELAYS_FILE = "delays.csv"
PARTS = ("backlog_s", "other_parts_s", "fetch_s", "driving_s", "queueing_s", "station_s")


def measured_from(trace: Trace) -> int:
    """Return the tick from which on is measured."""
    return to_ticks(trace.scenario.get("run", {}).get("warmup_s") or 0)


def recompute_details(trace: Trace) -> dict[str, float | None]:
    """Every metric of `rmfs_details` by name."""
    begin = measured_from(trace)
    orders = trace.instance.orders
    done = {event.order: event.tick for event in trace.events if isinstance(event, OrderCompleted)}
    assigned = {event.order: event.tick for event in trace.events if isinstance(event, OrderAssigned)}
    after = [order for order in done if done[order] >= begin]
    timed = [order for order in after if orders[order].arrival_tick >= begin]
    times = {
        "turnover": [done[i] - orders[i].arrival_tick for i in timed],
        "turnover_backlog": [assigned.get(i, done[i]) - orders[i].arrival_tick for i in timed],
        "turnover_station": [done[i] - assigned.get(i, done[i]) for i in timed],
    }
    visits = sum(isinstance(event, VisitStarted) and event.tick >= begin for event in trace.events)
    lines = [quantity for order in after for _, quantity in orders[order].lines]
    found: dict[str, float | None] = {
        "items_per_line": float(np.mean(lines)) if lines else None,
        "orders_per_visit": len(after) / visits if visits else None,
        "waiting_per_visit_s": _waiting(trace, begin) / TICKS_PER_S / visits if visits else None,
    }
    for name, values in times.items():
        found[f"{name}_median_s"] = _percentile(values, 50)
        found[f"{name}_p95_s"] = _percentile(values, 95)
    return found | _lateness(trace, begin, done)


def _lateness(trace: Trace, begin: int, done: dict[int, int]) -> dict[str, float | None]:
    due = {i: order.due_tick for i, order in enumerate(trace.instance.orders) if order.due_tick is not None}
    if not due:
        return {}
    counted = {i: tick for i, tick in due.items() if trace.instance.orders[i].arrival_tick >= begin}
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


def _waiting(trace: Trace, begin: int) -> int:
    """Return the ticks in which robots under way did nothing, up to the last that they are known to have done.

    Under way is a robot from a task, or from leaving a station, until it joins a queue or has stored its pod.
    """
    since: dict[int, int] = {}  # robot -> until when all of its time under way is accounted for
    serving = {pod: start["robot"] for pod, start in enumerate(trace.pods)}
    total = 0
    for event in trace.events:
        match event:
            case TaskAssigned():
                since[event.robot] = event.tick
            case RobotMoved() | PodLifted() | PodStored():
                if event.robot in since:
                    still = event.start_tick + (event.wait_ticks if isinstance(event, RobotMoved) else 0)
                    total += max(0, still - max(since[event.robot], begin))
                    since[event.robot] = event.tick
                if isinstance(event, PodStored):
                    since.pop(event.robot, None)
            case QueueJoined():
                since.pop(event.robot, None)
            case VisitStarted():
                serving[event.pod] = event.robot
            case VisitEnded():
                since[serving[event.pod]] = event.tick
    return total


def delays_of(trace: Trace) -> dict[str, dict[str, float | None]]:
    """Return what the turn-over time of each order went to, in seconds, by the order's name and the file's columns."""
    steps: dict[int, list[tuple[int, int, str]]] = defaultdict(list)  # pod -> place in the trace, tick, kind
    assigned: dict[int, list[int]] = defaultdict(list)
    last_pick: dict[int, tuple[int, int]] = {}
    found: dict[str, dict[str, float | None]] = {}
    for place, event in enumerate(trace.events):
        match event:
            case PodLifted() | QueueJoined() | VisitStarted() | VisitEnded():
                steps[event.pod].append((place, event.tick, type(event).__name__))
            case OrderAssigned():
                assigned[event.order].append(event.tick)
            case ItemPicked():
                last_pick[event.order] = (place, event.pod)
    done = {event.order: event.tick for event in trace.events if isinstance(event, OrderCompleted)}
    for i, order in enumerate(trace.instance.orders):
        if i not in done or i not in last_pick or not assigned[i]:
            found[order.name] = dict.fromkeys(("turnover_s", *PARTS))
            continue
        place, pod = last_pick[i]
        at = []
        for kinds in (("VisitStarted",), ("QueueJoined",), ("PodLifted", "VisitEnded")):
            place, tick = next(((p, t) for p, t, kind in reversed(steps[pod]) if p < place and kind in kinds), (-1, 0))
            at.append(tick)
        bounds = [order.arrival_tick, assigned[i][0], assigned[i][-1]]
        bounds += [max(tick, assigned[i][-1]) for tick in reversed(at)] + [done[i]]
        parts = [(later - earlier) / TICKS_PER_S for earlier, later in pairwise(bounds)]
        whole = (done[i] - order.arrival_tick) / TICKS_PER_S
        found[order.name] = {"turnover_s": whole, **dict(zip(PARTS, parts, strict=True))}
    return found


def check_delays(case: Case, file: Path) -> None:
    """Add a fault for each time in delays.csv that the trace contradicts.

    Raises
    ------
    InputError
        When the file cannot be read or has other columns.
    """
    try:
        rows = list(csv.DictReader(io.StringIO(file.read_text(encoding="utf-8"))))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(str(file), f"cannot be read: {error}") from error
    expected = delays_of(case.trace)
    if [row.get("order") for row in rows] != list(expected):
        case.add("delay", case.trace.tick, f"{file.name} lists other orders than the trace")
        return
    for row in rows:
        for column, value in expected[row["order"]].items():
            reported = row.get(column)
            if reported != ("" if value is None else str(value)):
                tells = f"{file.name} has {reported or 'nothing'} as {column} of order {row['order']}"
                case.add(
                    "delay", case.trace.tick, f"{tells}; the trace amounts to {'nothing' if value is None else value}"
                )
