"""The turns of stations, compiled: what taking a line and sending a pod change in a period."""

from __future__ import annotations

import numpy as np
from numba import njit

from rmfs_core.warehouse import UNLIMITED
from rmfs_pod_index.compiled import best_covered, best_pods, bring, brought_so_far, fits, look_at, share_visits
from rmfs_pod_index.period import (
    AT_WORK,
    COMPLETED,
    FOUND,
    LENGTH,
    NONE,
    PACKING_ROOM,
    SENDS,
    TAKES,
    URGES,
)
from rmfs_pod_index.urging import change_urges, urgent


@njit(cache=True)
def send(p, pod, station, shelves):  # type: ignore[no-untyped-def]
    """Decide a trip."""
    p.sends[p.numbers[SENDS], 0], p.sends[p.numbers[SENDS], 1] = pod, station
    p.numbers[SENDS] += 1
    if p.last[pod] != NONE:
        bring(p.available, pod, p.last[pod], -1, shelves, p.items)
    p.last[pod] = station
    bring(p.available, pod, station, 1, shelves, p.items)
    p.inbound[station] += 1
    p.movable[pod] = False


@njit(cache=True)
def take(p, line, station, shelves, weights):  # type: ignore[no-untyped-def]
    """Assign a line."""
    order, quantity = p.order[line], p.quantity[line]
    if weights.packing:
        new = 1
        for k in range(p.numbers[TAKES]):
            if p.takes[k, 1] == station and p.order[p.takes[k, 0]] == order:
                new = 0
        p.parts[order] += new
    p.takes[p.numbers[TAKES], 0], p.takes[p.numbers[TAKES], 1] = line, station
    p.numbers[TAKES] += 1
    p.numbers[AT_WORK] = 1
    if p.counts_orders[station]:
        places = int(not p.placed[station, order])
        p.placed[station, order] = True
    else:
        places = quantity
    p.room[station] -= places
    p.load[station] += places
    p.untaken[line] = False
    p.open_items[order] -= quantity
    if p.numbers[URGES]:
        change_urges(p, p.sku[line], shelves, weights)
    p.available[station, p.sku[line]] -= quantity
    for k in range(shelves.first_with[p.sku[line]], shelves.first_with[p.sku[line] + 1]):
        entry = shelves.by_sku[k]
        if p.last[shelves.pod[entry]] == station and 0 < p.items[entry] < UNLIMITED:
            p.movable[shelves.pod[entry]] = False  # one that was about to leave may be what the line is taken from
    look_at(line, p.order, p.sku, p.quantity, p.share, p.untaken, p.factor, p.left, p.power, weights)
    rest = p.left[order] > 0
    p.numbers[COMPLETED] += not rest
    if weights.packing and not p.before[order]:
        split = rest or p.parts[order] > 1
        p.numbers[PACKING_ROOM] += int(p.split[order]) - int(split)
        p.split[order] = split


@njit(cache=True)
def find_nearest(p, station, ticks, cells):  # type: ignore[no-untyped-def]
    """Of the pods found, keep the one that is soonest at a station."""
    best = p.found[0]
    for pod in p.found[1 : p.numbers[FOUND]]:
        if ticks[station, cells[pod]] < ticks[station, cells[best]]:
            best = pod
    p.found[0], p.numbers[FOUND] = best, 1


@njit(cache=True)
def find_scattered(p, station, pods, ticks, cells, shelves, packing):  # type: ignore[no-untyped-def]
    """Find pods for the oldest line that wants several items, which pods have together: those with the most first."""
    quantity, sku, here = p.quantity, p.sku, p.available[station]
    for line in range(len(quantity)):
        missing = quantity[line] - here[sku[line]]
        if quantity[line] > 1 and missing > 0 and fits(p, line, station, packing):
            held = np.zeros(len(pods), np.int64)
            for k in range(shelves.first_with[sku[line]], shelves.first_with[sku[line] + 1]):
                entry = shelves.by_sku[k]
                if pods[shelves.pod[entry]]:
                    held[shelves.pod[entry]] = max(p.items[entry], 0)
            if held.sum() >= missing:
                while missing > 0:
                    order = np.argsort(ticks[station, cells], kind="mergesort")
                    most = order[np.argmax(held[order])]
                    p.found[p.numbers[FOUND]] = most
                    p.numbers[FOUND] += 1
                    missing -= held[most]
                    held[most] = 0
                return


@njit(cache=True)
def decide(p, before, bound, nothing, ticks, cells, shelves, weights):  # type: ignore[no-untyped-def]
    """Let stations take their turns, fewest pods first, until all are through.

    Parameters
    ----------
    p
        The period, in which ``available`` has items of the pods ``before``, and ``share`` is 0, as ``nothing`` is for
        each SKU.
    bound
        Pods at or bound for stations.
    ticks, cells
        Driving times to each station from each cell, shape (stations, cells); cell of each pod that may be sent.
    """
    brought_so_far(p.available, before, bound, p.last, shelves, p.items)
    share_visits(p.share, p.first, p.wanted, p.available, shelves, p.items, weights.cost_s)
    while begin_turn(p):
        for at in range(p.numbers[LENGTH]):
            station = p.turn[at]
            line, most = best_covered(p, station, nothing, weights)
            if p.inbound[station] < weights.most_pods:
                bring_pods(p, station, line, most, ticks, cells, shelves, weights)
                if p.numbers[FOUND]:
                    there = p.available[station].copy()
                    for k in range(p.numbers[FOUND]):
                        send(p, p.found[k], station, shelves)
                    line, _ = best_covered(p, station, there, weights)
            if line != NONE:
                take(p, line, station, shelves, weights)
            p.open[station] = line != NONE and (p.room[station] > 0 or p.counts_orders[station])


@njit(cache=True)
def bring_pods(p, station, line, most, ticks, cells, shelves, weights):  # type: ignore[no-untyped-def]
    """Find the pods that are sent to a station instead of taking its best covered line, if that is better."""
    bound = 0.0 if line == NONE else weights.stay * most / (weights.handle_s * p.quantity[line])
    pods = urgent(p, station, shelves, weights) & (p.last != station)  # one that leaves has brought what it has
    best_pods(p, station, bound, pods, shelves, weights)
    if p.numbers[FOUND] > 1:
        find_nearest(p, station, ticks, cells)
    if p.numbers[FOUND] == 0 and line == NONE:
        find_scattered(p, station, pods, ticks, cells, shelves, weights.packing)


@njit(cache=True)
def begin_turn(p):  # type: ignore[no-untyped-def]
    """Line up the stations that go on, fewest pods first; return whether there is one."""
    number = 0
    for station in range(len(p.open)):
        if p.open[station]:
            at = number
            while at > 0 and p.inbound[p.turn[at - 1]] > p.inbound[station]:
                p.turn[at] = p.turn[at - 1]
                at -= 1
            p.turn[at] = station
            number += 1
    p.numbers[LENGTH] = number
    return number > 0
