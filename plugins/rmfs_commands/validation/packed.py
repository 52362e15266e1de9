"""packing.csv and the metrics of packing, worked out anew from a trace."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from attrs import Factory, define

from rmfs_commands.processes.events import OrderPacked, PackingAssigned, PackingStarted, PartArrived, PartPut, PartSent
from rmfs_commands.trace.reader import Trace, packing_stations
from rmfs_commands.validation.tables import (
    Row,
    arrivals_of,
    boxes_of,
    cancelled_in,
    changes_of,
    goes_on,
    measured_from,
    packing_hours,
)
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.events import DecisionMade, OrderArrived, OrderCancelled, OrderCompleted


@define
class _Times:
    """When what happened to an order, in ticks."""

    station: int
    box: int | None
    come: list[int] = Factory(list)
    ready: int = 0
    begun: int | None = None
    packed: int | None = None


def _times(trace: Trace) -> dict[int, _Times]:
    found: dict[int, _Times] = {}

    def of_order(event: PartPut | PartArrived | PackingStarted | OrderPacked) -> _Times:
        return found.setdefault(event.order, _Times(event.packing, None))  # `PackingCheck` tells of one bound nowhere

    for event in trace.events:
        match event:
            case PackingAssigned():
                found[event.order] = _Times(event.packing, event.box)
            case PartPut():
                of_order(event).ready = event.tick
            case PartArrived():
                of_order(event).come.append(event.tick)
                of_order(event).ready = event.tick
            case PackingStarted():
                of_order(event).begun = event.tick
            case OrderPacked():
                of_order(event).packed = event.tick
    return found


def packing_of(trace: Trace) -> Iterator[Row]:
    """Yield the rows of packing.csv."""
    for i, times in _times(trace).items():
        box = None if times.box is None else times.box + 1
        named: Row = {"order": trace.instance.orders[i].name, "packing_station": times.station + 1, "box": box}
        first, last = (times.come[0], times.come[-1]) if times.come else (None, None)
        at = {"first_part_s": first, "last_part_s": last, "packing_s": times.begun, "packed_s": times.packed}
        told = {column: None if tick is None else tick / TICKS_PER_S for column, tick in at.items()}
        yield {**named, "parts": len(times.come), **told}


def recompute_packing(trace: Trace) -> dict[str, float | None]:
    """Every metric of packing by name."""
    begin, section, times = measured_from(trace), trace.scenario["packing"], _times(trace)
    cancelled = cancelled_in(trace)
    end, arrivals, orders = max(trace.tick, begin), arrivals_of(trace), trace.instance.orders
    come = {event.order: event.tick for event in trace.events if isinstance(event, OrderArrived)}
    done = {i: one.packed for i, one in times.items() if one.packed is not None}
    after = [i for i, tick in done.items() if tick >= begin]
    there = {i for i in come if goes_on(trace) and done.get(i, begin) >= begin}  # not packed when the run began
    own = there | {i for i, tick in arrivals.items() if tick >= begin}
    counted = [i for i in after if i in own]
    timed = [done[i] - arrivals[i] for i in counted]
    together = [times[i].come[-1] - times[i].come[0] for i in counted if times[i].box is not None]
    waits = [(times[i].begun or 0) - times[i].ready for i in counted]
    steps = [*boxes_of(trace), (end, 0)]
    spans = [(max(a, begin), min(b, end), n) for (a, n), (b, _) in pairwise(steps)]
    spans = [(a, b, n) for a, b, n in spans if a < b]
    totes = sum(isinstance(event, PartSent) and event.tick >= begin for event in trace.events)
    left = [trace.tick - tick for i, tick in come.items() if i not in done.keys() | cancelled.keys()]
    due = {i: order.due_tick for i, order in enumerate(orders) if order.due_tick is not None}
    known = {i: tick for i, tick in due.items() if i in own - cancelled.keys() and (i in done or tick < end)}
    late = sum(done.get(i, end) > tick for i, tick in known.items())
    return {
        "orders_packed": len(after),
        "packed_s": _mean(timed),
        "packed_median_s": _percentile(timed, 50),
        "packed_p95_s": _percentile(timed, 95),
        "packed_makespan_s": max(done.values(), default=0) / TICKS_PER_S
        if len(done) + len(cancelled) == len(orders)
        else None,
        "consolidation_s": _mean(together),
        "consolidation_p95_s": _percentile(together, 95),
        "packing_wait_s": _mean(waits),
        "unpacked_end": len(left),
        "unpacked_age_sum_h": sum(left) / TICKS_PER_S / 3600,
        "boxes_max": max((n for _, _, n in spans), default=0),
        "boxes_mean": sum((b - a) * n for a, b, n in spans) / max(end - begin, 1),
        **_packers(trace, begin, end),
        "splits_refused": _refused(trace, begin, section["boxes"] * packing_stations(trace)),
        "totes": totes,
        "parts_per_order": sum(len(times[i].come) for i in after) / len(after) if after else None,
        **({"late_packed": late, "late_packed_percent": 100 * late / len(known) if known else None} if due else {}),
    }


def _packers(trace: Trace, begin: int, end: int) -> dict[str, float | None]:
    """Return what share of the packers' time they were at work, and without a task though orders were not packed."""
    there, busy, starved = packers_ticks(trace, begin, end)
    shares = {"packer_utilisation_percent": busy, "packer_starved_percent": starved}
    return {name: 100 * ticks / there if there else None for name, ticks in shares.items()}


