"""The turns of stations, compiled: what taking a line and sending a pod change in a period."""

from __future__ import annotations

from numba import njit

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.warehouse import UNLIMITED
from rmfs_pod_index.account import find_wanted
from rmfs_pod_index.compiled import best_covered, best_pods, better_line, bring, fits, look_at, share_visits
from rmfs_pod_index.period import (
    ASKED,
    AT_WORK,
    COMPLETED,
    FOUND,
    LENGTH,
    LOOKED,
    NONE,
    NOW,
    PACKING_ROOM,
    SENDS,
    TAKES,
    URGENT,
    WANTED,
)
from rmfs_pod_index.urging import change_urges, find_able


@njit(cache=True)
def send(p, pod, station, shelves):  # type: ignore[no-untyped-def]
    """Decide a trip."""
    p.sends[p.numbers[SENDS], 0], p.sends[p.numbers[SENDS], 1] = pod, station
    p.numbers[SENDS] += 1
    if p.last[pod] != NONE:
        bring(p, pod, p.last[pod], -1, shelves)
    p.last[pod] = station
    bring(p, pod, station, 1, shelves)
    p.inbound[station] += 1
    p.movable[pod] = False


@njit(cache=True)
def take(p, line, station, shelves, weights):  # type: ignore[no-untyped-def]
    """Assign a line."""
    order, sku, quantity = p.order[line], p.sku[line], p.quantity[line]
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
    if weights.urge_ticks:
        change_urges(p, line, shelves, weights)
    p.available[sku, station] -= quantity
    for k in range(shelves.first_with[sku], shelves.first_with[sku + 1]):
        entry = shelves.by_sku[k]
        if p.last[shelves.pod[entry]] == station and 0 < p.items[entry] < UNLIMITED:
            p.movable[shelves.pod[entry]] = False  # one that was about to leave may be what the line is taken from
    orders = p.begin, p.end, p.due_s, p.worth, p.left, p.base, p.root, p.power
    look_at(orders, order, p.sku, p.quantity, p.share, p.untaken, p.numbers[NOW] / TICKS_PER_S, weights)
    rest = p.left[order] > 0
    p.numbers[COMPLETED] += not rest
    if weights.packing and not p.ever[order]:
        split = rest or p.parts[order] > 1
        p.numbers[PACKING_ROOM] += int(p.split[order]) - int(split)
        p.split[order] = split


@njit(cache=True)
def nearer(p, pod, other, station, ticks, cells):  # type: ignore[no-untyped-def]
    """Whether a pod is sooner at a station than another one; of equals, that of the lower id."""
    for asked in (pod, other):
        p.numbers[ASKED] += not p.asked[asked]
        p.asked[asked] = True
    difference = ticks[station, cells[pod]] - ticks[station, cells[other]]
    return difference < 0 or (difference == 0 and pod < other)


@njit(cache=True)
def find_nearest(p, station, ticks, cells):  # type: ignore[no-untyped-def]
    """Of the pods found, keep the one that is soonest at a station."""
    best = p.found[0]
    for pod in p.found[1 : p.numbers[FOUND]]:
        if nearer(p, pod, best, station, ticks, cells):
            best = pod
    p.found[0], p.numbers[FOUND] = best, 1


@njit(cache=True)
def find_scattered(p, station, ticks, cells, shelves, packing):  # type: ignore[no-untyped-def]
    """Find pods for the oldest line that wants several items, which pods have together: those with the most first."""
    oldest = NONE
    for sku in p.wanted[: p.numbers[WANTED]]:
        line, held = p.head[sku], -1
        while line != NONE and (oldest == NONE or line < oldest):
            missing = p.quantity[line] - p.available[sku, station]
            if p.quantity[line] > 1 and missing > 0 and fits(p, line, station, packing):
                if held < 0:
                    held = 0
                    for k in range(shelves.first_with[sku], shelves.first_with[sku + 1]):
                        if p.able[shelves.pod[shelves.by_sku[k]]]:
                            held += max(p.items[shelves.by_sku[k]], 0)
                if held >= missing:
                    oldest = line
            line = p.after[line]
    if oldest == NONE:
        return
    sku = p.sku[oldest]
    missing = p.quantity[oldest] - p.available[sku, station]
    while missing > 0:
        most, items = NONE, 0
        for k in range(shelves.first_with[sku], shelves.first_with[sku + 1]):
            pod, held = shelves.pod[shelves.by_sku[k]], p.items[shelves.by_sku[k]]
            if p.able[pod] and (held > items or (held == items > 0 and nearer(p, pod, most, station, ticks, cells))):
                most, items = pod, held
        p.found[p.numbers[FOUND]] = most
        p.numbers[FOUND] += 1
        p.able[most] = False
        missing -= items


