"""Pods for the stations that lack one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from heapq import heapify, heappop, heappush
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import UNREACHABLE, far
from rmfs_core.decisions import PodTrip
from rmfs_core.jit import njit
from rmfs_core.warehouse import BUSY, STORED, Stock, stock_of

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, Station, WarehouseView
    from rmfs_core.world.travel import Travel

Ids = NDArray[np.int64]


class ByStock:
    """A rule that looks at what pods hold by functions of this file."""

    def prepare(self, travel: Travel) -> None:  # noqa: ARG002
        """Load what is compiled, or compile it."""
        load()


Wanted = Mapping[int, int]
"""Items by SKU."""


def send(warehouse: WarehouseView, max_fetches: int, choose: Callable[[Stock, Station, Ids], int]) -> list[PodTrip]:
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
        Picks one of the pods (their stock, the station, ids in ascending order), each of which serves an uncovered
        request of the station.

    Returns
    -------
    list[PodTrip]
        The trips in the order in which they were chosen.
    """
    return _send(warehouse, max_fetches, lambda stock, station, pods, _: choose(stock, station, pods))


def _send(
    warehouse: WarehouseView, max_fetches: int, choose: Callable[[Stock, Station, Ids, Wanted], int | None]
) -> list[PodTrip]:
    """Select pods as `send` does; ``choose`` is also given what is still uncovered."""
    lacking = [(station, wanted) for station in warehouse.stations if (wanted := station.uncovered)]
    if not (max_fetches > 0 or any(_serves_one(pod, lacking) for pod in warehouse.leaving_pods)):
        return []
    stock = warehouse.stock
    at = stock.at.copy()  # a pod that is sent is busy from then on
    plain = tuple(stock)
    # Those with the fewest inbound pods, and of these with the most uncovered items, go first
    needy = [(len(one.inbound_pods), -sum(wanted.values()), one.id, wanted) for one, wanted in lacking]
    heapify(needy)
    trips: list[PodTrip] = []
    while needy and (max_fetches > 0 or at.max(initial=BUSY) >= 0):
        inbound, _, identifier, wanted = heappop(needy)
        skus = np.fromiter(wanted, np.int64, len(wanted))
        pods = servers(plain, at, skus, identifier, max_fetches > 0)
        if not len(pods):
            continue
        chosen = choose(stock, warehouse.stations[identifier], pods, MappingProxyType(wanted))
        if chosen is None:
            continue
        pod = warehouse.pods[chosen]
        trips.append(PodTrip(pod.id, identifier))
        for sku in wanted.keys() & pod.contents.keys():
            wanted[sku] -= pod.free_items(sku)
        if wanted := {sku: items for sku, items in wanted.items() if items > 0}:  # only uncovered ones
            heappush(needy, (inbound + 1, -sum(wanted.values()), identifier, wanted))
        max_fetches -= at[pod.id] == STORED
        at[pod.id] = BUSY
    return trips


def _serves_one(pod: Pod, lacking: Sequence[tuple[Station, Wanted]]) -> bool:
    """Whether a pod that leaves a station has what another one lacks."""
    return any(
        sku in pod.contents and pod.free_items(sku) > 0
        for station, wanted in lacking
        if station.id not in pod.bound_for
        for sku in wanted
    )


@njit(cache=True, interpreted=True)
def servers(columns: tuple[Any, ...], at: Ids, skus: Ids, station: int, fetch: bool) -> Ids:
    """Pods that can be sent to a station and have a free item of one of the SKUs, ascending.

    Parameters
    ----------
    columns
        Columns of the pods' `Stock`.
    at
        As `Stock.at`, with what this decision has sent.
    skus
        SKUs of the requests that are uncovered.
    station
        Its id.
    fetch
        Whether stored pods can be sent, besides pods that are about to leave a station.
    """
    stock = Stock(*columns)
    found = np.zeros(len(at), np.bool_)
    for sku in skus:
        for index in range(stock.of_sku[sku], stock.of_sku[sku + 1]):
            entry = stock.by_sku[index]
            pod = stock.pod[entry]
            where = at[pod]
            if stock.items[entry] > 0 and where not in (BUSY, station) and (fetch or where != STORED):
                found[pod] = True
    return np.flatnonzero(found)


