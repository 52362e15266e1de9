"""The metrics of a run, worked out anew from its trace, and compared with those reported."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.events import DecisionMade, ItemPicked, OrderAssigned, OrderCompleted, RobotMoved, VisitStarted
from rmfs_trace.reader import Trace
from rmfs_validation.case import Case

Value = float | None


def compare(case: Case, result: Mapping[str, Any]) -> None:
    """Add a fault for each metric of a result that the trace contradicts, and when it is that of another run."""
    trace = case.trace
    for name, found, expected in (
        ("scenario", result.get("scenario"), trace.scenario),
        ("status", result.get("status"), trace.status),
    ):
        if found != expected:
            case.add("other-run", trace.tick, f"the {name} in the result is not the one in the trace")
    reported = result.get("metrics", {})
    for name, value in recompute(trace).items():
        if name not in reported:
            case.add("metric", trace.tick, f"{name} is not reported; the trace amounts to {value}")
        elif not _same(reported[name], value):
            case.add("metric", trace.tick, f"{name} is reported as {reported[name]}; the trace amounts to {value}")


def recompute(trace: Trace) -> dict[str, Value]:
    """Every metric by name."""
    picks = [event for event in trace.events if isinstance(event, ItemPicked)]
    visits = sum(isinstance(event, VisitStarted) for event in trace.events)
    decisions = [event for event in trace.events if isinstance(event, DecisionMade)]
    done = {event.order: event.tick for event in trace.events if isinstance(event, OrderCompleted)}
    orders = trace.instance.orders
    end = trace.tick if len(done) < len(orders) else max(done.values(), default=0)
    busy = sum(max(0, min(pick.picker_free_tick, end) - pick.start_tick) for pick in picks)
    hours = end / TICKS_PER_S / 3600
    return {
        **_distances(trace, len(done)),
        **_turnover(trace, done),
        "orders_completed": len(done),
        "orders_total": len(orders),
        "picks": len(picks),
        "pod_station_visits": visits,
        "psv_per_order": _over(visits, len(done)),
        "pile_on": _over(len(picks), visits),
        "makespan_s": end / TICKS_PER_S if len(done) == len(orders) else None,
        "simulated_s": end / TICKS_PER_S,
        "orders_per_hour": _over(len(done), hours),
        "picks_per_hour": _over(len(picks), hours),
        "picker_utilisation": _over(busy, end * len(trace.stations)),
        "split_orders_open_max": _split_orders(trace),
        "periods": sum(decision.decides.assigns for decision in decisions),
        "solves_stopped_early": sum(decision.stopped_early for decision in decisions),
    }


def _distances(trace: Trace, done: int) -> dict[str, Value]:
    loaded = empty = 0
    for event in trace.events:
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
    arrival = [order.arrival_tick for order in trace.instance.orders]
    waited = sum(assigned.get(order, tick) - arrival[order] for order, tick in done.items())
    served = sum(tick - assigned.get(order, tick) for order, tick in done.items())
    whole = len(done) * TICKS_PER_S
    return {
        "turnover_s": _over(waited + served, whole),
        "turnover_backlog_s": _over(waited, whole),
        "turnover_station_s": _over(served, whole),
    }


def _split_orders(trace: Trace) -> int:
    """Most orders at once that are known to be split and not complete, looked at after each decision."""
    parts: list[set[tuple[int, int]]] = [set() for _ in trace.instance.orders]
    left = [{sku for sku, _ in order.lines} for order in trace.instance.orders]
    under_way: set[int] = set()
    most = 0
    for event in trace.events:
        if isinstance(event, OrderAssigned):
            parts[event.order].add((event.station, event.period))
            left[event.order].difference_update(event.skus)
            under_way.add(event.order)
        elif isinstance(event, OrderCompleted):
            under_way.discard(event.order)
        elif isinstance(event, DecisionMade):
            most = max(most, _split(under_way, parts, left))
    return max(most, _split(under_way, parts, left))


def _split(under_way: set[int], parts: list[set[tuple[int, int]]], left: list[set[int]]) -> int:
    return sum(len(parts[order]) > 1 or bool(left[order]) for order in under_way)


def _over(part: float, whole: float) -> Value:
    return part / whole if whole else None


def _same(reported: object, value: Value) -> bool:
    if value is None or not isinstance(reported, int | float) or isinstance(reported, bool):
        return value is None and reported is None
    return math.isclose(reported, value, rel_tol=1e-9, abs_tol=1e-9)