@njit(cache=True)
def decide(p, bound, stations, ticks, cells, shelves, weights):  # type: ignore[no-untyped-def]
    """Let stations take their turns, fewest pods first, until all are through.

    Parameters
    ----------
    p
        The period, in which ``available`` is 0, and ``last`` NONE, as they are afterwards again; lines that were taken
        are left in the account.
    bound, stations
        Pods at or bound for stations, and where each goes last.
    ticks, cells
        Driving times to each station from each cell, shape (stations, cells); cell of each pod that may be sent.
    """
    for number in (TAKES, SENDS, COMPLETED, ASKED, LOOKED):
        p.numbers[number] = 0
    for i in range(len(bound)):
        p.last[bound[i]] = stations[i]
        bring(p, bound[i], stations[i], 1, shelves)
    find_wanted(p)
    share_visits(p, shelves, weights.cost_s)
    while begin_turn(p):
        for at in range(p.numbers[LENGTH]):
            station = p.turn[at]
            line, most = best_covered(p, station, weights)
            if p.inbound[station] < weights.most_pods:
                bring_pods(p, station, line, most, ticks, cells, shelves, weights)
                if p.numbers[FOUND]:
                    line = send_found(p, station, shelves, weights)
            if line != NONE:
                take(p, line, station, shelves, weights)
            p.open[station] = line != NONE and (p.room[station] > 0 or p.counts_orders[station])
    for take_ in p.takes[: p.numbers[TAKES]]:
        p.untaken[take_[0]] = True
        p.open_items[p.order[take_[0]]] += p.quantity[take_[0]]
    for order in p.looked[: p.numbers[LOOKED]]:
        p.left[order] = -1.0
    for pod in bound:
        clear(p, pod, shelves)
    for sent in p.sends[: p.numbers[SENDS]]:
        clear(p, sent[0], shelves)


@njit(cache=True)
def clear(p, pod, shelves):  # type: ignore[no-untyped-def]
    """Forget where a pod goes last, and what it brings."""
    p.last[pod] = NONE
    for entry in range(shelves.first[pod], shelves.first[pod + 1]):
        p.available[shelves.sku[entry], :] = 0


@njit(cache=True)
def send_found(p, station, shelves, weights):  # type: ignore[no-untyped-def]
    """Send the pods found to a station, and return the best line that they bring; NONE for none."""
    found = p.found[: p.numbers[FOUND]]
    for pod in found:
        for entry in range(shelves.first[pod], shelves.first[pod + 1]):
            p.there[shelves.sku[entry]] = p.available[shelves.sku[entry], station]
    for pod in found:
        send(p, pod, station, shelves)
    line, most = NONE, 0.0
    for pod in found:
        for entry in range(shelves.first[pod], shelves.first[pod + 1]):
            sku = shelves.sku[entry]
            if p.number[sku]:
                line, most = better_line(p, station, sku, p.there[sku], line, most, weights)
    return line


@njit(cache=True)
def bring_pods(p, station, line, most, ticks, cells, shelves, weights):  # type: ignore[no-untyped-def]
    """Find the pods that are sent to a station instead of taking its best covered line, if that is better."""
    p.numbers[FOUND] = 0
    if find_able(p, station, weights):
        bound = 0.0 if line == NONE else weights.stay * most / (weights.handle_s * p.quantity[line])
        best_pods(p, station, bound, shelves, weights)
        if p.numbers[FOUND] > 1:
            find_nearest(p, station, ticks, cells)
        if p.numbers[FOUND] == 0 and line == NONE:
            find_scattered(p, station, ticks, cells, shelves, weights.packing)
        for pod in p.urgent[: p.numbers[URGENT]]:
            p.able[pod] = False


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