def packers_ticks(trace: Trace, begin: int, end: int) -> tuple[int, int, int]:
    """Return the packers' time, and how much of it they worked, and had no task though orders were not packed."""
    section, orders = trace.scenario["packing"], Counter[int]()
    work: dict[int, Counter[int]] = defaultdict(Counter)  # by packing station: changes of how many are at work, by tick
    for event in trace.events:
        match event:
            case OrderArrived():
                orders[event.tick] += 1
            case OrderCancelled():
                orders[event.tick] -= 1
            case PackingStarted():
                work[event.packing][event.tick] += 1
            case OrderPacked():
                work[event.packing][event.tick] -= 1
                orders[event.tick] -= 1
            case PartPut() if not section["sorters"]:
                work[event.packing][event.start_tick] += 1
                work[event.packing][event.tick] -= 1
    there = busy = starved = 0
    for at, hours in enumerate(packing_hours(trace)):
        working = unpacked = 0
        for tick, until in pairwise(sorted({begin, end, *orders, *work[at], *changes_of(hours, end)})):
            working += work[at][tick]
            unpacked += orders[tick]
            if begin <= tick < end:
                on_duty = section["packers"] if hours.at(tick) else 0
                busy += (until - tick) * working
                there += (until - tick) * (on_duty or working)
                starved += (until - tick) * (on_duty * (unpacked > 0) - working * (on_duty > 0))
    return there, busy, starved


def _refused(trace: Trace, begin: int, boxes: int) -> int:
    """Count the periods that begin with every box taken."""
    until = OrderPacked if trace.scenario["packing"]["packing_from"] == "packed" else OrderCompleted
    found, taken = 0, set[int]()
    for event in trace.events:
        if isinstance(event, PackingAssigned) and event.box is not None:
            taken.add(event.order)
        elif isinstance(event, until):
            taken.discard(event.order)
        elif isinstance(event, DecisionMade) and event.decides.assigns and event.tick >= begin:
            found += len(taken) >= boxes
    return found


def _mean(ticks: list[int]) -> float | None:
    return sum(ticks) / len(ticks) / TICKS_PER_S if ticks else None


def _percentile(ticks: list[int], percent: float) -> float | None:
    return float(np.percentile(ticks, percent)) / TICKS_PER_S if ticks else None
