"""POA rule ``station-queue``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field

from rmfs_core import OrderAssignment, hookimpl
from rmfs_core.jit import njit
from rmfs_core.warehouse import Lines, columns_of
from rmfs_rules.helpers.pairs import Flags, Floats, Ints, Pairs, load, places_kept, pod_at
from rmfs_rules.helpers.parameters import AT_LEAST_1, NOT_NEGATIVE, parameter

if TYPE_CHECKING:
    from rmfs_core.warehouse import Robot, Station, WarehouseView
    from rmfs_core.world.travel import Travel

NOWHERE = -1
SHARE = 0.5
"""Weight in a score of the share of an order's lines that are wanted: less than an item."""


@define
class StationQueue:
    """Let orders queue for stations, and pick from each queue what suits its station.

    Each station has a queue of orders, empty at first, in which an order stays until it is assigned. While there is
    free capacity, the pair of order and station goes next, of those where the order would fit the empty station, with

    1. most items of the order available on the pods inbound to the station,
    2. the largest share of its lines whose SKU is wanted by an open request there,
    3. the earliest due time; then the oldest order, the shortest queue, the lowest id.

    Then a station with free capacity takes from its own queue, of the orders that fit,

    1. orders that are due within urgent_s or late, before others;
    2. orders that the pod at the station can complete, before others;
    3. orders that its inbound pods can complete, before others; then the oldest.

    Availability, demand and completion are looked at once in a decision. Orders larger than any station do not
    queue.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8
    """

    queue_length: int = parameter(20, AT_LEAST_1, "How many orders may queue for a station")
    urgent_s: float = parameter(600.0, NOT_NEGATIVE, "An order that is due within so much time goes before others", "s")
    fast_lane: int = places_kept(1)
    queue_of: dict[int, int] = field(init=False, factory=dict)
    """Order -> the station that it queues for."""
    _robots: tuple[Robot, ...] = field(init=False, default=(), repr=False, eq=False)  # whose run it is

    def prepare(self, travel: Travel) -> None:  # noqa: ARG002
        """Load what is compiled, or compile it."""
        load()
        add_up(columns_of((), 1), np.zeros(1, np.int64), np.zeros(1, np.bool_), np.zeros(0))

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView) -> Sequence[OrderAssignment]:
        """Fill the queues, and then the stations from them."""
        if self._robots is not warehouse.robots:  # another run
            self._robots, self.queue_of = warehouse.robots, {}
        self.queue_of = {  # of a station that closes they queue elsewhere
            order: at
            for order, at in self.queue_of.items()
            if warehouse.order(order).open_lines and warehouse.stations[at].open
        }
        lines, available = warehouse.lines, warehouse.available()
        large = np.flatnonzero(lines.items > warehouse.largest_capacity)
        self._fill(warehouse, available, large)
        chosen = np.union1d(self._queueing(warehouse), large)
        candidates = warehouse.showing([warehouse.order(order) for order in lines.order_id[chosen].tolist()])
        return self._drain(candidates, available, np.isin(chosen, large))

    def memory(self) -> list[tuple[int, int]]:
        """Return which order queues for which station, for the state of a run."""
        return [*self.queue_of.items()]

    def remember(self, memory: Sequence[Sequence[int]], warehouse: WarehouseView) -> None:
        """Take that back."""
        self._robots, self.queue_of = warehouse.robots, {int(order): int(station) for order, station in memory}

    def _fill(self, warehouse: WarehouseView, available: Ints, large: Ints) -> None:
        """Let orders join queues, the best pair of order and station first."""
        lines, number = warehouse.lines, len(warehouse.lines.items)
        length = Counter(self.queue_of.values())
        told = [length[station.id] for station in warehouse.stations]
        free = [self.queue_length - length[station.id] if station.open else 0 for station in warehouse.stations]
        scores = np.full((len(free), number), -1.0)
        for station in (station for station in warehouse.stations if free[station.id] > 0):
            wanted = np.zeros(warehouse.n_skus, np.bool_)
            wanted[[request.sku for request in station.open_requests]] = True
            here = np.zeros(number)
            add_up(lines, available[station.id], wanted, here)
            fits = station.counts_orders | (lines.items <= station.capacity)
            scores[station.id] = np.where(fits, here, -1.0)
        queues = Pairs(warehouse, scores=scores, rank=lines.due_s, queues=(free, told))
        queues.taken[self._queueing(warehouse)] = queues.taken[large] = True
        self.queue_of |= {joined.order: joined.station for joined in queues.assign()}

    def _queueing(self, warehouse: WarehouseView) -> Ints:
        """Return the rows of the orders that queue; a filter may leave out some of them."""
        row = warehouse.lines.row
        rows: Ints = row[[order for order in self.queue_of if order < len(row)]]
        return rows[rows >= 0]

    def _drain(self, candidates: WarehouseView, available: Ints, oversize: Flags) -> list[OrderAssignment]:
        """Let stations with free capacity take from their queues, and empty ones orders larger than any."""
        lines = candidates.lines
        queue = np.array([self.queue_of.get(order, NOWHERE) for order in lines.order_id.tolist()], np.int64)
        urgent = lines.due_s <= candidates.now_s + self.urgent_s

        def completed(items: Ints) -> Flags:
            """Whether items by SKU serve all that is open of each order."""
            missing = np.bincount(lines.order, items[lines.sku] < lines.quantity, len(queue))
            return np.asarray(missing == 0)

        def score(station: Station) -> Floats:
            at_station, pod = np.zeros(candidates.n_skus, np.int64), pod_at(candidates, station)
            for sku in pod.contents if pod is not None else ():
                at_station[sku] = pod.free_items(sku) if pod is not None else 0
            here = 4.0 * urgent + 2.0 * completed(at_station) + completed(available[station.id])
            return np.where((queue == station.id) | oversize, here, -1.0)

        scores = np.stack([score(station) for station in candidates.stations])
        return Pairs(candidates, scores=scores, fast_lane=self.fast_lane).assign()


@njit(cache=True, interpreted=True)
def add_up(lines: Lines, available: Ints, wanted: Flags, scores: Floats) -> None:
    """Add to the scores of orders, 0 before: `SHARE` of the lines that are wanted, and the items that are available."""
    for sku in range(len(wanted)):
        for at in range(lines.first[sku], lines.first[sku] + lines.number[sku] * wanted[sku]):
            scores[lines.listed_order[at]] += 1
    for row in range(len(scores)):
        if scores[row] > 0:
            scores[row] = SHARE * (scores[row] / lines.open_lines[row])
    for sku in range(len(available)):
        for at in range(lines.first[sku], lines.first[sku] + lines.number[sku] * (available[sku] > 0)):
            scores[lines.listed_order[at]] += min(lines.listed_items[at], available[sku])
