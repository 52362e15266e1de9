"""A period of pod-index: what is read of the warehouse, and the decision as the kernel takes it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import frozen

from rmfs_core import JointDecision, OrderAssignment, PodTrip
from rmfs_core.clock import to_seconds, to_ticks
from rmfs_core.warehouse import Lines, Stock
from rmfs_rules.helpers import largest_capacity
from rmfs_rules.pod_index.period import Ints, Weights
from rmfs_rules.pod_index.turns import decide
from rmfs_rules.pod_index.urging import NEVER, next_urgent
from rmfs_rules.pod_index.worth import MOST_STEPS

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView

MOST_SECONDS = 4096
"""Of how many seconds the power is kept in a table."""
NO_PAIRS = np.zeros((0, 2), np.int64)
NOTHING = JointDecision()


def weights_of(rule: Any) -> Weights:
    """Return the parameters of a `PodIndex` as compiled code takes them."""
    seconds_and_shares = {name: float(getattr(rule, name)) for name in Weights._fields[:10]}
    return Weights(
        **seconds_and_shares,
        most_pods=rule.most_pods,
        urge_ticks=to_ticks(rule.urge_s),
        base_ticks=to_ticks(rule.base_s),
        packing=rule.packing_capacity is not None,
        priority=np.array([float(rule.priority_factor) ** steps for steps in range(-MOST_STEPS, MOST_STEPS + 1)]),
        least=np.power(np.arange(MOST_SECONDS, dtype=np.float64), rule.finish),
    )


@frozen(eq=False)
class Site:
    """What never changes in a run.

    Parameters
    ----------
    stations
        The picking stations.
    ticks
        Driving times to each of them from each cell, shape (stations, cells).
    largest
        Items that the largest of them can take; infinite where one counts orders.
    capacity, counts_orders
        Rows of `Stations`.
    """

    stations: tuple[Station, ...]
    ticks: Ints
    largest: float
    capacity: list[int]
    counts_orders: list[int]

    @classmethod
    def of(cls, warehouse: WarehouseView) -> Site:
        """Look up the driving times."""
        stations = warehouse.stations
        times = [warehouse.travel.times_to(station.cell, True).min(axis=1) for station in stations]
        capacity, counts = [station.capacity for station in stations], [int(one.counts_orders) for one in stations]
        return cls(stations, np.array(times), largest_capacity(warehouse), capacity, counts)

    def told(self, without: Station | None = None) -> list[list[int]]:
        """Return the rows of `Stations`; ``without`` takes nothing now."""
        stations = self.stations
        room = [0 if station is without else station.free_capacity for station in stations]
        load, inbound = [station.load for station in stations], [len(station.inbound_pods) for station in stations]
        return [room, load, self.capacity, inbound, self.counts_orders, [int(free > 0) for free in room]]


def decision(
    warehouse: WarehouseView, weights: Weights, site: Site, packing_capacity: int | None, without: Station | None
) -> JointDecision:
    """Let stations take lines and send pods; ``without`` takes nothing now."""
    bound, places, n_stations = [], [], len(site.stations)
    for station in site.stations:
        for pod in station.inbound_pods:
            last = pod.bound_for[-1]
            if last >= n_stations:  # bundles are stored there
                last = [at for at in pod.bound_for if at < n_stations][-1]
            bound += [pod.id, last]
        if station.counts_orders:
            for order in {request.order.id for request in station.open_requests}:
                places += [station.id, order]
    pairs = [np.array(numbers, np.int64).reshape(-1, 2) if numbers else NO_PAIRS for numbers in (bound, places)]
    packing = 0 if packing_capacity is None else packing_capacity - warehouse.split_orders_open
    lines, told = warehouse.lines, np.array(site.told(without), np.int64)
    weights = waiting(warehouse, lines, weights)
    takes, sends = decide(lines, warehouse.stock, weights, told, *pairs, site.ticks, warehouse.now_tick, packing)
    if not (len(takes) or len(sends)):
        return NOTHING
    parts: dict[tuple[int, int], list[int]] = {}
    for at, order, sku in takes.tolist():
        parts.setdefault((order, at), []).append(sku)
    return JointDecision(
        [OrderAssignment(order, at, tuple(skus)) for (order, at), skus in parts.items()],
        [PodTrip(pod, at) for pod, at in sends.tolist()],
    )


def waiting(warehouse: WarehouseView, lines: Lines, weights: Weights) -> Weights:
    """Return the weights without any wait of pods, unless orders have come after the first ones: more may come."""
    first_s = warehouse.order(0).arrival_s
    # No need to look through all orders where one in the backlog came later
    if weights.urge_ticks and lines.arrival_s[-1] == first_s and warehouse.orders[-1].arrival_s == first_s:
        return weights._replace(urge_ticks=0)
    return weights


def wake_s(warehouse: WarehouseView, weights: Weights, site: Site) -> float | None:
    """Return when the ages of the lines of a pod will add up, if a station could take it then; None for never."""
    told = site.told()
    room, load, _, inbound, _, _ = told
    if not any(load) or not any(free and pods < weights.most_pods for free, pods in zip(room, inbound, strict=True)):
        return None
    lines = warehouse.lines
    weights = waiting(warehouse, lines, weights)
    tick = next_urgent(lines, warehouse.stock, weights, np.array(told, np.int64), warehouse.now_tick)
    return None if tick == NEVER else to_seconds(tick)


def prepare(weights: Weights) -> None:
    """Load compiled code, or compile it."""
    columns = []
    for of in (Lines, Stock):
        arrays = [np.zeros(1, float if "float" in str(kind) else np.int64) for kind in of.__annotations__.values()]
        for array in arrays:
            array.setflags(write=False)  # as those of the warehouse
        columns.append(of(*arrays))
    told, ticks = np.zeros((6, 1), np.int64), np.zeros((1, 1), np.int64)
    decide(*columns, weights, told, NO_PAIRS, NO_PAIRS, ticks, 0, 0)
    next_urgent(*columns, weights, told, 0)
