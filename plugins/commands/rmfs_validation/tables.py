"""hours.csv, stations.csv and robots.csv, worked out anew from a trace."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import TICKS_PER_S, to_ticks
from rmfs_core.events import (
    ItemPicked,
    OrderArrived,
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

Row = dict[str, float | str | None]
STATES = ("idle", "to_pod", "to_station", "queue", "station", "storing")
FOR_ROOM = "for room"
HOUR = 3600 * TICKS_PER_S


def measured_from(trace: Trace) -> int:
    """Return the tick from which on is measured."""
    return to_ticks(trace.scenario.get("run", {}).get("warmup_s") or 0)


def refilled(trace: Trace) -> int | None:
    """Return how many orders are kept in the backlog, as long as there are any; None where they come at their times."""
    backlog = trace.scenario.get("instance", {}).get("arrivals", {}).get("backlog")
    return None if backlog is None else int(backlog)


def arrivals_of(trace: Trace) -> dict[int, int]:
    """Return when each order arrives; not those that are kept for later when the run ends."""
    if refilled(trace) is None:
        return {i: order.arrival_tick for i, order in enumerate(trace.instance.orders)}
    return {event.order: event.tick for event in trace.events if isinstance(event, OrderArrived)}


def hours_of(trace: Trace) -> Iterator[Row]:
    """Yield the rows of hours.csv, which a trace of few events may have any number of."""
    counted: Counter[tuple[int, str]] = Counter()
    last = max(trace.tick - 1, 0) // HOUR
    for event in trace.events:
        number, hour = 1, event.tick // HOUR
        match event:
            case OrderArrived():
                what = "orders_in"
            case OrderAssigned():
                what, number = "left", int(event.complete)
            case OrderCompleted():
                what = "orders_out"
            case ItemPicked():
                what = "picks"
            case VisitStarted():
                what = "visits"
            case RobotMoved():
                what, number = "distance_m", int(trace.layout.distance(event.origin, event.to))
            case _:
                continue
        counted[hour, what] += number
        last = max(last, hour)
    backlog = 0
    for hour in range(last + 1):
        backlog += counted[hour, "orders_in"] - counted[hour, "left"]
        numbers = {what: counted[hour, what] for what in ("orders_in", "orders_out", "picks", "visits", "distance_m")}
        yield {"hour": hour, "start_s": hour * 3600, **numbers, "backlog": backlog}


def stations_of(trace: Trace) -> list[Row]:
    """Return the rows of stations.csv."""
    begin = measured_from(trace)
    end = max(trace.tick, begin)
    steps: dict[int, dict[str, list[tuple[int, int]]]] = defaultdict(lambda: defaultdict(list))
    totals: Counter[tuple[int, str]] = Counter()
    backlog: list[tuple[int, int]] = []
    for pod in trace.pods:
        if pod["robot"] is not None:
            steps[pod["bound_for"][0]]["queue"].append((0, 1))
    for event in trace.events:
        match event:
            case OrderArrived():
                backlog.append((event.tick, 1))
            case OrderAssigned():
                steps[event.station]["wanted"].append((event.tick, event.items))
                backlog.append((event.tick, -int(event.complete)))
            case QueueJoined():
                steps[event.station]["queue"].append((event.tick, 1))
            case VisitStarted():
                steps[event.station]["queue"].append((event.tick, -1))
                totals[event.station, "visits"] += event.tick >= begin
            case ItemPicked():
                steps[event.station]["wanted"].append((event.tick, -1))
                steps[event.station]["busy"] += [(event.start_tick, 1), (event.picker_free_tick, -1)]
                totals[event.station, "picks"] += event.tick >= begin
    rows: list[Row] = []
    for i, station in enumerate(trace.stations):
        changes = steps[i]
        every = [tick for kind in (*changes.values(), backlog) for tick, _ in kind]
        times = np.unique(np.clip([begin, end, *every], begin, end))
        lasts = np.diff(times)
        busy, wanted, queue = (_levels(times, changes[what]) for what in ("busy", "wanted", "queue"))
        works, lacks = busy > 0, (wanted > 0) & (busy == 0)
        rests = ~(works | lacks)
        spans = (works, lacks, rests, rests & (_levels(times, backlog) > 0))
        seconds = (int(lasts[span].sum()) / TICKS_PER_S for span in spans)
        rows.append(
            {
                "station": station["name"],
                "picks": totals[i, "picks"],
                "visits": totals[i, "visits"],
                **dict(zip(("busy_s", "waiting_s", "idle_s", "starved_s"), seconds, strict=True)),
                "queue_mean": round(int((lasts * queue).sum()) / max(end - begin, 1), 6),
                "queue_max": int(queue.max(initial=0)),
            }
        )
    return rows


def _levels(times: NDArray[np.int64], changes: Iterable[tuple[int, int]]) -> NDArray[np.int64]:
    """Return the number between any two times that follow each other, which changes add up to."""
    table = np.array([(0, 0), *changes], dtype=np.int64)
    found = np.zeros(len(times), dtype=np.int64)
    np.add.at(found, np.searchsorted(times, np.clip(table[:, 0], times[0], times[-1])), table[:, 1])
    return np.cumsum(found)[:-1]


def robots_of(trace: Trace) -> list[Row]:
    """Return the rows of robots.csv."""
    begin = measured_from(trace)
    carrying = {pod["robot"] for pod in trace.pods}
    turns = [[(0, "queue" if robot in carrying else "idle")] for robot in range(len(trace.robots))]
    metres: Counter[tuple[int, bool]] = Counter()
    serving = {pod: start["robot"] for pod, start in enumerate(trace.pods)}
    for event in trace.events:
        match event:
            case TaskAssigned():
                turns[event.robot].append((event.tick, "to_pod"))
            case PodLifted():
                turns[event.robot].append((event.tick, "to_station"))
            case QueueJoined():
                turns[event.robot].append((event.tick, "queue"))
            case VisitStarted():
                serving[event.pod] = event.robot
                turns[event.robot].append((event.tick, "station"))
            case VisitEnded():
                robot = serving[event.pod]
                if robot is not None:  # else nobody has told that the visit began
                    turns[robot].append((event.tick, "to_station" if event.next_station is not None else "storing"))
            case PodStored():
                turns[event.robot].append((event.tick, "idle"))
            case RobotMoved():
                if event.tick >= begin:
                    metres[event.robot, event.pod is not None] += int(trace.layout.distance(event.origin, event.to))
    still = waiting_ticks(trace)
    end = max(trace.tick, begin)
    rows: list[Row] = []
    for robot, turned in enumerate(turns):
        ticks = Counter({state: -still[robot, state] for state in STATES})
        for (since, state), (until, _) in pairwise([*turned, (end, "")]):
            ticks[state] += max(until, begin) - max(since, begin)
        rows.append(
            {
                "robot": str(robot + 1),
                "distance_m": metres[robot, False] + metres[robot, True],
                "loaded_distance_m": metres[robot, True],
                **{f"{state}_s": ticks[state] / TICKS_PER_S for state in STATES},
                "waiting_s": sum(still[robot, state] for state in STATES) / TICKS_PER_S,
            }
        )
    return rows


def waiting_ticks(trace: Trace) -> Counter[tuple[int, str]]:
    """Return the ticks in which robots under way did nothing, by robot and what they were under way for.

    `FOR_ROOM` has the part of ``to_pod`` beneath the pod: the robot was there, and the station had no room.

    Under way is a robot from a task, or from leaving a station, until it joins a queue or has stored its pod; what it
    did not do after the last that it is known to have done is not counted.
    """
    begin = measured_from(trace)
    since: dict[int, tuple[int, str]] = {}  # robot -> until when all of its time is accounted for; what for
    serving = {pod: start["robot"] for pod, start in enumerate(trace.pods)}
    found: Counter[tuple[int, str]] = Counter()
    for event in trace.events:
        match event:
            case TaskAssigned():
                since[event.robot] = (event.tick, "to_pod")
            case RobotMoved() | PodLifted() | PodStored():
                if event.robot in since:
                    free, state = since[event.robot]
                    still = event.start_tick + (event.wait_ticks if isinstance(event, RobotMoved) else 0)
                    found[event.robot, state] += max(0, still - max(free, begin))
                    if isinstance(event, PodLifted):
                        found[event.robot, FOR_ROOM] += max(0, still - max(free, begin))
                    since[event.robot] = (event.tick, "to_station" if isinstance(event, PodLifted) else state)
                if isinstance(event, PodStored):
                    since.pop(event.robot, None)
            case QueueJoined():
                since.pop(event.robot, None)
            case VisitStarted():
                serving[event.pod] = event.robot
            case VisitEnded():
                robot = serving[event.pod]
                if robot is not None:
                    since[robot] = (event.tick, "to_station" if event.next_station is not None else "storing")
    return found