def send_pods(
    warehouse: WarehouseView, max_fetches: int, choose: Callable[[Station, Sequence[Pod], Wanted], Pod | None]
) -> list[PodTrip]:
    """Select pods as `send` does, for rules that look at one pod after another.

    `Station.uncovered_requests` is what was uncovered before the decision, and does not change while pods are selected.
    ``choose`` is therefore given what is still uncovered, without the items of pods that were selected before.

    Parameters
    ----------
    warehouse
        The warehouse now.
    max_fetches
        How many stored pods may be sent.
    choose
        Picks one of the pods for a station: it is given the station, the pods, by ascending id, each of which serves an
        uncovered request of it, and the items that are still uncovered there, by SKU. None: the station gets no further
        pod in this decision.

    Returns
    -------
    list[PodTrip]
        The trips in the order in which they were chosen.
    """
    pods = warehouse.pods

    def by_id(_: Stock, station: Station, found: Ids, wanted: Wanted) -> int | None:
        pod = choose(station, [pods[pod] for pod in found.tolist()], wanted)
        return None if pod is None else pod.id

    return _send(warehouse, max_fetches, by_id)


def worth(stock: Stock, pods: Ids, wanted: Ids) -> Ids:
    """Return of each pod the sum over its SKUs of min(free items, items wanted), int64, shape (pods,).

    Parameters
    ----------
    stock
        The pods.
    pods
        Some of them, by id.
    wanted
        Items wanted by SKU, shape (n_skus,).
    """
    sums: Ids = add_up_wanted(stock.of_pod, stock.sku, stock.items, pods, wanted)
    return sums


@njit(cache=True, interpreted=True)
def add_up_wanted(of_pod: Ids, sku: Ids, items: Ids, pods: Ids, wanted: Ids) -> Ids:
    """Do what `worth` says; of `Stock` it takes what it reads."""
    sums = np.zeros(len(pods), np.int64)
    for i in range(len(pods)):
        for entry in range(of_pod[pods[i]], of_pod[pods[i] + 1]):
            sums[i] += min(items[entry], wanted[sku[entry]])
    return sums


def held(stock: Stock, values: Ids) -> Ids:
    """Return of all pods the sum of values by SKU, whole numbers, over the SKUs that each has free, shape (pods,)."""
    sums: Ids = add_up_held(stock.of_pod, stock.sku, stock.items, values)
    return sums


@njit(cache=True, interpreted=True)
def add_up_held(of_pod: Ids, sku: Ids, items: Ids, values: Ids) -> Ids:
    """Do what `held` says; of `Stock` it takes what it reads."""
    sums = np.zeros(len(of_pod) - 1, np.int64)
    for pod in range(len(sums)):
        for entry in range(of_pod[pod], of_pod[pod + 1]):
            if items[entry] > 0:
                sums[pod] += values[sku[entry]]
    return sums


def load() -> None:
    """Load what is compiled, or compile it, by a decision without pods."""
    stock, none, one = stock_of((), 1), np.zeros(0, np.int64), np.zeros(1, np.int64)
    servers(tuple(stock), none, one, 0, True)
    worth(stock, none, one)
    held(stock, one)


def ticks_from(warehouse: WarehouseView, cells: Ids, station: Station) -> Ids:
    """Return the shortest loaded driving times from cells to a station, whatever way robots will face."""
    table = warehouse.travel.ways_to(station.cell, True)
    ticks = table[cells].min(axis=1).astype(np.int64)
    return np.where(ticks < far(table), ticks, UNREACHABLE)


def nearest(warehouse: WarehouseView, stock: Stock, pods: Ids, station: Station) -> int:
    """Return the pod that can be sent with the shortest loaded driving time to a station; ties: the lowest id.

    Parameters
    ----------
    warehouse
        The warehouse now.
    stock
        Its pods.
    pods
        Pods that can be sent, by ascending id, one at least.
    station
        Where it is sent.
    """
    if len(pods) == 1:  # only ties need driving times
        return int(pods[0])
    table = warehouse.travel.ways_to(station.cell, True)
    ticks = table[stock.cell[pods]].min(axis=1)
    at = int(ticks.argmin())
    return int(pods[at if ticks[at] < far(table) else 0])
