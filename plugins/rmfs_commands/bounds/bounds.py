"""The bounds of a scenario, by metric."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np
from attrs import evolve, frozen
from numpy.typing import NDArray

from rmfs_commands.bounds.cover import cheapest_cover
from rmfs_commands.bounds.ways import Ways, find_ways
from rmfs_commands.details.slots import at_work
from rmfs_commands.processes.packing import task_ticks
from rmfs_core.clock import TICKS_PER_S, to_seconds, to_ticks
from rmfs_core.scenario import Scenario, located
from rmfs_core.simulation.setup import Opening, open_warehouse
from rmfs_core.warehouse import PackingStation
from rmfs_core.world import Instance, Layout, make_instance, make_layout

BOUNDED = (
    "pod_station_visits",
    "psv_per_order",
    "distance_m",
    "loaded_distance_m",
    "distance_per_order_m",
    "turnover_s",
    "turnover_p95_s",
    "makespan_s",
    "packed_makespan_s",
)
"""Metrics with a bound: the less the better, all of them. The last is of scenarios with packing stations."""


@frozen
class Bound:
    """Lower bounds on complete runs.

    Parameters
    ----------
    metric
        The figure of result.json that is bounded.
    value
        The bound; None where there is none.
    proof
        How it was found, or why there is none.
    """

    metric: str
    value: int | float | None
    proof: str


def bounds_of(scenario: Scenario, metrics: Collection[str] = BOUNDED) -> tuple[Bound, ...]:
    """Return the bounds of a scenario with its seed, one for each of the metrics that is in `BOUNDED`.

    They hold for every run that completes all orders, whatever the scenario's rules, but that these may carry pods
    elsewhere without a visit only where it has `rules.move`. There are none where an order may be cancelled, or a
    run begins in a state.

    Raises
    ------
    InputError
        When the scenario cannot be run.
    """
    instance = make_instance(scenario)
    with located(scenario):
        return find_bounds(scenario, instance, make_layout(scenario), metrics)


def find_bounds(
    scenario: Scenario, instance: Instance, layout: Layout, metrics: Collection[str] = BOUNDED
) -> tuple[Bound, ...]:
    """Return the bounds of an instance on a layout; the scenario says the rest. What is not asked for costs no time.

    Raises
    ------
    InputError
        When there are more pods or robots than storage locations.
    """
    refilled = scenario.instance.arrivals.backlog is not None  # then none is cancelled
    cancelled = not refilled and any(order.cancelled_tick is not None for order in instance.orders)
    if cancelled or scenario.instance.state_file is not None:
        return ()
    start = _Start(open_warehouse(scenario, instance, layout), instance, moved=scenario.rules.move is not None)
    found: list[Bound] = []
    if not set(BOUNDED[:5]).isdisjoint(metrics):
        found += _of_pods(scenario, instance, start)
    if not set(BOUNDED[5:]).isdisjoint(metrics):
        found += _of_times(scenario, instance, start)
    return tuple(bound for bound in found if bound.metric in metrics)


class _Start:
    """The warehouse at time 0, for the bounds.

    Parameters
    ----------
    opening
        The warehouse, and the pods that are at stations.
    instance
        Orders and pods.
    moved
        Whether pods may be carried elsewhere before any order arrives.
    """

    def __init__(self, opening: Opening, instance: Instance, *, moved: bool) -> None:
        warehouse = opening.warehouse
        self.picking, self.known = len(warehouse.picking), not (moved or instance.restocked)
        self.packing, self.services = tuple(warehouse.packing), opening.services
        self.lift_ticks = np.array([self.services.lift(pod) for pod in range(len(warehouse.homes))])  # once
        self.cells = list(warehouse.homes)
        self.carried = [False] * len(self.cells)
        in_line = [0] * len(warehouse.stations)
        for station, pod in opening.at_stations:
            self.cells[pod] = warehouse.stations[station].cells.slot(in_line[station])
            self.carried[pod] = True
            in_line[station] += 1
        robots = [robot.cell for robot in warehouse.robots]
        at = [cell for cell, there in zip(self.cells, self.carried, strict=True) if there]  # robots that hold them
        self.ways: Ways = find_ways(warehouse.travel, robots + at)
        ordered = {sku for order in instance.orders for sku, _ in order.lines}
        self.wanted = [any(sku in ordered for sku, _ in pod.contents) for pod in instance.pods]

    def metres(self) -> list[int]:
        """Metres from each pod to the station nearest to it."""
        return [int(metres) for metres in self.ways.metres[: self.picking, self.cells].min(axis=0)]

    def opens(self, first_arrival: int) -> NDArray[np.int64]:
        """Tick before which nothing can be picked at each station, ascending. A pod is sent for an open order."""
        carried, cells, wanted = np.array(self.carried), np.array(self.cells), np.array(self.wanted)
        if not self.known:  # whatever is wanted may be near by then
            return np.full(self.picking, first_arrival)
        ticks = self.ways.ticks[: self.picking, cells]
        lifted = np.maximum(self.ways.fetch_ticks[cells], first_arrival) + self.lift_ticks
        there = np.where(carried, np.maximum(ticks, first_arrival), lifted + ticks)
        return np.sort(there[:, wanted].min(axis=1))


def _of_pods(scenario: Scenario, instance: Instance, start: _Start) -> Iterator[Bound]:
    """Yield the bounds on visits and distances, which are about the pods that are needed."""
    orders, robots = len(instance.orders), scenario.robots.count
    begun = [order.arrival_tick for order in instance.orders] + [0] * any(start.carried)
    begun += [0] * (scenario.instance.arrivals.backlog is not None or scenario.rules.move is not None)
    if instance.restocked:
        for metric in BOUNDED[:5]:
            yield Bound(metric, None, "none: stock is replenished, and one pod may come to hold all that is ordered")
        return
    if min(begun, default=0) < to_ticks(scenario.run.warmup_s or 0):
        for metric in BOUNDED[:5]:
            yield Bound(metric, None, "none: what happens before run.warmup_s does not count, and something may")
        return
    visits = cheapest_cover(instance, [1] * len(instance.pods))
    problem = "set cover" if instance.unlimited_stock else "multi-cover"
    proof = f"fewest pods that hold all that is ordered ({problem}, {visits.how})"
    yield Bound("pod_station_visits", visits.cost, proof)
    yield Bound("psv_per_order", _per(visits.cost, orders), proof)
    # All pods go back except for those on robots at the end; where these may be all, none need go back.
    back = start.ways.back_m if visits.cost > robots else 0
    cover = cheapest_cover(instance, [metres + back for metres in start.metres()])
    found = max(cover.cost - back * robots, 0)
    proof = f"pods that hold all that is ordered, carried there and, except for the last, back ({cover.how})"
    yield Bound("distance_m", found, proof)
    yield Bound("loaded_distance_m", found, proof)
    yield Bound("distance_per_order_m", _per(found, orders), proof)


def _per(total: int, orders: int) -> float | None:
    return total / orders if orders else None


def _of_times(scenario: Scenario, instance: Instance, start: _Start) -> Iterator[Bound]:
    """Yield the bounds on turn-over and makespan, which are about what pickers and robots can do in a time."""
    if not instance.orders:
        for metric in ("turnover_s", "turnover_p95_s"):
            yield Bound(metric, None, "none: there are no orders")
        yield Bound("makespan_s", 0.0, "there are no orders")
        if start.packing:
            yield Bound("packed_makespan_s", 0.0, "there are no orders")
        return
    items = np.array([order.items for order in instance.orders], dtype=np.int64)
    arrivals = np.array([order.arrival_tick for order in instance.orders], dtype=np.int64)
    if refilled := scenario.instance.arrivals.backlog is not None:
        arrivals[:] = 0  # or later
    opens = start.opens(int(arrivals.min()))
    workers = [*at_work(scenario, instance.orders, start.services, opens, scenario.robots.count)]
    if not start.services.vary:
        (pickers, _), (robots, _) = workers
        spacing = min(robots.spacing + start.ways.again_ticks, pickers.spacing)
        workers.append((evolve(robots, spacing=spacing), items))
    counted = arrivals >= to_ticks(scenario.run.warmup_s or 0)
    turnover, p95, least = None, None, "none: no order arrives after run.warmup_s"
    if refilled:
        least = "none: when orders arrive, with instance.arrivals.process = refill, depends on the rules"
    elif counted.any():
        pairs = [(one, units[counted], arrivals[counted]) for one, units in workers]
        alone = np.max([one.last_done(*of) for one, *of in pairs], axis=0) - arrivals[counted]
        done = np.max([one.completions(*of) for one, *of in pairs], axis=0)
        since = np.sort(arrivals[counted])
        turnover = int((done - since).sum()) / (len(done) * TICKS_PER_S)
        within = 95 * (len(done) - 1) // 100 + 1  # orders whose turn-over time the 95th percentile is no less than
        p95 = to_seconds(int(max((done[:within] - since[len(done) - within :]).max(), np.sort(alone)[within - 1])))
        least = "pickers and robots always at work on the orders with the least left"
    yield Bound("turnover_s", turnover, least)
    yield Bound("turnover_p95_s", p95, least)
    order = np.argsort(arrivals, kind="stable")
    later = [(one, np.cumsum(units[order][::-1])[::-1]) for one, units in workers]  # of all that arrive then or later
    last = max(int(one.last_done(of, arrivals[order]).max()) for one, of in later)
    yield Bound("makespan_s", to_seconds(last), "pickers and robots always at work since some order's arrival")
    if start.packing:
        first = 0 if start.services.vary else to_ticks(scenario.stations.handle_s)
        services, section = start.services, start.packing[0].section
        ticks = [task_ticks(services, section, "pack", order, int(n)) for order, n in enumerate(items)]
        packs = np.array(ticks, dtype=np.int64)
        yield _of_packers(start.packing, packs, np.maximum(arrivals, opens[0]), first, last)


def _of_packers(
    stations: Sequence[PackingStation],
    work: NDArray[np.int64],
    begun: NDArray[np.int64],
    first: int,
    picked: int,
) -> Bound:
    """Return the bound on the makespan to packed; an order's first item takes ``first`` ticks once it is ``begun``, and
    packing it takes its ``work``.

    Putting, waiting for other parts and hours in which packers are away come on top.
    """
    section = stations[0].section
    way = min(to_ticks(seconds) for station in stations for seconds in station.conveyor_s)
    order = np.argsort(begun, kind="stable")
    later = np.cumsum(work[order][::-1])[::-1]  # of all orders that are begun then or later
    packers = section.packers * len(stations)
    there = begun[order] + first + way
    last = max(int((there + -(-later // packers)).max()), picked + way + int(work.min()))
    return Bound("packed_makespan_s", to_seconds(last), "packers always at work since some order's first part may come")
