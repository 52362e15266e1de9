"""The rules of `rmfs_rules.joint` in plain numpy, which keep nothing: what they are held against."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rmfs_core import JointDecision, OrderAssignment, PodTrip, SolveReport
from rmfs_core.warehouse import Station, WarehouseView
from rmfs_rules.helpers import (
    OVERSIZE_WAIT_S,
    assign_best_pairs,
    items_per_order,
    largest_capacity,
    lines_at,
    sum_per_order,
    ticks_to_station,
)

Integers = NDArray[np.int64]
Sent = Sequence[tuple[int, int]]
"""Pods (ids) and the stations that they are sent to."""
Chosen = Sequence[tuple[int, int]]
"""Orders, by position in the backlog, and their stations."""

NOT_NOW = -1
"""Score of an order that may not be chosen."""
SCALE = 1_000_000
"""Scores are whole numbers: what a line that is missing counts at a station that counts orders."""


class Left:
    """What pods have left while orders are chosen one after another.

    Parameters
    ----------
    warehouse
        The warehouse now.
    sent
        Pods that are sent besides those that are at or bound for stations.

    Attributes
    ----------
    at
        Items left on the pods of each station; below 0, what pods still have to bring. Shape (stations, SKUs).
    """

    def __init__(self, warehouse: WarehouseView, sent: Sent = ()) -> None:
        self.warehouse = warehouse
        self._lines, free = warehouse.backlog_lines, warehouse.free_items
        self.at = warehouse.available()
        for pod, station in sent:
            held = slice(*np.searchsorted(free.pod, (pod, pod + 1)).tolist())
            self.at[station, free.sku[held]] += free.number[held]
        self._supply: Integers | None = None
        if not warehouse.unlimited_stock:
            self._supply = np.zeros(warehouse.n_skus, np.int64)
            np.add.at(self._supply, free.sku, free.number)

    @cached_property
    def _items(self) -> Integers:
        return items_per_order(self.warehouse)

    @cached_property
    def most_lines(self) -> int:
        """Open lines of the order that has most."""
        return int(np.bincount(self._lines.order).max(initial=0))

    def missing(self, station: Station) -> Integers:
        """Lines of each order that a pod would have to be sent for, which none is sent for anyway."""
        left = self.at[station.id][self._lines.sku]
        return sum_per_order(self.warehouse, ((left >= 0) & (left < self._lines.quantity)).astype(np.int64))

    def score(self, station: Station) -> Integers:
        """Return how good each order is at a station: most where fewest lines are missing for each place it takes."""
        places = 1 if station.counts_orders else self._items
        scores: Integers = (self.most_lines + 1) * SCALE - self.missing(station) * SCALE // places
        return np.where(self.in_stock(), scores, NOT_NOW)

    def in_stock(self) -> NDArray[np.bool_]:
        """Whether all pods together have enough left for each order."""
        if self._supply is None:
            return np.ones(len(self.warehouse.backlog), np.bool_)
        lacking = self._supply[self._lines.sku] < self._lines.quantity
        enough: NDArray[np.bool_] = sum_per_order(self.warehouse, lacking.astype(np.int64)) == 0
        return enough

    def take(self, station: Station, position: int) -> Iterable[int]:
        """Take account of a chosen order; return the ids of the stations at which scores change."""
        where = lines_at(self.warehouse, position)
        sku, quantity = self._lines.sku[where], self._lines.quantity[where]
        self.at[station.id][sku] -= quantity
        if self._supply is None:
            return (station.id,)
        self._supply[sku] -= quantity
        return range(len(self.warehouse.stations))


def waiting_too_long(warehouse: WarehouseView, max_wait_s: float | None) -> set[int]:
    """Return the orders that have waited too long, by position in the backlog, as `assign_best_pairs` has it."""
    oversize = items_per_order(warehouse) > largest_capacity(warehouse)
    if max_wait_s is None and not oversize.any():
        return set()  # nobody's arrival matters
    limit_s = np.where(oversize, OVERSIZE_WAIT_S, np.inf) if max_wait_s is None else max_wait_s
    waited_s = warehouse.now_s - np.array([order.arrival_s for order in warehouse.backlog])
    return set(np.flatnonzero(waited_s >= limit_s).tolist())


def placed(warehouse: WarehouseView, pairs: Iterable[OrderAssignment]) -> list[tuple[int, int]]:
    """Return orders that were assigned, by position in the backlog, and their stations."""
    lines = warehouse.backlog_lines
    return [(int(lines.order[(lines.order_id == pair.order).argmax()]), pair.station) for pair in pairs]


def pods_for(warehouse: WarehouseView, chosen: Chosen, worth: Integers | None = None) -> Sent:
    """Return few pods that bring what chosen orders lack at their stations.

    Again and again the pod that brings a station most goes there; of equals one that is bound for no station, the one
    with most ``worth``, the nearest, the lowest id. Then those that the others make needless stay.

    Parameters
    ----------
    warehouse
        The warehouse now. All pods together have what the orders want.
    chosen
        The orders.
    worth
        Of each pod, what else speaks for it; left out: nothing.
    """
    period = _Covering(warehouse, chosen)
    sent: list[tuple[int, int]] = []
    stock, need = period.dealt(sent)
    gains = np.minimum(stock[:, None, :], need[None, :, :]).sum(axis=2)
    while need.any():
        most = np.argwhere(gains == gains.max())
        pod, station = min(
            ((int(pod), int(at)) for pod, at in most), key=lambda pair: period.rank(pair[0], pair[1], worth)
        )
        assert gains[pod, station] > 0, "all pods together have enough"
        sent.append((pod, station))
        _deal(stock[pod], need[station])
        gains[pod] = np.minimum(stock[pod], need).sum(axis=1)
        gains[:, station] = np.minimum(stock, need[station]).sum(axis=1)
    for trip in sent[:-1]:
        others = [other for other in sent if other != trip]
        if not period.dealt(others)[1].any():
            sent = others
    return sent


def serve(warehouse: WarehouseView, chosen: Chosen, sent: Sent) -> bool:
    """Whether the pods at, bound for and sent to stations have what chosen orders want, dealt out in this order."""
    return not _Covering(warehouse, chosen).dealt(sent)[1].any()


def _deal(stock: Integers, need: Integers) -> None:
    """Give what a pod has to a station that needs it."""
    given = np.minimum(stock, need)
    stock -= given
    need -= given


class _Covering:
    """What chosen orders want, and what pods have of it."""

    def __init__(self, warehouse: WarehouseView, chosen: Chosen) -> None:
        self.warehouse = warehouse
        lines, free = warehouse.backlog_lines, warehouse.free_items
        at = [(station, lines_at(warehouse, position)) for position, station in chosen]
        wanted = np.zeros((len(warehouse.stations), warehouse.n_skus), np.int64)
        for station, where in at:
            wanted[station, lines.sku[where]] += lines.quantity[where]
        columns = np.flatnonzero(wanted.any(axis=0))
        self._need = wanted[:, columns]
        self._stock = np.zeros((len(warehouse.pods), len(columns)), np.int64)
        column = np.full(warehouse.n_skus, -1)
        column[columns] = np.arange(len(columns))
        held = column[free.sku] >= 0
        self._stock[free.pod[held], column[free.sku[held]]] = free.number[held]
        self._inbound = [(pod.id, station.id) for station in warehouse.stations for pod in station.inbound_pods]
        self._busy = {pod for pod, _ in self._inbound}

    def dealt(self, sent: Sent) -> tuple[Integers, Integers]:
        """Return what pods have left, and what stations lack, once the pods at or bound for them have served."""
        stock, need = self._stock.copy(), self._need.copy()
        for pod, station in (*self._inbound, *sent):
            _deal(stock[pod], need[station])
        return stock, need

    def rank(self, pod: int, station: int, worth: NDArray[np.int64] | None) -> tuple[bool, int, int, int, int]:
        """Return which of two pods that bring as much is sent: the lower one."""
        ticks = ticks_to_station(self.warehouse, self.warehouse.pods[pod], self.warehouse.stations[station])
        return pod in self._busy, 0 if worth is None else -int(worth[pod]), ticks, pod, station


def cost(warehouse: WarehouseView, chosen: Chosen, sent: Sent, weight: float) -> float:
    """Return the objective (1): visits to stations with free places, and ``weight`` for every place that stays free.

    At a station that counts orders, a free place counts times the items of the largest order.
    """
    free = {station.id: station.free_capacity for station in warehouse.stations}
    visits = len(sent) + sum(len(warehouse.stations[station].inbound_pods) for station in free if free[station])
    for position, station in chosen:
        free[station] -= warehouse.size_at(warehouse.backlog[position], warehouse.stations[station])
    largest = int(items_per_order(warehouse).max(initial=1))
    return visits + weight * sum(
        places * (largest if warehouse.stations[station].counts_orders else 1) for station, places in free.items()
    )


def decision(warehouse: WarehouseView, chosen: Chosen, sent: Sent, weight: float | None = None) -> JointDecision:
    """Return orders and pods as the kernel takes them; with a ``weight``, their cost as well."""
    if not chosen:
        return JointDecision()
    return JointDecision(
        [OrderAssignment(warehouse.backlog[position].id, station) for position, station in chosen],
        [PodTrip(pod, station) for pod, station in sent],
        None if weight is None else SolveReport("heuristic", cost(warehouse, chosen, sent, weight)),
    )


def alternating(
    warehouse: WarehouseView,
    rng: np.random.Generator,
    *,
    rounds: int = 10,
    unused_capacity_weight: float = 2.0,
    max_wait_s: float | None = None,
) -> JointDecision:
    """Decide as `Alternating` does."""
    *_, (_, chosen, sent) = improving(warehouse, rounds, unused_capacity_weight, max_wait_s)
    return decision(warehouse, chosen, sent, unused_capacity_weight)


def improving(
    warehouse: WarehouseView, rounds: int, weight: float, max_wait_s: float | None
) -> Iterator[tuple[float, Chosen, Sent]]:
    """Yield the choices one after another, with their cost: each costs less than the one before."""
    before = math.inf
    sent: Sent = ()
    for _ in range(rounds):
        left = Left(warehouse, sent)
        pairs = assign_best_pairs(warehouse, left.score, left.take, max_wait_s=max_wait_s)
        chosen = placed(warehouse, pairs)
        sent = pods_for(warehouse, chosen)
        costs = cost(warehouse, chosen, sent, weight)
        if costs >= before:
            return
        yield costs, chosen, sent
        before = costs


def two_stage(
    warehouse: WarehouseView,
    rng: np.random.Generator,
    *,
    first_share: float = 0.75,
    first_orders: str = "cheapest",
    max_wait_s: float | None = None,
) -> JointDecision:
    """Decide as `TwoStage` does."""
    first = first_stage(warehouse, first_share, first_orders, max_wait_s)
    sent = pods_for(warehouse, first, wanted_on(warehouse))
    return decision(warehouse, [*first, *second_stage(warehouse, first, sent, max_wait_s)], sent)


def first_stage(warehouse: WarehouseView, first_share: float, first_orders: str, max_wait_s: float | None) -> Chosen:
    """Return the orders of the first stage."""
    left, load = Left(warehouse), {station.id: station.load for station in warehouse.stations}
    youngest_last = np.arange(len(warehouse.backlog))[::-1] * (left.most_lines + 1)

    def score(station: Station) -> Integers:
        if load[station.id] >= first_share * station.capacity:
            return np.full(len(youngest_last), NOT_NOW)
        if first_orders == "cheapest":
            return left.score(station)
        return np.where(left.in_stock(), youngest_last + left.most_lines - left.missing(station), NOT_NOW)

    def take(station: Station, position: int) -> Iterable[int]:
        load[station.id] += warehouse.size_at(warehouse.backlog[position], station)
        return left.take(station, position)

    pairs = assign_best_pairs(warehouse, score, take, max_wait_s=max_wait_s)
    return placed(warehouse, pairs)


def second_stage(warehouse: WarehouseView, first: Chosen, sent: Sent, max_wait_s: float | None) -> Chosen:
    """Return the orders of the second stage."""
    chosen, taken = list(first), {position for position, _ in first}
    if waiting_too_long(warehouse, max_wait_s) - taken:
        return []
    free = {station.id: station.free_capacity for station in warehouse.stations}
    for position, at in first:
        free[at] -= warehouse.size_at(warehouse.backlog[position], warehouse.stations[at])
    left = Left(warehouse, sent)
    complete = np.column_stack([left.missing(station) == 0 for station in warehouse.stations])
    for position in np.flatnonzero(complete.any(axis=1)).tolist():
        if position in taken:
            continue
        for station in sorted(warehouse.stations, key=lambda at: (at.capacity - free[at.id], at.id)):
            size = warehouse.size_at(warehouse.backlog[position], station)
            further = [*chosen, (position, station.id)]
            if complete[position, station.id] and size <= free[station.id] and serve(warehouse, further, sent):
                free[station.id] -= size
                chosen = further
                break
    return chosen[len(first) :]


def wanted_on(warehouse: WarehouseView) -> Integers:
    """Return how many items on each pod the backlog wants."""
    lines, free = warehouse.backlog_lines, warehouse.free_items
    demand = np.bincount(lines.sku, weights=lines.quantity, minlength=warehouse.n_skus)
    wanted = np.minimum(free.number, demand[free.sku])
    return np.bincount(free.pod, weights=wanted, minlength=len(warehouse.pods)).astype(np.int64)


def lns(
    warehouse: WarehouseView,
    rng: np.random.Generator,
    *,
    iterations: int = 50,
    share: float = 0.3,
    unused_capacity_weight: float = 2.0,
    max_wait_s: float | None = None,
) -> JointDecision:
    """Decide as `LargeNeighborhoodSearch` does where it looks at all orders."""
    weight = unused_capacity_weight
    *_, (_, chosen, sent) = improving(warehouse, 10, weight, max_wait_s)
    waiting = waiting_too_long(warehouse, max_wait_s)
    if not chosen or waiting - {position for position, _ in chosen}:
        return decision(warehouse, chosen, sent, weight)
    best = value_of(warehouse, chosen, sent, weight)
    sizes = sizes_of(warehouse)
    for _ in range(iterations):
        taken_back = taken_back_of(warehouse, chosen, sent, share, rng) - waiting
        kept = [pair for pair in chosen if pair[0] not in taken_back]
        other = filled(warehouse, kept, sizes, rng)
        pods = pods_for(warehouse, other)
        value = value_of(warehouse, other, pods, weight)
        if value < best:
            best, chosen, sent = value, other, pods
    return decision(warehouse, chosen, sent, weight)


def taken_back_of(
    warehouse: WarehouseView, chosen: Chosen, sent: Sent, share: float, rng: np.random.Generator
) -> set[int]:
    """Return the orders to take back, by position in the backlog."""
    way = int(rng.integers(3))
    if way == 0 or (way == 1 and not sent):
        drawn = rng.random(len(chosen)) < share
        return {position for (position, _), taken in zip(chosen, drawn.tolist(), strict=True) if taken}
    if way == 1:
        pod, at = sent[int(rng.integers(len(sent)))]
        skus, there = warehouse.backlog_lines.sku, [position for position, station in chosen if station == at]
        held = warehouse.pods[pod].contents.keys()
        return {position for position in there if held & set(skus[lines_at(warehouse, position)].tolist())}
    at = chosen[int(rng.integers(len(chosen)))][1]
    return {position for position, station in chosen if station == at}


def value_of(warehouse: WarehouseView, chosen: Chosen, sent: Sent, weight: float) -> tuple[float, list[int]]:
    """Return what is compared: the cost, and then the orders, oldest first."""
    return cost(warehouse, chosen, sent, weight), sorted(position for position, _ in chosen)


def sizes_of(warehouse: WarehouseView) -> Integers:
    """Return what each order of the backlog takes up at each station."""
    return np.array([[warehouse.size_at(order, at) for at in warehouse.stations] for order in warehouse.backlog])


def filled(warehouse: WarehouseView, kept: Chosen, sizes: Integers, rng: np.random.Generator) -> Chosen:
    """Return the orders that are kept, and more as long as any fits."""
    stations = warehouse.stations
    left = Left(warehouse, pods_for(warehouse, kept))
    free = np.array([station.free_capacity for station in stations])
    open_ = np.ones(len(sizes), np.bool_)
    for position, station in kept:
        left.take(stations[station], position)
        free[station] -= sizes[position, station]
        open_[position] = False
    noise = rng.integers(0, SCALE // 2, sizes.shape)
    chosen, changed = list(kept), [station.id for station in stations]
    scores = np.empty_like(sizes)
    while True:
        for station in changed:
            score = left.score(stations[station])
            scores[:, station] = np.where(score == NOT_NOW, NOT_NOW, score - noise[:, station])
        able = np.where((sizes <= free) & open_[:, None], scores, NOT_NOW)
        position, station = (int(at) for at in np.unravel_index(able.argmax(), able.shape))
        if able[position, station] == NOT_NOW:
            return chosen
        chosen.append((position, station))
        free[station] -= sizes[position, station]
        open_[position] = False
        changed = list(left.take(stations[station], position))
