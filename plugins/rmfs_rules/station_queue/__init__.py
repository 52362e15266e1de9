"""POA rule ``station-queue``."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field, validators
from numpy.typing import NDArray

from rmfs_core import OrderAssignment, hookimpl
from rmfs_rules.helpers import assign_best_pairs, items_per_order, largest_capacity, pod_at, sum_per_order
from rmfs_rules.helpers.options import due_s, places_kept
from rmfs_rules.helpers.pair_scores import PairScores, by_due_time

if TYPE_CHECKING:
    from rmfs_core.traffic import Roads
    from rmfs_core.warehouse import Robot, Station, WarehouseView

NOWHERE = -1


@define
class StationQueue:
    """Let orders queue for stations, and pick from each queue what suits its station.

    Each station has a queue of orders, empty at first, in which an order stays until it is assigned. While there is
    room, the pair of order and station goes next, of those where the order would fit the empty station, with

    1. most items of the order available on the pods inbound to the station,
    2. the largest share of its lines whose SKU is wanted by an open request there,
    3. the earliest due time; then the oldest order, the shortest queue, the lowest id.

    Then a station with room takes from its own queue, of the orders that fit,

    1. those that are due within urgent_s or late, before others;
    2. those that the pod at the station can complete, before others;
    3. those that its inbound pods can complete, before others; then the oldest.

    What is available, wanted or can be completed is looked at once in a decision. Orders larger than any station do not
    queue.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8
    """

    queue_length: int = field(
        default=20, validator=validators.ge(1), metadata={"doc": "How many orders may queue for a station"}
    )
    urgent_s: float = field(
        default=600.0,
        validator=validators.ge(0),
        metadata={"unit": "s", "doc": "An order that is due within so much time goes before those that are not"},
    )
    fast_lane: int = places_kept(1)
    queue_of: dict[int, int] = field(init=False, factory=dict)
    """Order -> the station that it queues for."""
    _robots: tuple[Robot, ...] = field(init=False, default=(), repr=False, eq=False)  # whose run it is

    _scores: PairScores = field(init=False, factory=lambda: PairScores(by_due_time, tables=2), repr=False, eq=False)
    _places: dict[int, int] = field(init=False, factory=dict, repr=False, eq=False)  # of queued orders, in the scores
    _log: object = field(init=False, default=None, repr=False, eq=False)  # whose lines the scores are made of

    def prepare(self, roads: Roads) -> None:  # noqa: ARG002
        """Load what is compiled, or compile it."""
        self._scores.load()

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView) -> Sequence[OrderAssignment]:
        """Fill the queues, and then the stations from them."""
        if self._robots is not warehouse.robots:  # another run
            self._robots, self.queue_of = warehouse.robots, {}
        if self._log is not warehouse.backlog_log():  # the scores begin anew
            self._log, self._places = warehouse.backlog_log(), {}
        self.queue_of = {  # of a station that closes they queue elsewhere
            order: at
            for order, at in self.queue_of.items()
            if warehouse.order(order).open_lines and warehouse.stations[at].open
        }
        wanted = np.zeros((len(warehouse.stations), warehouse.n_skus), np.int64)
        for station in warehouse.stations:
            wanted[station.id, [request.sku for request in station.open_requests]] = 1
        if self._scores.decides(warehouse, warehouse.available(), wanted):
            self._fill_by_scores(warehouse)
            large = {self._scores.order_at(place): place for place in self._scores.oversize}
            places = large | {order: self._places[order] for order in self.queue_of}
            candidates = warehouse.showing([warehouse.order(order) for order in sorted(places, key=places.__getitem__)])
        else:
            self._fill(_Suitability(warehouse), items_per_order(warehouse) > largest_capacity(warehouse))
            candidates = warehouse
        suitability = _Suitability(candidates)
        oversize = items_per_order(candidates) > largest_capacity(warehouse)
        queue = np.array([self.queue_of.get(order.id, NOWHERE) for order in candidates.backlog], np.int64)
        urgent = due_s(candidates) <= warehouse.now_s + self.urgent_s

        def score(station: Station) -> NDArray[np.int64]:
            here = 4 * urgent + 2 * suitability.completed_now(station) + suitability.completed_soon(station)
            return np.where((queue == station.id) | oversize, here, -1)

        return assign_best_pairs(candidates, score, fast_lane=self.fast_lane)

    def _fill_by_scores(self, warehouse: WarehouseView) -> None:
        """Let orders join queues as `_fill` does, by what is kept."""
        length = Counter(self.queue_of.values())
        for order in self.queue_of.keys() - self._places.keys():  # queued without the scores
            self._places[order] = self._scores.place_of(order)
        queued = [self._places[order] for order in self.queue_of]
        for place, at in self._scores.queue_up(warehouse, length, self.queue_length, queued):
            order = self._scores.order_at(place)
            self.queue_of[order], self._places[order] = at, place
        self._places = {order: self._places[order] for order in self.queue_of}

    def _fill(self, suitability: _Suitability, oversize: NDArray[np.bool_]) -> None:
        """Let orders join queues, the best pair of order and station first."""
        warehouse = suitability.warehouse
        length = Counter(self.queue_of.values())
        joining = np.array([order.id not in self.queue_of for order in warehouse.backlog], np.bool_) & ~oversize
        stations = [s for s in warehouse.stations if s.open and length[s.id] < self.queue_length]
        lines = {s.id: suitability.ranked(s, joining) for s in stations}
        heads = {station: next(line, None) for station, line in lines.items()}
        while ready := [(key, length[station], station) for station, key in heads.items() if key is not None]:
            key, _, station = min(ready)
            position = key[-1]
            if joining[position]:
                joining[position] = False
                self.queue_of[warehouse.backlog[position].id] = station
                length[station] += 1
            heads[station] = next(lines[station], None) if length[station] < self.queue_length else None


class _Suitability:
    """How orders suit stations, by what is available and wanted there when a decision begins."""

    def __init__(self, warehouse: WarehouseView) -> None:
        self.warehouse = warehouse
        self._lines = warehouse.backlog_lines
        self._available = warehouse.available()
        self._number = sum_per_order(warehouse, np.ones_like(self._lines.sku))
        self._due_s = due_s(warehouse)

    def ranked(self, station: Station, joining: NDArray[np.bool_]) -> _Line:
        """Return the orders that may join the queue of a station, the most suitable first."""
        lines, warehouse = self._lines, self.warehouse
        matches = sum_per_order(warehouse, np.minimum(self._available[station.id, lines.sku], lines.quantity))
        wanted = np.zeros(warehouse.n_skus, np.int64)
        wanted[[request.sku for request in station.open_requests]] = 1
        related = sum_per_order(warehouse, wanted[lines.sku]) / np.maximum(self._number, 1)
        capacity = math.inf if station.counts_orders else station.capacity
        able = np.flatnonzero(joining & (items_per_order(warehouse) <= capacity))
        order = able[np.lexsort((self._due_s[able], -related[able], -matches[able]))]
        return _Line(order, matches, related, self._due_s)

    def completed_now(self, station: Station) -> NDArray[np.bool_]:
        """Whether the pod at a station has all that is open of each order."""
        items = np.zeros(self.warehouse.n_skus, np.int64)
        pod = pod_at(self.warehouse, station)
        for sku in pod.contents if pod is not None else ():
            items[sku] = pod.free_items(sku) if pod is not None else 0
        return self._completed(items)

    def completed_soon(self, station: Station) -> NDArray[np.bool_]:
        """Whether the pods inbound to a station have all that is open of each order."""
        return self._completed(self._available[station.id])

    def _completed(self, items: NDArray[np.int64]) -> NDArray[np.bool_]:
        missing = (items[self._lines.sku] < self._lines.quantity).astype(np.int64)
        completed: NDArray[np.bool_] = sum_per_order(self.warehouse, missing) == 0
        return completed


class _Line:
    """Orders in the order in which they may join a queue; each comes with the key that it is compared by."""

    def __init__(
        self,
        order: NDArray[np.int64],
        matches: NDArray[np.int64],
        related: NDArray[np.float64],
        due_s: NDArray[np.float64],
    ) -> None:
        self._order = iter(order.tolist())
        self._keys = matches, related, due_s

    def __iter__(self) -> _Line:
        return self

    def __next__(self) -> tuple[float, float, float, int]:
        position = next(self._order)
        matches, related, due = (float(values[position]) for values in self._keys)
        return -matches, -related, due, position
