"""Compiled choice of few pods that bring what chosen orders lack; `choosing` says what is decided with it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import helper, njit
from rmfs_core.warehouse import Lines, Stock

Ints = NDArray[np.int64]


class Pods(NamedTuple):
    """The pods, besides their stock.

    Parameters
    ----------
    inbound
        Pods that are at or bound for stations (pod, station), in the order in which stations expect them; int64, shape
        (visits, 2).
    worth
        Of pods that bring as much the one with most goes first, int64, shape (pods,).
    ticks
        Driving times by station and pod, int64, shape (stations, pods).
    """

    inbound: Ints
    worth: Ints
    ticks: Ints


@njit(cache=True, interpreted=True)
def needed(chosen: Ints, stations: int, lines: Lines, stock: Stock) -> tuple[Ints, Ints, Ints]:
    """Return the SKUs that chosen orders (row, station) want, items by station and SKU, and those on pods by SKU."""
    wanted, is_wanted = np.zeros((len(lines.number), stations), np.int64), np.zeros(len(lines.number), np.bool_)
    for pair in range(len(chosen)):
        for line in range(lines.begin[chosen[pair, 0]], lines.begin[chosen[pair, 0] + 1]):
            wanted[lines.sku[line], chosen[pair, 1]] += lines.quantity[line]
            is_wanted[lines.sku[line]] = True
    skus = np.flatnonzero(is_wanted)
    need, held = wanted[skus].T.copy(), np.zeros((len(stock.at), len(skus)), np.int64)
    for column in range(len(skus)):
        for index in range(stock.of_sku[skus[column]], stock.of_sku[skus[column] + 1]):
            held[stock.pod[stock.by_sku[index]], column] = stock.items[stock.by_sku[index]]
    return skus, need, held


@njit(cache=True, interpreted=True)
def deal(held: Ints, need: Ints) -> Ints:
    """Give what a pod has to a station that needs it; return what was given. By SKU."""
    given = np.minimum(held, need)
    held -= given
    need -= given
    return given


@njit(cache=True, interpreted=True)
def bring_all(trips: Ints, without: int, need: Ints, held: Ints) -> bool:
    """Whether pods have what stations need, dealt out in the order of their trips (pod, station), all but one."""
    need, given = need.copy(), np.zeros((len(trips), need.shape[1]), np.int64)
    for trip in range(len(trips)):
        if trip != without:
            given[trip] = deal(held[trips[trip, 0]], need[trips[trip, 1]])
    for trip in range(len(trips)):
        held[trips[trip, 0]] += given[trip]
    return not need.any()


@njit(cache=True, interpreted=True)
def serve(chosen: Ints, sent: Ints, lines: Lines, stock: Stock, pods: Pods) -> bool:
    """Whether pods at, bound for and sent to stations have what chosen orders want, dealt out in this order."""
    _, need, held = needed(chosen, len(pods.ticks), lines, stock)
    return bool(bring_all(np.concatenate((pods.inbound, sent)), -1, need, held))


@helper
def goes_first(pod: int, station: int, than: int, at: int, busy: NDArray[np.bool_], pods: Pods) -> bool:
    """Whether a pod goes to a station rather than another one, which brings as much there, to its own."""
    if busy[pod] != busy[than]:
        return bool(busy[than])
    if pods.worth[pod] != pods.worth[than]:
        return bool(pods.worth[pod] > pods.worth[than])
    if pods.ticks[station, pod] != pods.ticks[at, than]:
        return bool(pods.ticks[station, pod] < pods.ticks[at, than])
    return pod < than or (pod == than and station < at)


@njit(cache=True, interpreted=True)
def next_trip(skus: Ints, need: Ints, held: Ints, busy: NDArray[np.bool_], stock: Stock, pods: Pods) -> tuple[int, int]:
    """Pod and station of which the pod brings most of what the station needs; (-1, -1) if none brings any."""
    most, found, at, gains = 0, -1, -1, np.zeros(pods.ticks.shape, np.int64)
    for station in range(len(need)):
        for column in range(len(skus)):
            if need[station, column] > 0:
                for entry in stock.by_sku[stock.of_sku[skus[column]] : stock.of_sku[skus[column] + 1]]:
                    pod = stock.pod[entry]
                    gains[station, pod] += min(held[pod, column], need[station, column])
        for pod in range(len(held)):
            gain = gains[station, pod]
            if gain > most or (gain == most > 0 and goes_first(pod, station, found, at, busy, pods)):
                most, found, at = gain, pod, station
    return found, at


@njit(cache=True, interpreted=True)
def few(chosen: Ints, lines: Lines, stock: Stock, pods: Pods) -> Ints:
    """Trips (pod, station) that bring chosen orders what inbound pods do not, shape (n, 2)."""
    skus, need, held = needed(chosen, len(pods.ticks), lines, stock)
    left, first = need.copy(), len(pods.inbound)
    trips = np.empty((first + need.sum(), 2), np.int64)
    given, busy, number = np.empty((len(trips), len(skus)), np.int64), np.zeros(len(held), np.bool_), 0
    while number < first or left.any():
        if number < first:
            pod, station = pods.inbound[number]
            busy[pod] = True
        else:
            pod, station = next_trip(skus, left, held, busy, stock, pods)
            assert pod >= 0, "all pods together have enough"
        trips[number, 0], trips[number, 1] = pod, station
        given[number] = deal(held[pod], left[station])
        number += 1
    for trip in range(number):
        held[trips[trip, 0]] += given[trip]
    trip = first
    for _ in range(number - 1 - first):  # the last one brings what no other does
        if bring_all(trips[:number], trip, need, held):
            trips[trip : number - 1] = trips[trip + 1 : number].copy()
            number -= 1
        else:
            trip += 1
    return trips[first:number]
