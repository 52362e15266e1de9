"""Checks a solution by the printed constraints and names the first that it violates by the paper's number.

The variables that follow from the lines' assignment (y_os, y_o, u_s, e_o, y_o^l) are derived here, so that a solution
cannot claim another value for them; what is left to violate is named by the equation that a wrong solution breaks.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.placing import short_of
from rmfs_rules.mip.period.solution import Model, Solution, newly_split, objective_of

Wanted = Mapping[int, Mapping[int, int]]
"""By order (position), the number of items of each of its open lines, by SKU."""


def violation(
    period: Period, solution: Solution, model: Model, weight: float, packing_capacity: int | None = None
) -> str | None:
    """Return what a solution violates, or None.

    Parameters
    ----------
    period
        The period that was solved.
    solution
        Its solution.
    model
        Whose constraints.
    weight
        W_u.
    packing_capacity
        C of constraint (18), None where there is no limit.
    """
    return next(_violations(period, solution, model, weight, packing_capacity), None)


def _violations(
    period: Period, solution: Solution, model: Model, weight: float, packing_capacity: int | None
) -> Iterator[str]:
    wanted = {part.order: dict(period.lines_of(part.order)) for part in solution.parts}
    yield from _lines(period, solution, wanted)
    yield from _pods(period, solution)
    yield from _stock(period, solution)
    yield from _capacity(period, solution, wanted)
    yield from _orders(period, solution, model, wanted)
    if packing_capacity is not None and model is not Model.INTEGRATED:
        yield from _packing(period, solution, packing_capacity)
    value = objective_of(period, solution.parts, len(solution.visits), weight)
    if abs(value - solution.objective) > 1e-6:
        yield f"(1) objective: it is {value:g}, but {solution.objective:g} was reported"
    if solution.bound > value + 1e-6:
        yield f"(1) objective: it is {value:g}, below the bound {solution.bound:g}"


def _lines(period: Period, solution: Solution, wanted: Wanted) -> Iterator[str]:
    """Domain (8) of y_ios, and (13)."""
    seen = set()
    for part in solution.parts:
        if not part.skus:
            yield f"(13) order at a station without a line: {_order(period, part.order)}"
        for sku in part.skus:
            if sku not in wanted[part.order]:
                yield f"(8) lines: SKU id {sku} is no open line of {_order(period, part.order)}"
            if (part.order, part.station, sku) in seen:
                yield (
                    f"(8) lines: SKU id {sku} of {_order(period, part.order)} is twice at {_at(period, part.station)}"
                )
            seen.add((part.order, part.station, sku))


def _pods(period: Period, solution: Solution) -> Iterator[str]:
    """(5), (6) and the domain (9) of x_ps."""
    visits = set(solution.visits)
    if len(visits) < len(solution.visits):
        yield "(9) pods: a pod is sent to the same station twice"
    there: list[set[int]] = [set() for _ in period.stations]
    for pod, station in visits:
        there[station].update(period.stock.skus_of(pod).tolist())
    for part in solution.parts:
        for sku in part.skus:
            if sku not in there[part.station]:
                yield (
                    f"(5) pods: no pod with SKU id {sku} of {_order(period, part.order)} is at "
                    f"{_at(period, part.station)} or sent to it"
                )
    for station, pods in enumerate(period.inbound):
        for pod in pods:
            if (pod, station) not in visits:
                yield (
                    f"(6) pods: pod id {period.stock.pods[pod]} is at {_at(period, station)} and has to stay "
                    "assigned to it"
                )


def _stock(period: Period, solution: Solution) -> Iterator[str]:
    """The rows of finite stock: that there are some q_ips >= 0."""
    sku = short_of(period, solution.visits, solution.parts)
    if sku is not None:
        yield f"stock: the pods at the stations and sent to them have too few free items of SKU id {sku}"


def _capacity(period: Period, solution: Solution, wanted: Wanted) -> Iterator[str]:
    """(4) with u_s >= 0."""
    taken = [0] * len(period.stations)
    for part in solution.parts:
        items = sum(wanted[part.order].get(sku, 0) for sku in part.skus)
        taken[part.station] += period.slots(part.order, part.station, items)
    for station, (slots, room) in enumerate(zip(taken, period.capacities, strict=True)):
        if slots > room:
            unit = "order" if station in period.counting_orders else "item"
            yield f"(4) {unit} capacity: {slots} {unit}s for {_at(period, station)}, which has {room} slots free"


def _orders(period: Period, solution: Solution, model: Model, wanted: Wanted) -> Iterator[str]:
    """(2) and (3), or (11), or (11.1)."""
    stations: dict[int, set[int]] = {}
    times: dict[int, Counter[int]] = {}
    for part in solution.parts:
        stations.setdefault(part.order, set()).add(part.station)
        times.setdefault(part.order, Counter()).update(part.skus)
    for order, counts in times.items():
        if model is Model.INTEGRATED and len(stations[order]) > 1:
            yield f"(3) one station: {_order(period, order)} is at {len(stations[order])} stations"
        equation = {Model.INTEGRATED: "(2)", Model.SPLIT_AMONG_STATIONS: "(11)", Model.SPLIT_OVER_TIME: "(11.1)"}[model]
        for sku in wanted[order]:
            if counts[sku] > 1:
                yield f"{equation} lines: SKU id {sku} of {_order(period, order)} is assigned {counts[sku]} times"
            if counts[sku] < 1 and model is not Model.SPLIT_OVER_TIME:
                yield f"{equation} whole orders: SKU id {sku} of {_order(period, order)} is left out"


def _packing(period: Period, solution: Solution, packing_capacity: int) -> Iterator[str]:
    """(18), summed over the orders; an order that is split already is not counted again."""
    fresh = len(newly_split(period, solution.parts))
    if period.split_open + fresh > packing_capacity and fresh:
        yield (
            f"(18) packing capacity: {period.split_open} split orders are open and {fresh} come in; "
            f"the packing stations hold {packing_capacity}"
        )


def _order(period: Period, order: int) -> str:
    return f"order id {period.orders[order]}"


def _at(period: Period, station: int) -> str:
    return f"station id {period.stations[station]}"
