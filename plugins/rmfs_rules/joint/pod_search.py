"""Compiled choice of few pods that bring what chosen orders lack; `choosing` says what is decided with it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import inlined, njit

if TYPE_CHECKING:
    from rmfs_core.warehouse import Lines, Stock

Ints = NDArray[np.int64]


class Pods(NamedTuple):
    """What is known of pods besides their stock.

    Parameters
    ----------
    inbound
        Pods that are at or bound for stations (pod, station), in the order in which stations expect them; int64, shape
        (visits, 2).
    wanted
        Items wanted by SKU, of which pods that have many go first; int64, shape (n_skus,), or (0,): never mind.
    ticks
        Driving times by station and pod, int64, shape (stations, pods).
    used, gains, busy
        For work: zeros, and so again after each call. By entry of the stock, by station and pod, and by pod.
    """

    inbound: Ints
    wanted: Ints
    ticks: Ints
    used: Ints
    gains: Ints
    busy: NDArray[np.bool_]


@inlined
def entry_of(pod: int, sku: int, stock: Stock) -> int:
    """Entry of a SKU of a pod; -1 if it never held it."""
    low, end = stock.of_pod[pod], stock.of_pod[pod + 1]
    high = end
    while low < high:
        middle = (low + high) // 2
        if stock.sku[middle] < sku:
            low = middle + 1
        else:
            high = middle
    return int(low) if low < end and stock.sku[low] == sku else -1


@njit(cache=True)
def needed(chosen: Ints, lines: Lines, stations: int) -> tuple[Ints, Ints]:
    """Return the SKUs that chosen orders (place, station) want, and the items by station and SKU, in this order."""
    number = 0
    for pair in range(len(chosen)):
        number += lines.begin[chosen[pair, 0] + 1] - lines.begin[chosen[pair, 0]]
    skus, need, number = np.empty(number, np.int64), np.zeros((stations, number), np.int64), 0
    for pair in range(len(chosen)):
        for line in range(lines.begin[chosen[pair, 0]], lines.begin[chosen[pair, 0] + 1]):
            if lines.quantity[line] > 0:
                column = 0
                while column < number and skus[column] != lines.sku[line]:
                    column += 1
                if column == number:
                    skus[column] = lines.sku[line]
                    number += 1
                need[chosen[pair, 1], column] += lines.quantity[line]
    return skus[:number], need[:, :number].copy()


@njit(cache=True)
def deal(pod: int, station: int, skus: Ints, need: Ints, stock: Stock, pods: Pods) -> None:
    """Give what a pod has to a station that needs it."""
    for column in range(len(skus)):
        if need[station, column] > 0:
            entry = entry_of(pod, skus[column], stock)
            if entry >= 0:
                given = min(stock.items[entry] - pods.used[entry], need[station, column])
                pods.used[entry] += given
                need[station, column] -= given


@njit(cache=True)
def take_back(trips: Ints, skus: Ints, stock: Stock, pods: Pods) -> None:
    """Let pods have again what they have given."""
    for trip in range(len(trips)):
        for column in range(len(skus)):
            entry = entry_of(trips[trip, 0], skus[column], stock)
            if entry >= 0:
                pods.used[entry] = 0


@njit(cache=True)
def bring_all(trips: Ints, without: int, skus: Ints, need: Ints, stock: Stock, pods: Pods) -> bool:
    """Whether pods have what stations need, dealt out in the order of their trips (pod, station), all but one."""
    left = need.copy()
    for trip in range(len(trips)):
        if trip != without:
            deal(trips[trip, 0], trips[trip, 1], skus, left, stock, pods)
    take_back(trips, skus, stock, pods)
    return not bool(left.any())


@njit(cache=True)
def serve(chosen: Ints, sent: Ints, lines: Lines, stock: Stock, pods: Pods) -> bool:
    """Whether pods at, bound for and sent to stations have what chosen orders want, dealt out in this order."""
    skus, need = needed(chosen, lines, len(pods.ticks))
    return bool(bring_all(np.concatenate((pods.inbound, sent)), -1, skus, need, stock, pods))


@inlined
def worth_of(pod: int, stock: Stock, wanted: Ints) -> int:
    """Items on a pod that are wanted."""
    worth = 0
    if len(wanted):
        for entry in range(stock.of_pod[pod], stock.of_pod[pod + 1]):
            worth += min(stock.items[entry], wanted[stock.sku[entry]])
    return worth


@inlined
def goes_first(pod: int, station: int, than: int, at: int, stock: Stock, pods: Pods) -> bool:
    """Whether a pod goes to a station rather than another one, which brings as much there, to its own."""
    if pods.busy[pod] != pods.busy[than]:
        return bool(pods.busy[than])
    worth, other = worth_of(pod, stock, pods.wanted), worth_of(than, stock, pods.wanted)
    if worth != other:
        return bool(worth > other)
    if pods.ticks[station, pod] != pods.ticks[at, than]:
        return bool(pods.ticks[station, pod] < pods.ticks[at, than])
    return pod < than or (pod == than and station < at)


@njit(cache=True)
def next_trip(skus: Ints, need: Ints, stock: Stock, pods: Pods) -> tuple[np.int64, int]:
    """Pod and station of which the pod brings most of what the station needs; (-1, -1) if none brings any."""
    for station in range(len(need)):
        for column in range(len(skus)):
            if need[station, column] > 0:
                for place in range(stock.of_sku[skus[column]], stock.of_sku[skus[column] + 1]):
                    entry = stock.by_sku[place]
                    brought = min(stock.items[entry] - pods.used[entry], need[station, column])
                    pods.gains[station, stock.pod[entry]] += brought
    most, found, at = np.int64(0), np.int64(-1), -1
    for station in range(len(need)):
        for column in range(len(skus)):
            if need[station, column] > 0:
                for place in range(stock.of_sku[skus[column]], stock.of_sku[skus[column] + 1]):
                    pod = stock.pod[stock.by_sku[place]]
                    gain = pods.gains[station, pod]
                    pods.gains[station, pod] = 0
                    if gain > most or (gain == most > 0 and goes_first(pod, station, found, at, stock, pods)):
                        most, found, at = gain, pod, station
    return found, at


@njit(cache=True)
def few(chosen: Ints, lines: Lines, stock: Stock, pods: Pods) -> tuple[Ints, bool]:
    """Trips (pod, station) that bring chosen orders what inbound pods do not, shape (n, 2); whether they bring all."""
    skus, need = needed(chosen, lines, len(pods.ticks))
    left, first = need.copy(), len(pods.inbound)
    number, trips = first, np.empty((first + need.sum(), 2), np.int64)
    trips[:first] = pods.inbound
    for trip in range(first):
        pods.busy[trips[trip, 0]] = True
        deal(trips[trip, 0], trips[trip, 1], skus, left, stock, pods)
    while left.any():
        pod, station = next_trip(skus, left, stock, pods)
        if pod < 0:
            break
        trips[number, 0], trips[number, 1] = pod, station
        number += 1
        deal(pod, station, skus, left, stock, pods)
    take_back(trips[:number], skus, stock, pods)
    for trip in range(first):
        pods.busy[trips[trip, 0]] = False
    trip = first
    for _ in range(number - 1 - first):  # the last one brings what no other does
        if not left.any() and bring_all(trips[:number], trip, skus, need, stock, pods):
            for later in range(trip + 1, number):
                trips[later - 1, 0], trips[later - 1, 1] = trips[later, 0], trips[later, 1]
            number -= 1
        else:
            trip += 1
    return trips[first:number], not left.any()
