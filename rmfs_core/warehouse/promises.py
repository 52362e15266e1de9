"""Promises: which free item of which inbound pod is meant for which request.

As soon as a request is open at a station and a pod inbound there holds a free item of its SKU, that item is promised to
the request. A request is covered exactly when something is promised to it. Promises say what is still needed; which pod
serves a request in the end is decided by arrival (`next_request`, `Promises.secure`).
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Sequence
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from rmfs_core.warehouse.parts import UNLIMITED, Pod, Request, Station, put

_by_id = attrgetter("id")


class Promises:
    """Makes promises, takes them back, and counts what inbound pods have left.

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
        self.changes = 0
        """How often items were promised, or promises taken back."""

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
        """Add the free items of an inbound pod to what is available, or take them out."""
        if self._available is not None:
            promised, row = pod._promised, self._available[station.id]
            for sku, number in pod._contents.items():
                row[sku] += sign * (pod.free_items(sku) if sku in promised else number)

    def change(self, pod: Pod, sku: int, items: int) -> None:
        """Update what is available where a pod is bound for: it has more free items, or fewer."""
        self.changes += 1
        if self._available is not None and pod._contents[sku] < UNLIMITED:
            for station in pod._itinerary:
                self._available[station, sku] += items

    def promise(self, request: Request, pod: Pod, items: int = 1) -> Request:
        """Promise free items of a pod to the oldest items of an uncovered request; return the request that has them."""
        station = self._stations[request.station]
        _part_off(station, request, items)
        request._pod = pod
        _count_promised(pod, request, items)
        self.change(pod, request.sku, -items)
        return _join(station, request)

    def withdraw(self, request: Request) -> None:
        """Take back what the oldest item of a covered request was promised; the others stay covered."""
        pod = request._pod
        assert pod is not None
        _part_off(self._stations[request.station], request, 1)
        request._pod = None
        _count_promised(pod, request, -1)
        self.change(pod, request.sku, 1)

    def pick(self, request: Request, pod: Pod) -> Request:
        """Let a pod have an item less, the oldest of a request; return the request that it belongs to, as `secure`."""
        request = self.secure(request, pod)
        _count_promised(pod, request, -1)
        return request

    def promise_items(self, pod: Pod, station: Station) -> None:
        """Promise free items of a pod to the uncovered requests of a station, oldest first."""
        for sku in pod._contents:
            for request in [one for one in station._by_sku.get(sku, ()) if one._pod is None]:
                if (free := pod.free_items(sku)) <= 0:
                    break
                self.promise(request, pod, min(free, request._items))

    def cover(self, request: Request, tried: set[int] | None = None) -> bool:
        """Promise items of the first pod that has some free, or one that a pod can have.

        It can have one if what its period assigned elsewhere can be promised from another pod.
        """
        sku, pods, tried, station = request.sku, [], tried or set(), self._stations[request.station]
        for pod in station._inbound.values():
            if sku in pod._contents and pod.id not in tried:
                if (free := pod.free_items(sku)) > 0:
                    self.promise(request, pod, min(free, request._items))
                    return True
                pods.append(pod)
        period = request.part.period
        for pod in pods:
            tried.add(pod.id)
            for other in (self._stations[at] for at in pod._itinerary if at != station.id):
                same_sku = other._by_sku.get(sku, ())
                moved = next((one for one in same_sku if one._pod is pod and one.part.period == period), None)
                if moved is not None:  # the others from here have the same ways out
                    self.withdraw(moved)
                    if self.cover(moved, tried):
                        self.promise(request, pod)
                        return True
                    self.promise(moved, pod)
        return False

    def secure(self, request: Request, pod: Pod) -> Request:
        """Make sure that the oldest item of a request is promised from the pod that is about to serve it.

        Returns
        -------
        Request
            The request that the item belongs to then; that given, where it is the oldest of its SKU at the station.
        """
        if request._pod is pod:
            return request
        station = self._stations[request.station]
        # The pod's item may be promised to a younger request here: the two swap what they were promised.
        younger = next((other for other in station._by_sku[request.sku] if other._pod is pod), None)
        if younger is not None:
            _part_off(station, younger, 1)
            _part_off(station, request, 1)
            younger._pod, request._pod = request._pod, pod
            _join(station, younger)
            return _join(station, request)
        released = request._pod
        if released is not None:
            self.withdraw(request)
        request = self.promise(request, pod)
        if released is not None:
            for at in released._itinerary:
                self.promise_items(released, self._stations[at])
        return request


def _count_promised(pod: Pod, request: Request, items: int) -> None:
    """Count items of a pod that are promised to a request's station, more or fewer."""
    if pod._contents[request.sku] < UNLIMITED:
        pod._touched.add((pod, request.sku))
    by_station = pod._promised.setdefault(request.sku, {})
    by_station[request.station] = by_station.get(request.station, 0) + items
    if not by_station[request.station]:
        del by_station[request.station]
        if not by_station:
            del pod._promised[request.sku]


def enter(station: Station, request: Request) -> None:
    """Put a request among those of its station."""
    for requests in (station._requests, station._by_sku.setdefault(request.sku, [])):
        if requests and requests[-1].id > request.id:
            insort(requests, request, key=_by_id)
        else:
            requests.append(request)


def drop_item(station: Station, request: Request) -> None:
    """Let a request lose its oldest item; it is gone with the last one."""
    if request._items == 1:
        _leave(station, request)
    put(request, "id", request.id + 1)
    request._items -= 1


def _leave(station: Station, request: Request) -> None:
    same_sku = station._by_sku[request.sku]
    for requests in (station._requests, same_sku):
        del requests[0 if requests[0] is request else bisect_left(requests, request.id, key=_by_id)]
    if not same_sku:
        del station._by_sku[request.sku]


def _part_off(station: Station, request: Request, items: int) -> None:
    """Leave a request with so many items, its oldest; the others become a request of their own."""
    if items < request._items:
        rest = Request(request.id + items, request.part, request.sku, request._items - items, request._pod)
        request._items = items
        enter(station, rest)


def _join(station: Station, request: Request) -> Request:
    """Let a request be one with those of its line that come right before and after it, if their pod is the same."""
    same_sku = station._by_sku[request.sku]
    if len(same_sku) == 1:
        return request
    at = bisect_left(same_sku, request.id, key=_by_id)
    for earlier, later in ((at, at + 1), (at - 1, at)):
        if earlier >= 0 and later < len(same_sku):
            one, other = same_sku[earlier], same_sku[later]
            if one._pod is other._pod and one.part is other.part and one.id + one._items == other.id:
                _leave(station, other)
                one._items += other._items
                request = one
    return request


def next_request(station: Station, pod: Pod) -> Request | None:
    """Oldest open request at a station that an item on the pod can serve, not counting items promised elsewhere."""
    best: Request | None = None
    for sku in station._by_sku.keys() & pod._contents.keys():
        first = station._by_sku[sku][0]
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
