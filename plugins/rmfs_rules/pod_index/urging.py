"""Which pods are wanted enough to be sent, compiled: the ages of the lines that they have items for, added up."""

from __future__ import annotations

import numpy as np

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.jit import njit
from rmfs_core.warehouse import Lines, Stock
from rmfs_rules.pod_index.period import AT_WORK, Ints, Period, Stations, Weights

NEVER = 1 << 62
"""Ages never add up to so many ticks."""


@njit(cache=True)
def count_lines(lines: Lines, stock: Stock) -> tuple[Ints, Ints, Ints]:
    """Count the open lines that pods have items for.

    Returns
    -------
    The SKUs with open lines; by pod, how many of them it has items for, and the ticks at which their orders arrived,
    added up.
    """
    wanted = np.flatnonzero(lines.number)
    number, arrivals = np.zeros_like(stock.at), np.zeros_like(stock.at)
    for sku in wanted:
        first, of_sku, since = lines.first[sku], lines.number[sku], 0
        for at in range(first, first + of_sku):
            since += int(lines.arrival_s[lines.listed_order[at]] * TICKS_PER_S + 0.5)
        for k in range(stock.of_sku[sku], stock.of_sku[sku + 1]):
            entry = stock.by_sku[k]
            if stock.items[entry] > 0:
                number[stock.pod[entry]] += of_sku
                arrivals[stock.pod[entry]] += since
    return wanted, number, arrivals


@njit(cache=True)
def needed(load: int, capacity: int, weights: Weights) -> int:
    """Return ticks that ages add up to before a pod is sent to a station of which so many places are taken."""
    return int(weights.urge_ticks * (1 + (weights.full - 1) * min(load, capacity) / capacity))


@njit(cache=True)
def least_needed(stations: Stations, weights: Weights) -> int:
    """Return the least of what is needed at the stations that take another pod, `NEVER` where none does."""
    least = NEVER
    for i in range(len(stations.room)):
        if stations.room[i] and stations.inbound[i] < weights.most_pods:
            least = min(least, needed(stations.load[i], stations.capacity[i], weights))
    return least


@njit(cache=True)
def next_urgent(lines: Lines, stock: Stock, weights: Weights, told: Ints, now: int) -> int:
    """Return when the ages of the lines of the next pod add up to enough, `NEVER` for never.

    Of pods whose ages do not now, where pods wait. ``told`` has the rows of `Stations`.
    """
    need, soonest = least_needed(Stations(told[0], told[1], told[2], told[3], told[4], told[5]), weights), NEVER
    if need == NEVER or not weights.urge_ticks:
        return soonest
    _, number, arrivals = count_lines(lines, stock)
    for pod in range(len(number)):
        missing = need - number[pod] * (now + weights.base_ticks) + arrivals[pod]
        if number[pod] and missing > 0:
            soonest = min(soonest, now - (-missing // number[pod]))
    return soonest


@njit(cache=True)
def change_urges(p: Period, sku: int, order: int) -> None:
    """Take the age of a line from the urges of the pods that have items for it."""
    age = p.now + p.weights.base_ticks - int(p.lines.arrival_s[order] * TICKS_PER_S + 0.5)
    for k in range(p.stock.of_sku[sku], p.stock.of_sku[sku + 1]):
        entry = p.stock.by_sku[k]
        if p.stock.items[entry] > 0:
            p.pods.urge[p.stock.pod[entry]] -= age


@njit(cache=True)
def find_able(p: Period, station: int) -> bool:
    """Mark the pods that may be sent to a station: movable, and wanted enough where it matters; return whether any."""
    waits, some = p.numbers[AT_WORK] and p.weights.urge_ticks, False
    need = needed(p.stations.load[station], p.stations.capacity[station], p.weights) if waits else 0
    for pod in p.pods.urgent:
        enough = not waits or p.pods.urge[pod] >= need
        # A pod that leaves the station has brought its items
        p.pods.able[pod] = p.pods.movable[pod] and p.pods.last[pod] != station and enough
        some = some or p.pods.able[pod]
    return some
