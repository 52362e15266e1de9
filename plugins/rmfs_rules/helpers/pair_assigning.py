"""One decision by the scores of pairs that are kept: which orders go to which stations."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_core.decisions import OrderAssignment
from rmfs_rules.helpers.pairs import pod_at, station_to_keep

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView
    from rmfs_rules.helpers.pair_scores import PairScores

Ints = NDArray[np.int64]
Take = Callable[["Station", int], None]
Prefer = Callable[[int, "Station"], int]

NO_LANES = np.zeros((2, 0), np.int64)
"""No pairs of station and order that kept places are for."""


class Assigning:
    """One decision: see `PairScores.assign`."""

    def __init__(
        self,
        scores: PairScores,
        warehouse: WarehouseView,
        take: Take | None,
        prefer: Prefer | None,
        extra: NDArray[np.float64] | None,
        max_wait_s: float | None,
        fast_lane: int,
        key: int,
    ) -> None:
        self.kept, self.warehouse, self.take, self.prefer = scores, warehouse, take, prefer
        self.max_wait_s, self.key = max_wait_s, key
        self.stations = stations = warehouse.stations
        of_stations = [(0, s.free_capacity, s.capacity, s.counts_orders, s.load) for s in stations]
        self.at: Ints = np.array(of_stations, np.int64).T.copy()  # as the search has them
        self.free: Ints = self.at[1]
        self.load: Ints = self.at[4]
        self.extra = np.zeros(len(stations)) if extra is None else extra
        self.lane = _Lane(scores, warehouse, fast_lane) if fast_lane else None
        self.chosen: list[OrderAssignment] = []
        self.places: list[int] = []
        self.drawn: Ints | None = None  # places of orders that go before others as good, by lot
        self.full = False  # whether nothing more can fit

    def done(self) -> list[OrderAssignment]:
        """Decide."""
        try:
            if self.max_wait_s is not None or self.kept.oversize:
                self._assign_waiting()
            while True:
                self.at[0] = self._room()
                lanes = NO_LANES if self.lane is None else self.lane.pairs(self.load, self.free)
                place, at = self.kept._best(self.at, self.extra, lanes, 0)
                if place < 0:
                    return self.chosen
                if self.key:
                    place, at = self._by_lot(place, at, lanes)
                self._assign(place, at if self.prefer is None else self._preferred(place, self._fitting(place)))
                if self.full:
                    return self.chosen
        finally:
            for place in self.places:
                self.kept._taken[place] = False

    def _by_lot(self, place: int, at: int, lanes: Ints) -> tuple[int, int]:
        """Return one of the orders that are as good as the best one, and its station."""
        if self.drawn is None:
            self.drawn = self.kept._draw(self.key, self.warehouse)
        found = self.kept._first_drawn(self.drawn, (place, at), self.at, self.extra, lanes)
        return found if found[0] >= 0 else self.kept._best(self.at, self.extra, lanes, self.key)

    def _room(self) -> Ints:
        """Return how much room stations have for orders that no lane is for."""
        if self.lane is None:
            return self.free
        room: Ints = np.where(self.load > 0, np.maximum(self.free - self.lane.places, 0), self.free)
        return room

    def _size(self, place: int, at: int) -> int:
        items = int(self.kept._orders[1, place])
        return 1 if self.at[3, at] else int(self.at[2, at]) if items > self.kept._largest else items

    def _fitting(self, place: int) -> list[int]:
        """Return the ids of the stations where an order fits."""
        room = self._room()
        return [
            at
            for at in range(len(self.stations))
            if (size := self._size(place, at)) <= room[at]
            or (self.lane is not None and size <= self.free[at] and place in self.lane.completed(at))
        ]

    def _preferred(self, place: int, fitting: list[int]) -> int:
        """Return the station that takes an order, of those where it fits."""
        value = {at: self.kept._score(place, at) + self.extra[at] for at in fitting}
        order, prefer = self.kept.order_at(place), self.prefer

        def key(at: int) -> tuple[int, int, int]:
            return prefer(order, self.stations[at]) if prefer is not None else 0, int(self.load[at]), at

        return min((at for at in fitting if value[at] == max(value.values())), key=key)

    def _assign(self, place: int, at: int) -> None:
        self.chosen.append(OrderAssignment(self.kept.order_at(place), at))
        size = self._size(place, at)
        self.free[at] -= size
        self.load[at] += size
        self.full = max(self.free.tolist()) <= 0
        self.kept._taken[place] = True
        self.places.append(place)
        if self.lane is not None:
            self.lane.take(at, place)
        if self.take is not None and not self.full:
            self.take(self.stations[at], place)

    def _assign_waiting(self) -> None:
        """Assign the orders that have waited too long; for those that fit nowhere stations are kept."""
        kept: dict[int, bool] = {}  # stations kept for an order that waits, and whether that is larger than any station
        open_stations = sum(station.open for station in self.stations)
        for place in self.kept._waiting(self.warehouse, self.max_wait_s):
            if fitting := self._fitting(place):
                self._assign(place, self._preferred(place, fitting))
            elif self.max_wait_s is not None or not any(kept.values()):
                order = self.warehouse.order(self.kept.order_at(place))
                keep = station_to_keep(self.warehouse, order, dict(enumerate(self.free.tolist())), kept)
                if keep is not None:
                    kept[keep] = int(self.kept._orders[1, place]) > self.kept._largest
                    self.free[keep] = 0
            if len(kept) == open_stations:
                break


class _Lane:
    """Orders that the pods which stand at the stations can complete; see `LaneOptions.fast_lane`."""

    def __init__(self, scores: PairScores, warehouse: WarehouseView, places: int) -> None:
        self.kept, self.warehouse, self.places = scores, warehouse, places
        self.pods = {station.id: pod for station in warehouse.stations if (pod := pod_at(warehouse, station))}
        self.left: dict[int, Ints] = {}  # pod -> free items by SKU
        for pod in self.pods.values():
            self.left[pod.id] = np.zeros(warehouse.n_skus, np.int64)
            for sku in pod.contents:
                self.left[pod.id][sku] = pod.free_items(sku)
        self._completed: dict[int, Ints] = {}  # station -> places

    def completed(self, at: int) -> Ints:
        """Return the places of the orders that the pod at a station can complete."""
        if at not in self._completed:
            there = self.pods.get(at)
            self._completed[at] = (
                NO_LANES[0] if there is None else self.kept.completed_at(at, there.id, self.left[there.id])
            )
        return self._completed[at]

    def pairs(self, load: Ints, free: Ints) -> Ints:
        """Return stations and places of the orders for which these stations have the places that they keep."""
        found = [(at, self.completed(at)) for at in np.flatnonzero((load > 0) & (free > 0)).tolist()]
        if not found:
            return NO_LANES
        stations = np.repeat([at for at, _ in found], [len(places) for _, places in found])
        return np.array([stations, np.concatenate([places for _, places in found])])

    def take(self, at: int, place: int) -> None:
        """Take account of an assigned order: pods at or bound for its station may have to serve it."""
        if self.warehouse.unlimited_stock:
            return
        for other, pod in self.pods.items():
            if at in pod.bound_for:
                for sku, items in self.kept.lines_of(place):
                    self.left[pod.id][sku] -= items
                self._completed.pop(other, None)
