"""One decision: which orders go to which stations with given pods, and what that costs by the objective (1)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import field, validators
from numpy.typing import NDArray

from rmfs_core import JointDecision, OrderAssignment, PodTrip, SolveReport
from rmfs_rules.helpers import OVERSIZE_WAIT_S, largest_capacity, station_to_keep
from rmfs_rules.joint.covering import Chosen, Covering, Sent
from rmfs_rules.joint.lacking import Ints, Lacking, counted

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView

ANY_LOAD = np.inf
"""Load below which a station takes orders that takes all that fit."""
NO_PAIRS = np.zeros((2, 0), np.int64)
"""No orders that have a place at a station."""
NO_NOISE = np.zeros((0, 0), np.int64)
"""Nothing that orders lack by chance."""
KEPT = -1
"""Free places of a station that is kept for an order."""


def unused_capacity_weight() -> Any:
    """Return the parameter ``unused_capacity_weight`` of a rule that goes by `Period.cost`."""
    return field(
        default=2.0,
        validator=validators.gt(0),
        metadata={"doc": "W_u in the cost: what a free place that stays unused costs, in pod-station visits"},
    )


class Kept:
    """What joint rules keep from call to call: orders, and pods."""

    def __init__(self) -> None:
        self.orders, self.pods = Lacking(), Covering()

    def load(self) -> None:
        """Load what is compiled, or compile it."""
        from rmfs_rules.joint import choosing_search  # compiled: imported when needed, for it takes its time

        self.orders.load()
        self.pods.load()
        stations, until, kept = np.zeros((4, 1), np.int64), np.full(1, ANY_LOAD), self.orders.kept
        for noise in (NO_NOISE, np.zeros((1, 1), np.int64)):
            choosing_search.fill(choosing_search.CHEAPEST, noise, stations, until, NO_PAIRS, 1.0, kept)
        choosing_search.complete(-1, stations, until, NO_PAIRS, 1.0, kept)
        choosing_search.foremost(1, stations, until, NO_PAIRS, 1.0, kept)
        choosing_search.station_for(0, choosing_search.CHEAPEST, stations, until, NO_PAIRS, 1.0, kept)
        choosing_search.take(0, 0, stations, NO_PAIRS, 1.0, kept)

    def period(self, warehouse: WarehouseView, max_wait_s: float | None) -> Period:
        """Take in what changed, and begin a decision; where filters choose, or orders are in part, they are read."""
        self.pods.update(warehouse)
        if not warehouse.filtered:
            self.orders.update(warehouse)
            if self.orders.whole:
                return Period(warehouse, self.orders, self.pods, max_wait_s)
        shown, lines = Lacking(), warehouse.backlog_lines
        shown.begin(counted(warehouse), warehouse.n_skus, max(len(lines.sku), 1))
        if len(lines.sku):
            shown.join(np.array([lines.order_id, lines.sku, lines.quantity]))
        return Period(warehouse, shown, self.pods, max_wait_s, with_a_place(warehouse, shown))


class Period:
    """The orders, stations and pods of one decision.

    Parameters
    ----------
    warehouse
        The warehouse now.
    orders
        The orders in question, with all their open lines.
    pods
        What pods have.
    max_wait_s
        How long an order may wait, as `assign_best_pairs` has it.
    placed
        Orders that have a place at a station that counts orders, see `with_a_place`. Left out: none.

    Attributes
    ----------
    empty
        Free places of the stations, capacity, whether they count orders, and load, before anything is decided.
    most_items
        Open items of the largest order of the backlog.
    """

    def __init__(
        self,
        warehouse: WarehouseView,
        orders: Lacking,
        pods: Covering,
        max_wait_s: float | None,
        placed: Ints | None = None,
    ) -> None:
        from rmfs_rules.joint import choosing_search  # see above

        self._work: Any = choosing_search
        self.warehouse, self.orders, self.pods, self.max_wait_s = warehouse, orders, pods, max_wait_s
        self.largest = float(largest_capacity(warehouse))
        of_stations = [(s.free_capacity, s.capacity, s.counts_orders, s.load) for s in warehouse.stations]
        self.empty: Ints = np.array(of_stations, np.int64).T.copy()
        self.placed = NO_PAIRS if placed is None else placed
        self.most_items = orders.most_items
        self._until = np.full(len(of_stations), ANY_LOAD)

    def filled(self, sent: Sent, *, oldest: bool = False, until: NDArray[np.float64] | None = None) -> Chosen:
        """Return orders that are chosen greedily, as `assign_best_pairs` does, with what pods bring that are sent.

        Again and again the pair of order and station with the fewest missing lines for each place that the order takes;
        ties go to the oldest order, then to the station with the lowest load.

        Parameters
        ----------
        sent
            Pods that are sent besides those that are at or bound for stations.
        oldest
            Whether the oldest order goes, to the station where it lacks fewest lines.
        until
            Load of each station from which on it takes no more. Left out: it takes all that fit.
        """
        self.orders.let(self.pods.available(sent))
        mode = self._work.OLDEST if oldest else self._work.CHEAPEST
        stations, load = self.empty.copy(), self._until if until is None else until
        waiting = self._waiting_first(mode, stations, load)
        return [*waiting, *self._fill(mode, NO_NOISE, stations, load)]

    def refilled(self, kept: Chosen, sent: Sent, noise: Ints) -> Chosen:
        """Return the orders that are kept, and more as long as any fits: those that lack least, and by chance more."""
        self.orders.let(self.pods.available(sent))
        stations = self.empty.copy()
        for place, station in kept:
            self.take(place, station, stations)
        return [*kept, *self._fill(self._work.CHEAPEST, noise, stations, self._until)]

    def completed(self, chosen: Chosen, sent: Sent) -> Chosen:
        """Return orders that are chosen besides, oldest first, of which the pods that come have all that is wanted.

        Each goes to the station with the lowest load, of those where that is so.
        """
        self.orders.let(self.pods.available(sent))
        stations, everything, place = self.empty.copy(), list(chosen), -1
        for pair in chosen:
            self.take(*pair, stations)
        limits = stations, self._until, self.placed, self.largest
        while True:
            place, able = self._work.complete(place, *limits, self.orders.kept)
            if place < 0:
                return everything[len(chosen) :]
            for station in sorted(able.nonzero()[0].tolist(), key=lambda at: (stations[1, at] - stations[0, at], at)):
                further = [*everything, (place, station)]
                if self.warehouse.unlimited_stock or self.pods.serve(self.orders, further, sent):
                    self.take(place, station, stations)
                    everything = further
                    break

    def foremost(self, number: int, chosen: Chosen, sent: Sent) -> tuple[Period, list[int]]:
        """Return the same with few orders, and which they are: all, or those that are chosen and that would go first.

        Of these at most as many as said, for each station with free places as many as for the others, with what pods
        bring that are sent. The orders have the places 0, 1, ...
        """
        if self.orders.number <= number:
            places = self.orders.places.tolist()
        else:
            self.orders.let(self.pods.available(sent))
            found = {place for place, _ in chosen}
            taking = np.flatnonzero(self.empty[0] > 0)
            for station in taking.tolist():
                alone = self.empty.copy()
                alone[0] = np.where(np.arange(alone.shape[1]) == station, alone[0], KEPT)
                limits = alone, self._until, self.placed, self.largest
                first = self._work.foremost(number // len(taking), *limits, self.orders.kept).tolist()
                self.orders.taken += first
                found.update(first)
            places = sorted(found)
        lines = [(self.orders.id_of(places[i]), sku, items) for i, sku, items in self.orders.lines_of(places)]
        orders = Lacking()
        orders.begin(self.orders.kept.counted, self.warehouse.n_skus, len(lines))
        orders.join(np.array(lines, np.int64).T.copy())
        few = Period(self.warehouse, orders, self.pods, self.max_wait_s, with_a_place(self.warehouse, orders))
        few.most_items = self.most_items
        return few, places

    def pods_for(self, chosen: Chosen, worth: Ints | None = None) -> Sent:
        """Return few pods that bring what chosen orders lack at their stations, see `Covering.pods_for`."""
        return self.pods.pods_for(self.orders, chosen, worth)

    def take(self, place: int, station: int, stations: Ints) -> None:
        """Let an order be chosen for a station."""
        self._work.take(place, station, stations, self.placed, self.largest, self.orders.kept)
        self.orders.taken.append(place)

    def size_at(self, place: int, station: int) -> int:
        """Return the capacity that an order takes up at a station."""
        return self.warehouse.size_at(self.warehouse.order(self.orders.id_of(place)), self.warehouse.stations[station])

    def late(self) -> Iterator[int]:
        """Yield the orders that have waited too long, oldest first, as `assign_best_pairs` has it."""
        oversize = self.orders.most_items > self.largest
        if self.max_wait_s is None and not oversize:
            return  # nobody's arrival matters
        limit_s, least = (OVERSIZE_WAIT_S, self.largest) if self.max_wait_s is None else (self.max_wait_s, 0)
        for place in self.orders.larger_than(least):
            if self.warehouse.now_s - self.warehouse.order(self.orders.id_of(place)).arrival_s < limit_s:
                return
            yield place

    def cost(self, chosen: Chosen, sent: Sent, weight: float) -> float:
        """Return the objective (1): visits to stations with free places, and ``weight`` for every place left free.

        At a station that counts orders, a free place counts times the items of the largest order.
        """
        stations, free = self.warehouse.stations, [station.free_capacity for station in self.warehouse.stations]
        visits = len(sent) + sum(len(station.inbound_pods) for station in stations if free[station.id])
        for place, station in chosen:
            free[station] -= self.size_at(place, station)
        most = self.most_items
        return visits + weight * sum([free[at.id] * (most if at.counts_orders else 1) for at in stations])

    def decision(self, chosen: Chosen, sent: Sent, weight: float | None = None) -> JointDecision:
        """Return orders and pods as the kernel takes them; with a ``weight``, their cost as well."""
        if not chosen:
            return JointDecision()
        return JointDecision(
            [OrderAssignment(self.orders.id_of(place), station) for place, station in chosen],
            [PodTrip(pod, station) for pod, station in sent],
            None if weight is None else SolveReport("heuristic", self.cost(chosen, sent, weight)),
        )

    def _waiting_first(self, mode: int, stations: Ints, until: NDArray[np.float64]) -> Chosen:
        """Choose the orders that have waited too long; for those that fit nowhere stations are kept."""
        chosen: list[tuple[int, int]] = []
        kept: dict[int, bool] = {}  # stations kept for an order that waits, and whether that is larger than any station
        open_stations = sum(station.open for station in self.warehouse.stations)
        for place in self.late():
            orders = self.orders.kept
            at = self._work.station_for(place, mode, stations, until, self.placed, self.largest, orders)
            if at >= 0:
                self.take(place, at, stations)
                chosen.append((place, at))
            elif self.max_wait_s is not None or not any(kept.values()):
                order = self.warehouse.order(self.orders.id_of(place))
                keep = station_to_keep(self.warehouse, order, dict(enumerate(stations[0].tolist())), kept)
                if keep is not None:
                    kept[keep] = order.open_items > self.largest
                    stations[0, keep] = KEPT
            if len(kept) == open_stations:
                break
        return chosen

    def _fill(self, mode: int, noise: Ints, stations: Ints, until: NDArray[np.float64]) -> list[tuple[int, int]]:
        """Choose orders until nothing fits."""
        pairs = self._work.fill(mode, noise, stations, until, self.placed, self.largest, self.orders.kept).tolist()
        self.orders.taken += [place for place, _ in pairs]
        return [(place, station) for place, station in pairs]


def with_a_place(warehouse: WarehouseView, orders: Lacking) -> Ints:
    """Return the places of orders that have a place at a station that counts orders, and the station, shape (2, n)."""
    if not warehouse.split_orders_open:
        return NO_PAIRS
    pairs = [
        (place, station.id)
        for place in orders.places.tolist()
        for station in warehouse.stations
        if station.counts_orders and warehouse.order(orders.id_of(place)).has_place_at(station.id)
    ]
    return np.array(pairs, np.int64).reshape(-1, 2).T.copy()
