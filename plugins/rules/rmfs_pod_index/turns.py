"""The turns of stations, compiled: what taking a line and sending a pod change in a period."""

from __future__ import annotations

from numba import njit

from rmfs_pod_index.compiled import (
    AT,
    AT_WORK,
    COMPLETED,
    FOUND,
    LENGTH,
    LINE,
    NONE,
    PACKING_ROOM,
    SENDS,
    TAKES,
    best_covered,
    best_pods,
    bring,
    fits,
    look_at,
    urgent,
)

DONE, TIE, GATHER = 0, 1, 2
"""How `advance` ends: all is decided; several pods are as good; a line needs several pods."""


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
def take(p, line, station, weights):  # type: ignore[no-untyped-def]
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
        if not p.placed[station, order]:
            p.room[station] -= 1
            p.placed[station, order] = True
    else:
        p.room[station] -= quantity
    p.untaken[line] = False
    p.available[station, p.sku[line]] -= quantity
    look_at(line, p.order, p.sku, p.quantity, p.share, p.untaken, p.factor, p.left, p.power, weights)
    rest = p.left[order] > 0
    p.numbers[COMPLETED] += not rest
    if weights.packing and not p.before[order]:
        split = rest or p.parts[order] > 1
        p.numbers[PACKING_ROOM] += int(p.split[order]) - int(split)
        p.split[order] = split


@njit(cache=True)
def scattered(p, station, pods, shelves, packing):  # type: ignore[no-untyped-def]
    """Find the pods of the oldest line that wants several items, which they have together; return it, NONE for none."""
    quantity, sku, here = p.quantity, p.sku, p.available[station]
    for line in range(len(quantity)):
        missing = quantity[line] - here[sku[line]]
        if quantity[line] > 1 and missing > 0 and fits(p, line, station, packing):
            for k in range(shelves.first_with[p.sku[line]], shelves.first_with[p.sku[line] + 1]):
                entry = shelves.by_sku[k]
                if pods[shelves.pod[entry]]:
                    missing -= max(p.items[entry], 0)
            if missing <= 0:
                for k in range(shelves.first_with[p.sku[line]], shelves.first_with[p.sku[line] + 1]):
                    entry = shelves.by_sku[k]
                    if pods[shelves.pod[entry]] and p.items[entry] > 0:
                        p.found[p.numbers[FOUND]] = shelves.pod[entry]
                        p.numbers[FOUND] += 1
                return line
    return NONE


@njit(cache=True)
def advance(p, shelves, weights, nothing):  # type: ignore[no-untyped-def]
    """Let stations take their turns, fewest pods first, until all are through or somebody has to choose a pod.

    ``nothing`` is 0 for each SKU. Where it ends with `TIE` or `GATHER`, the station's turn goes on with `bring_pods`.
    """
    while True:
        while p.numbers[AT] < p.numbers[LENGTH]:
            station = p.turn[p.numbers[AT]]
            line, most = best_covered(p, station, nothing, weights)
            if p.inbound[station] < weights.most_pods:
                bound = 0.0
                if line != NONE:
                    bound = weights.stay * most / (weights.handle_s * p.quantity[line])
                pods = urgent(p, shelves, weights)
                best_pods(p, station, bound, pods, shelves, weights)
                if p.numbers[FOUND] > 1:
                    return TIE
                if p.numbers[FOUND] == 1:
                    bring_pods(p, shelves, weights)
                    continue
                if line == NONE:
                    p.numbers[LINE] = scattered(p, station, pods, shelves, weights.packing)
                    if p.numbers[LINE] != NONE:
                        return GATHER
            end_turn(p, station, line, weights)
        if not begin_turn(p):
            return DONE


@njit(cache=True)
def bring_pods(p, shelves, weights):  # type: ignore[no-untyped-def]
    """Send the pods found to the station whose turn it is, which takes the best line that they bring."""
    station = p.turn[p.numbers[AT]]
    before = p.available[station].copy()
    for k in range(p.numbers[FOUND]):
        send(p, p.found[k], station, shelves)
    line, _ = best_covered(p, station, before, weights)
    end_turn(p, station, line, weights)


@njit(cache=True)
def end_turn(p, station, line, weights):  # type: ignore[no-untyped-def]
    """Take a line, or leave the station's places free."""
    if line != NONE:
        take(p, line, station, weights)
    p.open[station] = line != NONE and (p.room[station] > 0 or p.counts_orders[station])
    p.numbers[AT] += 1


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
    p.numbers[AT], p.numbers[LENGTH] = 0, number
    return number > 0
