"""Pods for the stations that lack one, and what is kept of pods from call to call: what did not change is not read."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from heapq import heapify, heappop, heappush
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import UNREACHABLE, far
from rmfs_core.decisions import PodTrip
from rmfs_rules.helpers.sending import send

if TYPE_CHECKING:
    from rmfs_core.warehouse import FreeItems, FreeItemsLog, Pod, Request, Station, WarehouseView

Ids = NDArray[np.int64]
Find = Callable[["Station", Collection[int], bool], Ids]

STORED, BUSY = -1, -2
"""Where a pod may leave from: its storage location, or nowhere; else the id of the station that it leaves."""
ENOUGH = 1 << 40
"""More than any value of a SKU."""


def send_pods(
    warehouse: WarehouseView, max_fetches: int, choose: Callable[[Station, Sequence[Pod]], Pod]
) -> list[PodTrip]:
    """Select pods one after another until every uncovered request is served or no candidate can help.

    The station with the fewest inbound pods is next, then the one with most uncovered requests, then the lowest id:
    robots are scarce, and a station without pods idles. Candidates are stored pods bound nowhere, at most
    ``max_fetches`` of them, and pods that are about to leave a station.

    Parameters
    ----------
    warehouse
        The warehouse now.
    max_fetches
        How many stored pods may be sent.
    choose
        Picks one of the pods, given by id, each of which serves an uncovered request of the station.

    Returns
    -------
    list[PodTrip]
        The trips in the order in which they were chosen.
    """
    return send(
        warehouse, max_fetches, lambda station, pods: choose(station, [warehouse.pods[pod] for pod in pods.tolist()]).id
    )


def _send(
    warehouse: WarehouseView,
    max_fetches: int,
    leaving: set[int],
    servers: Find,
    choose: Callable[[Station, Ids], int],
) -> list[PodTrip]:
    """Select pods as `send_pods` says; ``servers`` finds those that can be sent, ``choose`` picks one, all by id.

    Those that are sent are no longer ``leaving``.
    """
    needy = [  # those with the fewest inbound pods, and of these with the most uncovered requests, go first
        (len(station.inbound_pods), -len(uncovered), station.id)
        for station in warehouse.stations
        if (uncovered := station.uncovered_requests)
    ]
    heapify(needy)
    lacking: dict[int, dict[int, int]] = {}  # requests of each SKU that are still uncovered, by station
    trips: list[PodTrip] = []
    while needy and (max_fetches > 0 or leaving):
        inbound, _, identifier = heappop(needy)
        station = warehouse.stations[identifier]
        wanted = lacking.get(identifier) or _by_sku(station.uncovered_requests)
        candidates = servers(station, wanted, max_fetches > 0)
        if not len(candidates):
            continue
        pod = warehouse.pods[choose(station, candidates)]
        trips.append(PodTrip(pod.id, identifier))
        for sku in wanted.keys() & pod.contents.keys():
            wanted[sku] -= pod.free_items(sku)
            if wanted[sku] <= 0:
                del wanted[sku]
        if wanted:
            lacking[identifier] = wanted
            heappush(needy, (inbound + 1, -sum(wanted.values()), identifier))
        if pod.id in leaving:
            leaving.remove(pod.id)
        else:
            max_fetches -= 1
    return trips


def _by_sku(requests: Iterable[Request]) -> dict[int, int]:
    """Return how many requests there are of each SKU."""
    number: dict[int, int] = {}
    for request in requests:
        number[request.sku] = number.get(request.sku, 0) + 1
    return number


class KeptPods:
    """Which pods can be sent, where they are and what they have free: each update reads of those that changed alone.

    Attributes
    ----------
    log
        Free items of the pods, and what changed of them.
    cells
        Cell of each pod that can be sent, int64, shape (pods,).
    places
        Storage location of each pod, -1 of those that are not stored, int64, shape (pods,).
    changed
        Of the pods that can be sent, those that may have changed since the last update or since they could be last.
    """

    def __init__(self) -> None:
        self._pods: tuple[Pod, ...] = ()
        self.log: FreeItemsLog | None = None
        self.changed: list[Pod] = []

    def load(self) -> None:
        """Load what is compiled, or compile it."""
        from rmfs_rules.helpers import pod_search  # compiled: imported when needed, for it takes its time

        one = np.ones(1, np.int64)
        one.setflags(write=False)  # as what the log shows
        none, at = np.zeros((3, 1), np.int64), one.copy()
        pod_search.highest(at, at)
        pod_search.servers(none[0, :0], none[1], none[2], one, one, at, 0, 0, np.zeros(1, np.bool_))
        pod_search.items_on(none[0, :0], none[0, :0], none[1], none[2], one, one, at)
        pod_search.with_most(none[0, :0], none[0, :0], none[1], none[2], one, one, at, STORED, at)

    def update(self, warehouse: WarehouseView) -> None:
        """Take in what pods have become."""
        if warehouse.pods is not self._pods:
            from rmfs_rules.helpers import pod_search

            self._search: Any = pod_search
            self._pods = warehouse.pods
            self._seen, self._again = 0, list(range(len(self._pods)))
            self.cells, self.places = np.zeros((2, len(self._pods)), np.int64)
            self._at, self._found = np.zeros_like(self.cells), np.zeros(len(self._pods), np.bool_)
            self._ticks: dict[int, Ids] = {}
            self._row, self._sums = np.full_like(self.cells, -1), np.zeros_like(self.cells)
        log = warehouse.free_items_log()  # its items are read when they are needed: some rules need none
        if log is not self.log:
            self.log, self._skus = log, np.arange(warehouse.n_skus + 1)
            self._by_sku: tuple[Ids, Ids] | None = None
        changed = warehouse.changed_pods(self._seen)
        self._seen += len(changed)
        self.changed, again, self._again = [], self._again, []
        for number in {*changed, *again}:
            pod = self._pods[number]
            self.places[number] = -1 if (location := pod.location) is None else location
            if location is None or pod.bound_for:
                self._at[number] = BUSY
                continue
            self._at[number], self.cells[number] = STORED, pod.cell
            self.changed.append(pod)
            if pod.robot is not None:  # which is on its way to move it
                self._again.append(number)
        leaving = warehouse.leaving_pods
        for pod in leaving:
            self._at[pod.id], self.cells[pod.id] = pod.bound_for[0], pod.cell
        self._leaving = {pod.id for pod in leaving}
        self._again += self._leaving
        self.changed += leaving

    def highest(self, pods: Ids, values: Ids) -> Ids:
        """Return those of some pods, one at least, with the highest of values by pod."""
        best: Ids = self._search.highest(pods, values)
        return best

    def items_on(self, pods: Ids, skus: Ids) -> Ids:
        """Return the free items of SKUs on pods, int64, shape (pods, SKUs)."""
        free = self.items
        items: Ids = self._search.items_on(pods, skus, self.by_sku, self.first, free.pod, free.number, self._row)
        return items

    @property
    def items(self) -> FreeItems:
        """Free items of the pods as they are."""
        assert self.log is not None
        return self.log.items

    @property
    def by_sku(self) -> Ids:
        """Entries of ``items`` by SKU and pod, shape (entries,)."""
        return self._sorted()[0]

    @property
    def first(self) -> Ids:
        """Where those of each SKU begin in ``by_sku``, shape (SKUs + 1,)."""
        return self._sorted()[1]

    def _sorted(self) -> tuple[Ids, Ids]:
        """Sort the entries by SKU when that is needed, and put in those that are new."""
        items = self.items
        if self._by_sku is None:
            by_sku = np.lexsort((items.pod, items.sku))
            self._by_sku = by_sku, np.searchsorted(items.sku[by_sku], self._skus)
        for entry in range(len(self._by_sku[0]), len(items.sku)):
            by_sku, first = self._by_sku
            sku = int(items.sku[entry])
            begin, end = first[sku : sku + 2].tolist()
            at = begin + int(items.pod[by_sku[begin:end]].searchsorted(items.pod[entry]))
            first[sku + 1 :] += 1
            self._by_sku = np.insert(by_sku, at, entry), first
        return self._by_sku

    def entries_of(self, pods: Ids) -> tuple[Ids, Ids]:
        """Return the entries of ``items`` of some pods, given by ascending id, and which of them has each.

        They are sorted by pod and SKU. Shape (entries of these pods,), twice.
        """
        assert self.log is not None
        items, ordered = self.items, self.log.ordered
        first, end = (items.pod[:ordered].searchsorted(pods, side=side) for side in ("left", "right"))
        number = end - first
        rank = np.repeat(np.arange(len(pods)), number)
        entries = np.arange(len(rank)) + np.repeat(first - np.cumsum(number) + number, number)
        given = ordered + np.flatnonzero(np.isin(items.pod[ordered:], pods))  # SKUs that pods were given later
        if len(given):
            rank = np.concatenate([rank, pods.searchsorted(items.pod[given])])
            entries = np.concatenate([entries, given])
            order = np.lexsort((items.sku[entries], rank))
            rank, entries = rank[order], entries[order]
        return entries, rank

    @property
    def stored(self) -> NDArray[np.bool_]:
        """Whether each pod is stored and bound nowhere, shape (pods,)."""
        stored: NDArray[np.bool_] = self._at == STORED
        return stored

    @property
    def movable(self) -> NDArray[np.bool_]:
        """Whether each pod is stored, bound nowhere, and fetched by nobody, shape (pods,)."""
        movable = self.stored
        for number in self._again:
            movable[number] &= self._pods[number].robot is None
        return movable

    def with_most(self, wanted: Iterable[tuple[int, int]]) -> Ids:
        """Return the stored pods bound nowhere with most free items of what is wanted, SKUs and numbers, if any."""
        skus, items = np.array(list(wanted), np.int64).reshape(-1, 2).T.copy()
        pods: Ids = self._search.with_most(
            skus, items, self.by_sku, self.first, self.items.pod, self.items.number, self._at, STORED, self._sums
        )
        return pods

    def ticks_from(self, warehouse: WarehouseView, station: Station) -> Ids:
        """Return the shortest loaded driving times to a station from all cells, int64, shape (cells,)."""
        if station.id not in self._ticks:
            table = warehouse.travel.ways_to(station.cell, True)
            ticks = table.min(axis=1).astype(np.int64)
            self._ticks[station.id] = np.where(ticks < far(table), ticks, UNREACHABLE)
        return self._ticks[station.id]

    def ticks(self, warehouse: WarehouseView, pods: Ids, station: Station) -> Ids:
        """Return `ticks_to_station` of pods that can be sent, int64, of the shape of ``pods``."""
        return self.ticks_from(warehouse, station)[self.cells[pods]]

    def send(self, warehouse: WarehouseView, max_fetches: int, choose: Callable[[Station, Ids], int]) -> list[PodTrip]:
        """Select pods as `send_pods` does, after an update; ``choose`` picks one of ids in ascending order."""

        def servers(station: Station, skus: Collection[int], fetch: bool) -> Ids:
            found: Ids = self._search.servers(
                np.fromiter(skus, np.int64, len(skus)), self.by_sku, self.first, self.items.pod, self.items.number,
                self._at, station.id, STORED if fetch else 0, self._found,
            )  # fmt: skip
            return found

        def best(station: Station, pods: Ids) -> int:
            pod = choose(station, pods)
            self._at[pod] = BUSY
            self._again.append(pod)
            return pod

        return _send(warehouse, max_fetches, self._leaving.copy(), servers, best)


class KeptSums:
    """Of each pod, the sum over its SKUs of min(items on it, items wanted), changed where either changes."""

    def __init__(self) -> None:
        self._of: object = None
        self._seen = 0

    def load(self) -> None:
        """Load what is compiled, or compile it."""
        from rmfs_rules.helpers import pod_search  # see there

        one = np.zeros(1, np.int64)
        shown = one.copy()
        shown.setflags(write=False)
        pod_search.change_sums(one, one, one, one, np.array([0, 1]), shown, shown, one, one, one)

    def update(self, pods: KeptPods, entries: Ids, items: Ids, wanted: Ids) -> Ids:
        """Take in what changed; return the sums, int64, shape (pods,).

        Parameters
        ----------
        pods
            What is kept of the pods.
        entries
            Entries of ``pods.items`` of which the number of items has changed since the last update, in any order; at
            first all.
        items
            How many there are of each of these now.
        wanted
            Items wanted, by SKU.
        """
        if self._of is not pods.log:
            self._of, self._known, self._wanted = pods.log, np.zeros(len(pods.by_sku), np.int64), wanted.copy()
            self._sums = np.zeros(len(pods.cells), np.int64)
        if (more := len(pods.by_sku) - len(self._known)) > 0:  # pods were given SKUs that they never held
            self._known = np.concatenate([self._known, np.zeros(more + len(self._known), np.int64)])
        pods._search.change_sums(
            entries, items, wanted, pods.by_sku, pods.first, pods.items.pod, pods.items.sku, self._known, self._wanted,
            self._sums,
        )  # fmt: skip
        return self._sums

    def of_free(self, pods: KeptPods, wanted: Ids) -> Ids:
        """Take in what pods have free and what is wanted now, by SKU; return the sums, int64, shape (pods,)."""
        entries = self._changed(pods)
        return self.update(pods, entries, pods.items.number[entries], wanted)

    def of_held(self, pods: KeptPods, values: Ids) -> Ids:
        """Take in what pods have free, and values (>= 0) by SKU; return the sums over the SKUs that each has free."""
        entries = self._changed(pods)
        return self.update(pods, entries, np.where(pods.items.number[entries] > 0, ENOUGH, 0), values)

    def _changed(self, pods: KeptPods) -> Ids:
        """Return the entries that changed since this was asked last."""
        assert pods.log is not None
        since = self._seen if self._of is pods.log else 0
        entries = pods.log.changed(since)
        self._seen = since + len(entries)
        return entries
