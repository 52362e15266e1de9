"""The metrics of a run, worked out anew from its trace, and compared with those reported."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.case import Case
from rmfs_commands.validation.costs import recompute_costs
from rmfs_commands.validation.departures import recompute_departures
from rmfs_commands.validation.details import recompute_details
from rmfs_commands.validation.packed import recompute_packing
from rmfs_commands.validation.restocking import recompute_replenishment
from rmfs_commands.validation.tables import arrivals_of, cancelled_in, goes_on, measured_from
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.events import DecisionMade, Event, ItemPicked, OrderAssigned, OrderCompleted, RobotMoved, VisitStarted

Value = float | None
OF_TIME_BEFORE = "turnover_stock_s", "replenishment_robot_percent"


def compare(case: Case, result: Mapping[str, Any]) -> None:
    """Add a fault for each metric of a result that the trace contradicts, and when it is that of another run."""
    trace = case.trace
    for name, found, expected in (
        ("scenario", result.get("scenario"), trace.scenario),
        ("seed", result.get("seed"), trace.scenario.get("seed")),
        ("status", result.get("status"), trace.status),
        *((f"version of {name}", result.get("versions", {}).get(name), told) for name, told in trace.versions.items()),
    ):
        if not _alike(found, expected):
            case.add("other-run", trace.tick, f"the {name} in the result is not the one in the trace")
    reported = result.get("metrics", {})
    for section in ("metrics", "timing"):
        for name in _booleans(result.get(section, {})):
            case.add("metric", trace.tick, f"{name} is reported as true or false; expected a number")
    details = recompute_details(trace)
    if trace.instance.restocked:
        details |= recompute_replenishment(trace)
    if trace.scenario.get("packing"):
        details |= recompute_packing(trace)
    if trace.scenario.get("instance", {}).get("departures"):
        details |= recompute_departures(trace)
    if trace.scenario.get("costs"):
        details |= recompute_costs(trace)
    expected_values = recompute(trace) | (details if details.keys() & reported.keys() else {})
    if trace.state is not None:  # which know more of the time before than a trace does
        expected_values = {name: value for name, value in expected_values.items() if name not in OF_TIME_BEFORE}
    for name, value in expected_values.items():
        if name not in reported:
            case.add("metric", trace.tick, f"{name} is not reported; the trace amounts to {value}")
        elif not _same(reported[name], value):
            case.add("metric", trace.tick, f"{name} is reported as {reported[name]}; the trace amounts to {value}")


def recompute(trace: Trace) -> dict[str, Value]:
    """Every metric of the kernel by name."""
    begin = measured_from(trace)
    counted = [event for event in trace.events if event.tick >= begin]
    picks = [event for event in trace.events if isinstance(event, ItemPicked)]
    picked = sum(isinstance(event, ItemPicked) for event in counted)
    picking = len(trace.stations) - trace.layout.replenishing
    visits = sum(isinstance(event, VisitStarted) and event.station < picking for event in counted)
    decisions = [event for event in counted if isinstance(event, DecisionMade)]
    done = {event.order: event.tick for event in trace.events if isinstance(event, OrderCompleted)}
    orders, arrivals = trace.instance.orders, arrivals_of(trace)
    all_done = len(done) + len(cancelled_in(trace)) == len(orders)
    end = max(done.values(), default=0) if all_done else trace.tick
    busy = sum(max(0, min(pick.picker_free_tick, end) - max(pick.start_tick, begin)) for pick in picks)
    after = {order: tick for order, tick in done.items() if tick >= begin}
    measured, own = max(end - begin, 0), goes_on(trace)
    hours = measured / TICKS_PER_S / 3600
    return {
        **_distances(trace, counted, len(after)),
        **_turnover(trace, {order: tick for order, tick in after.items() if own or arrivals.get(order, tick) >= begin}),
        "orders_completed": len(after),
        "orders_total": len(orders),
        "picks": picked,
        "pod_station_visits": visits,
        "psv_per_order": _over(visits, len(after)),
        "pile_on": _over(picked, visits),
        "makespan_s": end / TICKS_PER_S if all_done else None,
        "simulated_s": end / TICKS_PER_S,
        "orders_per_hour": _over(len(after), hours),
        "picks_per_hour": _over(picked, hours),
        "picker_utilisation": _over(busy, measured * picking),
        "split_orders_open_max": _split_orders(trace, begin),
        "periods": sum(decision.decides.assigns for decision in decisions),
        "solves_stopped_early": sum(decision.stopped_early for decision in decisions),
    }


def _distances(trace: Trace, counted: Sequence[Event], done: int) -> dict[str, Value]:
    loaded = empty = 0
    for event in counted:
        if isinstance(event, RobotMoved):
            metres = trace.layout.distance(event.origin, event.to)
            if event.pod is None:
                empty += metres
            else:
                loaded += metres
    return {
        "distance_m": loaded + empty,
        "distance_per_order_m": _over(loaded + empty, done),
        "loaded_distance_m": loaded,
        "empty_distance_m": empty,
    }


def _turnover(trace: Trace, done: Mapping[int, int]) -> dict[str, Value]:
    """Means over the completed orders: arrival, assignment of the last line, completion."""
    assigned = {event.order: event.tick for event in trace.events if isinstance(event, OrderAssigned)}
    arrival = arrivals_of(trace)
    waited = sum(assigned.get(order, tick) - arrival.get(order, tick) for order, tick in done.items())
    served = sum(tick - assigned.get(order, tick) for order, tick in done.items())
    whole = len(done) * TICKS_PER_S
    return {
        "turnover_s": _over(waited + served, whole),
        "turnover_backlog_s": _over(waited, whole),
        "turnover_station_s": _over(served, whole),
    }


def _split_orders(trace: Trace, begin: int) -> int:
    """Most orders at once that are known to be split and not complete, looked at at a time and after each decision."""
    parts: list[set[tuple[int, int]]] = [set() for _ in trace.instance.orders]
    left = [{sku for sku, _ in order.lines} for order in trace.instance.orders]
    under_way: set[int] = set()
    most = 0
    for event, before in zip(trace.events, (None, *trace.events), strict=False):
        if before is not None and before.tick < begin <= event.tick:
            most = _split(under_way, parts, left)
        if isinstance(event, OrderAssigned):
            parts[event.order].add((event.station, event.period))
            left[event.order].difference_update(event.skus)
            under_way.add(event.order)
        elif isinstance(event, OrderCompleted):
            under_way.discard(event.order)
        elif isinstance(event, DecisionMade):
            most = max(most, _split(under_way, parts, left))
    if trace.events and trace.events[-1].tick < begin:  # the run ends before anything counts
        most = 0
    return max(most, _split(under_way, parts, left))


def _split(under_way: set[int], parts: list[set[tuple[int, int]]], left: list[set[int]]) -> int:
    return sum(len(parts[order]) > 1 or bool(left[order]) for order in under_way)


def _over(part: float, whole: float) -> Value:
    return part / whole if whole else None


def _alike(found: object, expected: object) -> bool:
    """Whether two values are the same in JSON; Python takes true for 1."""
    return json.dumps(found, sort_keys=True) == json.dumps(expected, sort_keys=True)


def _booleans(figures: Mapping[str, Any]) -> Iterator[str]:
    """Yield the names of figures that are true or false."""
    for name, value in figures.items():
        if isinstance(value, bool):
            yield name
        elif isinstance(value, Mapping):
            yield from _booleans(value)


def _same(reported: object, value: Value) -> bool:
    if value is None or not isinstance(reported, int | float) or isinstance(reported, bool):
        return value is None and reported is None
    return math.isclose(reported, value, rel_tol=1e-9, abs_tol=1e-9)
