"""Scores of pods: one number for each candidate, all of them at once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.warehouse import Lines, Order, columns_of, stock_of
from rmfs_core.world import OrderData
from rmfs_rules.helpers import sending
from rmfs_rules.helpers.sending import Ids, ticks_from, worth
from rmfs_rules.scorers.sums import completed, served

if TYPE_CHECKING:
    from rmfs_core.warehouse import Request, Station, WarehouseView

Values = NDArray[np.float64]

VALUES = ("picks", "age", "lateness")
"""Worth of an item: 1, or its share of the seconds since its order arrived or was due."""


class PodScores:
    """Scores of pods for stations in one decision, the higher the better; what is chosen changes those to come.

    Parameters
    ----------
    warehouse
        The warehouse now.
    rng
        Draws lots.
    rule
        The rule, whose parameters are the weights of the parts of a score: `Completes`, `WorkAmount` or
        `Lexicographic`, or one with the same parameters as far as its scores read them.
    """

    def __init__(self, warehouse: WarehouseView, rng: np.random.Generator, rule: Any) -> None:
        self._warehouse, self._rng, self._rule = warehouse, rng, rule
        self._stock, self._nothing = warehouse.stock, np.zeros(warehouse.n_skus, np.int64)
        self._requests: dict[int, list[tuple[Request, int]]] = {}  # of stations: those left, and of how many items
        self._lines: dict[int, Lines] = {}  # of stations: what their uncovered requests want

    def choose(self, scores: Sequence[str], station: Station, pods: Ids) -> int:
        """Return the pod with the best first score, ties by the next one and at last by the lowest id; it is taken."""
        left = pods
        for name in scores:
            if len(left) == 1:
                break
            values = SCORES[name](self, station, left)
            left = left[values == values.max()]
        chosen = int(left[0])
        self._take(chosen, station)
        return chosen

    # Scores

    def completes(self, station: Station, pods: Ids) -> Values:
        """Orders of which the pod fulfils all requests at the station that are uncovered.

        And those of the backlog, if they count, that what is left on it completes one after another, oldest first.
        """
        lines = self._here(station)
        number: Values = completed(lines, self._stock, pods, self._nothing, np.ones(len(lines.items)))
        if self._rule.count_backlog:
            others, before = self._warehouse.lines, self._by_sku(lines)
            number += completed(others, self._stock, pods, before, np.ones(len(others.items)))
        return number

    def picks(self, station: Station, pods: Ids) -> Values:
        """Uncovered items of the station that the pod has."""
        return worth(self._stock, pods, self._by_sku(self._here(station))).astype(np.float64)

    def work(self, station: Station, pods: Ids) -> Values:
        """Worth of the items that the pod serves, less the time that it drives."""
        rule, stock, lines = self._rule, self._stock, self._here(station)
        each = self._each(lines, range(len(lines.items)))
        total: Values = rule.time_cost_per_s * self.nearest(station, pods)
        total += served(lines, stock, pods, self._nothing, each)
        if rule.completion_boost:
            total += rule.completion_boost * completed(lines, stock, pods, self._nothing, each * lines.items)
        if rule.backlog_weight:
            before = self._by_sku(lines)
            total += rule.backlog_weight * served(self._warehouse.lines, stock, pods, before, self._each_waiting)
        return total

    def demand(self, station: Station, pods: Ids) -> Values:  # noqa: ARG002
        """Items wanted in the whole system, assigned or not, that the pod has free."""
        return worth(self._stock, pods, self._warehouse.open_demand()).astype(np.float64)

    def nearest(self, station: Station, pods: Ids) -> Values:
        """Seconds of loaded driving to the station, with a minus in front."""
        seconds: Values = ticks_from(self._warehouse, self._stock.cell[pods], station) / -TICKS_PER_S
        return seconds

    def random(self, station: Station, pods: Ids) -> Values:  # noqa: ARG002
        """A lot drawn for each pod."""
        return self._rng.random(len(pods))

    # What they are made of

    @cached_property
    def _each_waiting(self) -> Values:
        """Worth of an item of each order of the backlog, by row."""
        lines = self._warehouse.lines
        return self._each(lines, lines.begun if self._warehouse.split_orders_open else ())

    def _here(self, station: Station) -> Lines:
        """Return what the uncovered requests of a station want, of orders in the order of their first requests."""
        if station.id not in self._lines:
            wanted: dict[Order, Counter[int]] = {}
            for request, number in self._uncovered(station):
                wanted.setdefault(request.order, Counter())[request.sku] += number
            orders = [
                Order(
                    of.id, OrderData("", tuple(held.items()), arrival_tick=of.arrival_tick, due_tick=of.due_tick), int
                )
                for of, held in wanted.items()
            ]
            self._lines[station.id] = columns_of(orders, self._warehouse.n_skus)
        return self._lines[station.id]

    def _uncovered(self, station: Station) -> list[tuple[Request, int]]:
        """Return the requests of a station that no chosen pod serves, and how many items of each."""
        if station.id not in self._requests:
            self._requests[station.id] = [(request, request.items) for request in station.uncovered_requests]
        return self._requests[station.id]

    def _by_sku(self, lines: Lines) -> Ids:
        """Return the items that are wanted of each SKU."""
        return np.bincount(lines.sku, lines.quantity, self._warehouse.n_skus).astype(np.int64)

    def _each(self, lines: Lines, begun: Iterable[int]) -> Values:
        """Return what an item of each order is worth, by row; some items of begun orders may be picked."""
        value, unpicked = self._rule.value, np.maximum(lines.items, 1)
        if value == "picks":
            return np.ones(len(unpicked))
        for row in begun:
            unpicked[row] = self._warehouse.order(int(lines.order_id[row])).unpicked_items
        since_s = lines.due_s if value == "lateness" else lines.arrival_s
        each: Values = np.maximum(self._warehouse.now_s - since_s, 0.0) / unpicked
        return each

    def _take(self, pod: int, station: Station) -> None:
        """Let the items of a chosen pod go to the oldest requests, as they will."""
        requests = self._uncovered(station)
        left = {sku: self._warehouse.pods[pod].free_items(sku) for sku in {request.sku for request, _ in requests}}
        still = []
        for request, number in requests:
            served = min(number, left[request.sku])
            left[request.sku] -= served
            if served < number:
                still.append((request, number - served))
        self._requests[station.id] = still
        self._lines.pop(station.id, None)


def load() -> None:
    """Load what is compiled, or compile it."""
    sending.load()
    lines, stock, none, one = columns_of((), 1), stock_of((), 1), np.zeros(0, np.int64), np.zeros(1, np.int64)
    for search in (completed, served):
        search(lines, stock, none, one, none / 1)


Score = Callable[[PodScores, "Station", Ids], Values]

SCORES: Mapping[str, Score] = MappingProxyType(
    {name: getattr(PodScores, name) for name in ("completes", "picks", "work", "demand", "nearest", "random")}
)
"""The scores by name."""
