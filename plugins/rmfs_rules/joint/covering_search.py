"""Compiled choice of few pods that bring what stations need; `covering` says what the arrays are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import inlined, njit

ENDLESS = 1 << 40
"""Items of a SKU on all pods together where the stock is unlimited."""


class PodArrays(NamedTuple):
    """What is kept of the pods.

    Parameters
    ----------
    pod, number, by_sku, first
        Free items by entry, entries by SKU and pod, and where those of each SKU begin.
    used, gains, busy
        Zeros, and so again after each call: by entry, by station and pod, and by pod.
    ticks, cells
        Driving times by station and cell, and the cell of each pod.
    worth
        By pod, what else speaks for it.
    """

    pod: NDArray[np.int64]
    number: NDArray[np.int64]
    by_sku: NDArray[np.int64]
    first: NDArray[np.int64]
    used: NDArray[np.int64]
    gains: NDArray[np.int64]
    busy: NDArray[np.bool_]
    ticks: NDArray[np.int64]
    cells: NDArray[np.int64]
    worth: NDArray[np.int64]


@inlined
def entry_of(pod, sku, pods):
    """Entry of a SKU of a pod; -1 if it never held it."""
    low, high = pods.first[sku], pods.first[sku + 1]
    while low < high:
        middle = (low + high) // 2
        if pods.pod[pods.by_sku[middle]] < pod:
            low = middle + 1
        else:
            high = middle
    if low < pods.first[sku + 1] and pods.pod[pods.by_sku[low]] == pod:
        return pods.by_sku[low]
    return np.int64(-1)


@inlined
def deal(pod, station, skus, need, pods):
    """Give what a pod has to a station that needs it."""
    for column in range(len(skus)):
        if need[station, column] > 0:
            entry = entry_of(pod, skus[column], pods)
            if entry >= 0:
                given = min(pods.number[entry] - pods.used[entry], need[station, column])
                pods.used[entry] += given
                need[station, column] -= given


@inlined
def take_back(trips, skus, pods):
    """Let pods have again what they have given."""
    for trip in range(len(trips)):
        for column in range(len(skus)):
            entry = entry_of(trips[trip, 0], skus[column], pods)
            if entry >= 0:
                pods.used[entry] = 0


@njit(cache=True)
def serve(trips, without, skus, need, pods):
    """Whether pods have what stations need, dealt out in the order of their trips (pod, station), all but one."""
    left = need.copy()
    for trip in range(len(trips)):
        if trip != without:
            deal(trips[trip, 0], trips[trip, 1], skus, left, pods)
    take_back(trips, skus, pods)
    return not left.any()


@inlined
def goes_first(pod, station, than, at, pods):
    """Whether a pod goes to a station rather than another one, which brings as much there, to its own."""
    if pods.busy[pod] != pods.busy[than]:
        return pods.busy[than]
    if pods.worth[pod] != pods.worth[than]:
        return pods.worth[pod] > pods.worth[than]
    ticks, others = pods.ticks[station, pods.cells[pod]], pods.ticks[at, pods.cells[than]]
    if ticks != others:
        return ticks < others
    return pod < than or (pod == than and station < at)


@inlined
def next_trip(skus, need, pods):
    """Pod and station of which the pod brings most of what the station needs; (-1, -1) if none brings any."""
    for station in range(len(need)):
        for column in range(len(skus)):
            if need[station, column] > 0:
                for place in range(pods.first[skus[column]], pods.first[skus[column] + 1]):
                    entry = pods.by_sku[place]
                    brought = min(pods.number[entry] - pods.used[entry], need[station, column])
                    pods.gains[station, pods.pod[entry]] += brought
    most, found, at = np.int64(0), np.int64(-1), -1
    for station in range(len(need)):
        for column in range(len(skus)):
            if need[station, column] > 0:
                for place in range(pods.first[skus[column]], pods.first[skus[column] + 1]):
                    pod = pods.pod[pods.by_sku[place]]
                    gain = pods.gains[station, pod]
                    pods.gains[station, pod] = 0
                    if gain > most or (gain == most > 0 and goes_first(pod, station, found, at, pods)):
                        most, found, at = gain, pod, station
    return found, at


@njit(cache=True)
def few(inbound, skus, need, pods):
    """Trips (pod, station) that bring stations what inbound pods do not, shape (n, 2); and whether they bring all."""
    left, number = need.copy(), len(inbound)
    trips = np.empty((number + need.sum(), 2), np.int64)
    for trip in range(number):
        trips[trip, 0], trips[trip, 1] = inbound[trip, 0], inbound[trip, 1]
        pods.busy[inbound[trip, 0]] = True
        deal(trips[trip, 0], trips[trip, 1], skus, left, pods)
    while left.any():
        pod, station = next_trip(skus, left, pods)
        if pod < 0:
            break
        trips[number, 0], trips[number, 1] = pod, station
        number += 1
        deal(pod, station, skus, left, pods)
    take_back(trips[:number], skus, pods)
    for trip in range(len(inbound)):
        pods.busy[inbound[trip, 0]] = False
    if left.any():
        return trips[len(inbound) : number], False
    trip = len(inbound)
    for _ in range(number - 1 - len(inbound)):  # the last one brings what no other does
        if serve(trips[:number], trip, skus, need, pods):
            for later in range(trip + 1, number):
                trips[later - 1, 0], trips[later - 1, 1] = trips[later, 0], trips[later, 1]
            number -= 1
        else:
            trip += 1
    return trips[len(inbound) : number], True
