"""Promises: which free item of which inbound pod is meant for which request.

As soon as a request is open at a station and a pod inbound there holds a free item of its SKU, that item is promised to
the request. A request is covered exactly when something is promised to it. Promises say what is still needed; which pod
serves a request in the end is decided by arrival (`next_request`, `Promises.secure`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rmfs_core.warehouse.parts import UNLIMITED, Pod, Request, Station


class Promises:
    """Makes promises and takes them back, and keeps account of what inbound pods have left.

    Parameters
    ----------
    stations
        By id.
    n_skus
        Number of SKUs.
    """

    def __init__(self, stations: Sequence[Station], n_skus: int) -> None:
        self._stations = stations
        self._shape = (len(stations), n_skus)
        self._available: NDArray[np.int64] | None = None

    @property
    def available(self) -> NDArray[np.int64]:
        """Items on each station's inbound pods that are not promised to any request. Shape (stations, SKUs)."""
        if self._available is None:
            self._available = np.zeros(self._shape, dtype=np.int64)
            for station in self._stations:
                for pod in station._inbound.values():
                    self.count(pod, station, 1)
        return self._available

    def count(self, pod: Pod, station: Station, sign: int) -> None:
        """Take the free items of an inbound pod into the account of what is available, or out of it."""
        if self._available is not None:
            promised, row = pod._promised, self._available[station.id]
            for sku, number in pod._contents.items():
                row[sku] += sign * (pod.free_items(sku) if sku in promised else number)

    def change(self, pod: Pod, sku: int, items: int) -> None:
        """Take note that a pod has more free items, or fewer."""
        if self._available is not None and pod._contents[sku] < UNLIMITED:
            for station in pod._itinerary:
                self._available[station, sku] += items

    def promise(self, request: Request, pod: Pod) -> None:
        """Promise a free item of a pod to a request that is uncovered."""
        promise(request, pod)
        self.change(pod, request.sku, -1)

    def withdraw(self, request: Request, *, picked: bool = False) -> None:
        """Take back what a covered request was promised; ``picked``: its pod has the item no more."""
        pod = request._pod
        assert pod is not None
        request._pod = None
        pod._touched.add((pod, request.sku))
        by_station = pod._promised[request.sku]
        by_station[request.station] -= 1
        if not by_station[request.station]:
            del by_station[request.station]
            if not by_station:
                del pod._promised[request.sku]
        if not picked:
            self.change(pod, request.sku, 1)

    def promise_items(self, pod: Pod, station: Station) -> None:
        """Promise free items of a pod to the uncovered requests of a station, oldest first."""
        for sku in pod._contents:
            for request in station._by_sku.get(sku, {}).values():
                if not request.covered:
                    if pod.free_items(sku) <= 0:
                        break
                    self.promise(request, pod)

    def cover(self, request: Request, tried: set[int] | None = None) -> bool:
        """Promise an item of the first pod that has one free, or can have by what its period assigned elsewhere."""
        sku, pods, tried, station = request.sku, [], tried or set(), self._stations[request.station]
        for pod in station._inbound.values():
            if sku in pod._contents and pod.id not in tried:
                if pod.free_items(sku) > 0:
                    self.promise(request, pod)
                    return True
                pods.append(pod)
        for pod in pods:
            tried.add(pod.id)
            for other in (self._stations[at] for at in pod._itinerary if at != station.id):
                for moved in other._by_sku.get(sku, {}).values():
                    if moved._pod is pod and moved.part.period == request.part.period:
                        self.withdraw(moved)
                        if self.cover(moved, tried):
                            self.promise(request, pod)
                            return True
                        self.promise(moved, pod)
                        break  # the others from here have the same ways out
        return False

    def secure(self, request: Request, pod: Pod) -> None:
        """Make sure that the item for a request is promised from the pod that is about to serve it."""
        if request._pod is pod:
            return
        same_sku = self._stations[request.station]._by_sku[request.sku]
        # The pod's item may be promised to a younger request here: the two swap what they were promised.
        younger = next((other for other in same_sku.values() if other._pod is pod), None)
        if younger is not None:
            younger._pod, request._pod = request._pod, pod
            return
        released = request._pod
        if released is not None:
            self.withdraw(request)
        self.promise(request, pod)
        if released is not None:
            for station in released._itinerary:
                self.promise_items(released, self._stations[station])


def promise(request: Request, pod: Pod) -> None:
    """Promise a free item of a pod to a request that is uncovered, without any account."""
    request._pod = pod
    pod._touched.add((pod, request.sku))
    by_station = pod._promised.setdefault(request.sku, {})
    by_station[request.station] = by_station.get(request.station, 0) + 1


def next_request(station: Station, pod: Pod) -> Request | None:
    """Oldest open request at a station that an item on the pod can serve, not counting items promised elsewhere."""
    best: Request | None = None
    for sku in station._by_sku.keys() & pod._contents.keys():
        first = next(iter(station._by_sku[sku].values()))
        if (best is None or first.id < best.id) and _usable(pod, sku, station.id):
            best = first
    return best


def serves_none(station: Station, pod: Pod) -> bool:
    """Whether `next_request` finds none: not where an item of the pod is promised at the station."""
    for by_station in pod._promised.values():
        if station.id in by_station:
            return False
    return next_request(station, pod) is None


def _usable(pod: Pod, sku: int, station: int) -> bool:
    number, promised = pod._contents[sku], pod._promised.get(sku)
    if number >= UNLIMITED or not promised:
        return number > 0
    return number - sum(promised.values()) + promised.get(station, 0) > 0
