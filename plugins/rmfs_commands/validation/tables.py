"""hours.csv, stations.csv and robots.csv, worked out anew from a trace."""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import accumulate, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rmfs_commands.instances.calendar import Calendar
from rmfs_commands.processes.events import (
    ChargerDown,
    ChargerUp,
    OrderPacked,
    PackingAssigned,
    RobotDown,
    RobotUp,
    StationDown,
    StationUp,
)
from rmfs_commands.trace.reader import Trace, packing_stations
from rmfs_commands.validation.stock import joined_at
from rmfs_core.clock import TICKS_PER_S, to_ticks
from rmfs_core.events import (
    Event,
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCancelled,
    OrderCompleted,
    PodLifted,
    PodMoveDecided,
    PodStored,
    QueueJoined,
    RobotMoved,
    RobotRested,
    RobotSent,
    RobotsOnDuty,
    StationClosed,
    StationOpened,
    TaskAssigned,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.timetable import ALWAYS, Timetable, read_spans

Row = dict[str, float | str | None]
STATES = ("idle", "to_pod", "to_station", "queue", "station", "storing")
OFF = "off"
FOR_ROOM = "for room"
HOUR = 3600 * TICKS_PER_S


def measured_from(trace: Trace) -> int:
    """Return the tick from which on is measured."""
    return to_ticks(trace.scenario.get("run", {}).get("warmup_s") or 0)


def goes_on(trace: Trace) -> bool:
    """Whether orders count that were open in the state in which a run begins: what counts begins there."""
    return trace.state is not None and measured_from(trace) <= trace.began + 1


def lines_of(trace: Trace) -> list[list[int]]:
    """Return the robots in line at each station when a run begins."""
    if trace.state is not None:
        return [list(line) for line in trace.state["lines"]]
    lines: list[list[int]] = [[] for _ in trace.stations]
    for pod in trace.pods:
        if pod["robot"] is not None:
            lines[pod["bound_for"][0]].append(pod["robot"])
    return lines


def refilled(trace: Trace) -> int | None:
    """Return how many orders are kept in the backlog, as long as there are any; None where they come at their times."""
    backlog = trace.scenario.get("instance", {}).get("arrivals", {}).get("backlog")
    return None if backlog is None else int(backlog)


def arrivals_of(trace: Trace) -> dict[int, int]:
    """Return when each order arrives, without orders that are kept for later when the run ends."""
    if refilled(trace) is None:
        return {i: order.arrival_tick for i, order in enumerate(trace.instance.orders)}
    return {event.order: event.tick for event in trace.events if isinstance(event, OrderArrived)}


def cancelled_in(trace: Trace) -> dict[int, int]:
    """Return when orders were cancelled."""
    return {event.order: event.tick for event in trace.events if isinstance(event, OrderCancelled)}


def due_in(trace: Trace, done: Mapping[int, int]) -> dict[int, int]:
    """Return when the orders with a due time are due that count; ``done``: when they were complete, or packed.

    They arrive in the time measured, or were not done in the state in which the run begins.
    """
    begin, arrivals, cancelled = measured_from(trace), arrivals_of(trace), cancelled_in(trace)
    due = {i: order.due_tick for i, order in enumerate(trace.instance.orders) if order.due_tick is not None}
    there = {i for i in due if goes_on(trace) and done.get(i, begin) >= begin}
    return {i: t for i, t in due.items() if (i in there or arrivals.get(i, -1) >= begin) and i not in cancelled}


def may_cancel(trace: Trace) -> bool:
    """Whether any order of a trace may be cancelled."""
    return any(order.cancelled_tick is not None for order in trace.instance.orders)


def has_hours(trace: Trace) -> bool:
    """Whether stations open and close in a run."""
    scenario = trace.scenario
    return bool(scenario.get("stations", {}).get("open") or scenario.get("rules", {}).get("activate"))


def hours_of(trace: Trace) -> Iterator[Row]:
    """Yield the rows of hours.csv, which a trace of few events may have any number of."""
    counted: Counter[tuple[int, str]] = Counter()
    last, began = max(trace.tick - 1, 0) // HOUR, trace.began
    since = 0 if trace.state is None else min(measured_from(trace), began + 1)
    for event in trace.events:
        number, hour = 1, max(event.tick, began) // HOUR
        match event:
            case OrderArrived():
                what = "orders_in"
            case OrderAssigned():
                what, number = "left", int(event.complete)
            case OrderCompleted():
                what = "orders_out"
            case OrderCancelled():
                what = "orders_cancelled"
            case ItemPicked():
                what = "picks"
            case VisitStarted():
                if event.station >= len(trace.stations) - trace.layout.replenishing:
                    continue
                what = "visits"
            case RobotMoved():
                what, number = "distance_m", int(trace.layout.distance(event.origin, event.to))
            case OrderPacked():
                what = "orders_packed"
            case _:
                continue
        counted[hour, what] += number * (event.tick >= since)
        counted[hour, "backlog"] += number * {"orders_in": 1, "left": -1, "orders_cancelled": -1}.get(what, 0)
        last = max(last, hour)
    backlog, there = 0, _there(trace)
    for hour in range(began // HOUR, last + 1):
        backlog += counted[hour, "backlog"]
        counts = ["orders_in", "orders_out", "picks", "visits", "distance_m"]
        counts += ["orders_cancelled"] * may_cancel(trace)
        counts += ["orders_packed"] * bool(trace.scenario.get("packing"))
        numbers = {what: counted[hour, what] for what in counts}
        begin = max(hour * HOUR, began)
        end = max(min((hour + 1) * HOUR, trace.tick), begin)
        means = {column: round(_mean(steps, begin, end), 3) for column, steps in there.items()}
        yield {"hour": hour, "start_s": hour * 3600, **numbers, "backlog": backlog, **means}


def _there(trace: Trace) -> dict[str, list[tuple[int, int]]]:
    """Return how many stations are open, and robots on duty, from when on; empty where they never come or go."""
    opened, on_duty = [(0, len(trace.stations) - trace.layout.replenishing)], [(0, len(trace.robots))]
    robots_down, stations_down, chargers_down = [(0, 0)], [(0, 0)], [(0, 0)]
    for event in trace.events:
        match event:
            case StationOpened() | StationClosed():
                opened.append((event.tick, opened[-1][1] + (1 if isinstance(event, StationOpened) else -1)))
            case RobotsOnDuty():
                on_duty.append((event.tick, event.number))
            case RobotDown() | RobotUp():
                robots_down.append((event.tick, robots_down[-1][1] + (1 if isinstance(event, RobotDown) else -1)))
            case StationDown() | StationUp():
                stations_down.append((event.tick, stations_down[-1][1] + (1 if isinstance(event, StationDown) else -1)))
            case ChargerDown() | ChargerUp():
                chargers_down.append((event.tick, chargers_down[-1][1] + (1 if isinstance(event, ChargerDown) else -1)))
    found = {"stations_open": opened} if has_hours(trace) else {}
    if trace.scenario.get("packing"):
        found["boxes"] = boxes_of(trace)
        if trace.scenario["packing"].get("open"):
            found["packers_on_duty"] = _packers(trace)
    if robots_may_fail(trace):
        found["robots_down"] = robots_down
    if trace.scenario.get("stations", {}).get("outages"):
        found["stations_down"] = stations_down
    if (trace.scenario.get("robots", {}).get("battery") or {}).get("charger_outages"):
        found["chargers_down"] = chargers_down
    return found | ({"robots_on_duty": on_duty} if trace.scenario.get("robots", {}).get("available") else {})


def recompute_outages(trace: Trace) -> dict[str, float | None]:
    """Return the metrics of what was out of service."""
    begin, wanted = measured_from(trace), Counter[tuple[int, int]]()
    failures, held, end = Counter[str](), 0, max(trace.tick, measured_from(trace))
    for event in trace.events:
        match event:
            case OrderAssigned():
                wanted[event.station, event.order] += event.items
            case ItemPicked():
                wanted[event.station, event.order] -= 1
            case RobotDown() if event.tick >= begin and not event.planned:
                failures["robots"] += 1
            case StationDown() if event.tick >= begin:
                failures["stations"] += 1
                held += sum(station == event.station and items > 0 for (station, _), items in wanted.items())
            case ChargerDown() if event.tick >= begin:
                failures["chargers"] += 1
    there, found = _there(trace), dict[str, float | None]()
    numbers = {"robots": len(trace.robots), "stations": len(trace.stations) - trace.layout.replenishing}
    numbers["chargers"] = len(trace.layout.chargers)
    for kind, number in numbers.items():
        if (steps := there.get(f"{kind}_down")) is not None:
            share = 100 * _mean(steps, begin, end) / number if end > begin else None
            found |= {f"{kind[:-1]}_failures": failures[kind], f"{kind}_down_percent": share}
    return found | ({"orders_held": held} if "stations_down" in there else {})


def _mean(steps: list[tuple[int, int]], begin: int, end: int) -> float:
    """Return the mean of a number between two times; steps say from when on it is which."""
    spans = pairwise([*steps, (max(end, steps[-1][0]), 0)])
    return sum(number * max(min(b, end) - max(a, begin), 0) for (a, number), (b, _) in spans) / max(end - begin, 1)


def packing_hours(trace: Trace) -> list[Timetable]:
    """Return when the packers of each packing station begin tasks."""
    given: Any = (trace.scenario.get("packing") or {}).get("open")
    zero = Calendar(trace.scenario.get("instance", {}).get("start")).time_of_day()
    spans = [given.get(str(i + 1)) if isinstance(given, Mapping) else given for i in range(packing_stations(trace))]
    return [ALWAYS if one is None else Timetable(read_spans(one), zero) for one in spans]


def changes_of(hours: Timetable, end: int) -> list[int]:
    """Return the ticks before the end at which packers come or go."""
    ticks, tick = list[int](), hours.next_change(0)
    while tick is not None and tick < end:
        ticks.append(tick)
        tick = hours.next_change(tick)
    return ticks


def _packers(trace: Trace) -> list[tuple[int, int]]:
    """Return how many packers are on duty, from when on."""
    hours, each = packing_hours(trace), int(trace.scenario["packing"]["packers"])
    ticks = sorted({0, *(tick for one in hours for tick in changes_of(one, trace.tick))})
    return [(tick, each * sum(bool(one.at(tick)) for one in hours)) for tick in ticks]


def boxes_of(trace: Trace) -> list[tuple[int, int]]:
    """Return how many boxes split orders have, from when on."""
    until = OrderPacked if trace.scenario["packing"]["packing_from"] == "packed" else OrderCompleted
    steps, taken = [(0, 0)], set[int]()
    for event in trace.events:
        if isinstance(event, PackingAssigned) and event.box is not None:
            taken.add(event.order)
        elif isinstance(event, until):
            taken.discard(event.order)
        else:
            continue
        steps.append((event.tick, len(taken)))
    return steps


def stations_of(trace: Trace) -> list[Row]:
    """Return the rows of stations.csv."""
    begin = measured_from(trace)
    end = max(trace.tick, begin)
    steps: dict[int, dict[str, list[tuple[int, int]]]] = defaultdict(lambda: defaultdict(list))
    totals: Counter[tuple[int, str]] = Counter()
    joined = joined_at(trace)
    backlog = [(tick, 1) for tick in joined.values()]
    backlog += [(tick, -1) for order, tick in cancelled_in(trace).items() if order in joined]
    for at, robots in enumerate(lines_of(trace)):
        steps[at]["queue"].append((0, len(robots)))
    for event in trace.events:
        match event:
            case OrderAssigned():
                steps[event.station]["wanted"].append((event.tick, event.items))
                backlog.append((event.tick, -int(event.complete)))
            case StationOpened() | StationClosed():
                steps[event.station]["open"].append((event.tick, 1 if isinstance(event, StationOpened) else -1))
            case StationDown() | StationUp():
                steps[event.station]["down"].append((event.tick, 1 if isinstance(event, StationDown) else -1))
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
    for i, station in enumerate(trace.stations[: len(trace.stations) - trace.layout.replenishing]):
        changes = steps[i]
        every = [tick for kind in (*changes.values(), backlog) for tick, _ in kind]
        times = np.unique(np.clip([begin, end, *every], begin, end))
        lasts = np.diff(times)
        busy, wanted, queue = (_levels(times, changes[what]) for what in ("busy", "wanted", "queue"))
        fails = (_levels(times, changes["down"]) > 0) & (busy == 0)
        works, lacks = busy > 0, (wanted > 0) & (busy == 0) & ~fails
        takes = _levels(times, changes["open"]) == 0  # it is open at first: one less for each time that it closes
        rests = takes & ~(works | lacks)
        spans = {
            "busy_s": works,
            "waiting_s": lacks,
            "idle_s": rests,
            "starved_s": rests & (_levels(times, backlog) > 0),
            **({"open_s": works | lacks | takes} if has_hours(trace) else {}),
            **({"down_s": fails} if trace.scenario["stations"].get("outages") else {}),
        }
        rows.append(
            {
                "station": station["name"],
                "picks": totals[i, "picks"],
                "visits": totals[i, "visits"],
                **{column: int(lasts[span].sum()) / TICKS_PER_S for column, span in spans.items()},
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


def has_batteries(trace: Trace) -> bool:
    """Whether the robots of a trace have batteries."""
    return "battery" in trace.scenario.get("robots", {})


def robots_may_fail(trace: Trace) -> bool:
    """Whether robots of a trace may be out of service."""
    robots = trace.scenario.get("robots", {})
    return bool(robots.get("failures") or robots.get("maintenance"))


def are_sent(trace: Trace) -> bool:
    """Whether robots of a trace may be sent to where they rest, or are repaired."""
    return "idle" in trace.scenario.get("rules", {}) or (robots_may_fail(trace) and bool(trace.layout.maintenance))


def states_of(trace: Trace) -> tuple[str, ...]:
    """Return what robots of a trace may do: what its scenario has no rules for is left out."""
    rules = trace.scenario.get("rules", {})
    more = {"to_rest": are_sent(trace), "charging": has_batteries(trace), "moving_pods": "move" in rules}
    more["down"] = robots_may_fail(trace)
    return (*STATES, *(state for state, there in more.items() if there))


def robots_of(trace: Trace) -> list[Row]:
    """Return the rows of robots.csv."""
    begin, has_off = measured_from(trace), bool(trace.scenario.get("robots", {}).get("available"))
    states = states_of(trace)
    metres: Counter[tuple[int, bool]] = Counter()
    for event in trace.events:
        if isinstance(event, RobotMoved) and event.tick >= begin:
            metres[event.robot, event.pod is not None] += int(trace.layout.distance(event.origin, event.to))
    still = waiting_ticks(trace)
    end = max(trace.tick, begin)
    rows: list[Row] = []
    for robot, turned in enumerate(_turns(trace)):
        ticks = Counter({state: -still[robot, state] for state in (*states, OFF)})
        for (since, state), (until, _) in pairwise([*turned, (end, "")]):
            ticks[state] += max(until, begin) - max(since, begin)
        rows.append(
            {
                "robot": str(robot + 1),
                "distance_m": metres[robot, False] + metres[robot, True],
                "loaded_distance_m": metres[robot, True],
                **{_column(trace, state): ticks[state] / TICKS_PER_S for state in states},
                "waiting_s": sum(still[robot, state] for state in STATES) / TICKS_PER_S,
                **({"off_s": ticks[OFF] / TICKS_PER_S} if has_off else {}),
            }
        )
    return rows


def _column(trace: Trace, state: str) -> str:
    """Return the column of a state: no event tells when a robot that stands is low."""
    return "idle_s + low_s" if state == "idle" and has_batteries(trace) else f"{state}_s"


def none_free(trace: Trace) -> Callable[[int], int]:
    """Return what says for how many ticks, from 0 to a tick, no robot is on duty without a task."""
    changes: Counter[int] = Counter({0: 0})
    for turned in _turns(trace):
        was_free = False
        for tick, state in turned:
            changes[tick] += (state == "idle") - was_free
            was_free = state == "idle"
    ticks = sorted(changes)
    none = [number == 0 for number in accumulate(changes[tick] for tick in ticks)]
    before = [0, *accumulate((b - a) * here for (a, b), here in zip(pairwise(ticks), none, strict=False))]

    def until(tick: int) -> int:
        last = bisect_right(ticks, tick) - 1
        return before[last] + none[last] * (tick - ticks[last])

    return until


def _turns(trace: Trace) -> list[list[tuple[int, str]]]:
    """Return what each robot turns to, and when."""
    carrying = {pod["robot"] for pod in trace.pods}
    turns = [[(0, "queue" if robot in carrying else "idle")] for robot in range(len(trace.robots))]
    serving = {pod: start["robot"] for pod, start in enumerate(trace.pods)}
    chargers = {*trace.layout.chargers} if has_batteries(trace) else set()
    simple: dict[type[Event], str] = {
        TaskAssigned: "to_pod",
        PodMoveDecided: "moving_pods",
        RobotSent: "to_rest",
        RobotDown: "down",
        QueueJoined: "queue",
        VisitStarted: "station",
    }
    on_duty, cells = len(trace.robots), [robot["cell"] for robot in trace.robots]
    for event in trace.events:
        robot, state = getattr(event, "robot", None), simple.get(type(event))
        stand: list[int] = []  # robots without a task
        match event:
            case RobotRested() | PodStored() | RobotUp():
                stand = [event.robot]
            case RobotsOnDuty():
                on_duty = event.number
                stand = [i for i, turned in enumerate(turns) if turned[-1][1] in ("idle", OFF)]
            case PodLifted() if turns[event.robot][-1][1] != "moving_pods":
                state = "to_station"
            case VisitStarted():
                serving[event.pod] = event.robot
            case VisitEnded():
                robot = serving[event.pod]  # None: nobody has told that the visit began
                state = "to_station" if event.next_station is not None else "storing"
            case RobotMoved():
                cells[event.robot] = event.to
            case ChargerDown() | ChargerUp():
                (chargers.discard if isinstance(event, ChargerDown) else chargers.add)(event.cell)
                there = (i for i, cell in enumerate(cells) if cell == event.cell)
                stand = [i for i in there if turns[i][-1][1] in ("charging", "idle", OFF)]
        if robot is not None and state is not None:
            turns[robot].append((event.tick, state))
        for i in stand:
            turns[i].append((event.tick, "charging" if cells[i] in chargers else "idle" if i < on_duty else OFF))
    return turns


def waiting_ticks(trace: Trace) -> Counter[tuple[int, str]]:
    """Return the ticks in which robots under way did nothing, by robot and what they were under way for.

    `FOR_ROOM` has the part of ``to_pod`` under the pod: the robot was there, and the queue was full.

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
            case PodLifted() if trace.state is not None and event.tick <= trace.began:
                since[event.robot] = (event.tick, "to_station")
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
            case QueueJoined() | RobotSent() | PodMoveDecided():  # the last two, on a floor that took a task back
                since.pop(event.robot, None)
            case VisitStarted():
                serving[event.pod] = event.robot
            case VisitEnded():
                robot = serving[event.pod]
                if robot is not None:
                    since[robot] = (event.tick, "to_station" if event.next_station is not None else "storing")
    return found
