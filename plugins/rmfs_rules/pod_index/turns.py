"""The turns of stations, compiled: what taking a line and sending a pod change in a period."""

from __future__ import annotations

from rmfs_core.jit import njit
from rmfs_core.warehouse import UNLIMITED
from rmfs_rules.pod_index.account import bring, bring_all
from rmfs_rules.pod_index.compiled import best_covered, best_pods, better_line, find_within, fits, look_at, share_visits
from rmfs_rules.pod_index.period import (
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
    period_of,
)
from rmfs_rules.pod_index.urging import change_urges, find_able, find_urgent


@njit(cache=True)
def send(p, pod, station):
    """Decide a trip."""
    sent = p.sends[p.numbers[SENDS]]
    sent.pod, sent.station, sent.before = pod, station, p.pods[pod].last
    p.numbers[SENDS] += 1
    bring(p, pod, station)
    p.stations[station].inbound += 1
    p.pods[pod].movable = False


@njit(cache=True)
def take(p, line, station):
    """Assign a line."""
    weights = p.weights[0]
    order, sku, quantity = p.lines[line].order, p.lines[line].sku, p.lines[line].quantity
    if weights.packing:
        new = 1
        for k in range(p.numbers[TAKES]):
            if p.takes[k].station == station and p.takes[k].order == order:
                new = 0
        p.orders[order].parts += new
    taken = p.takes[p.numbers[TAKES]]
    taken.line, taken.station, taken.order, taken.sku = line, station, order, sku
    p.numbers[TAKES] += 1
    p.numbers[AT_WORK] = 1
    if p.stations[station].counts_orders:
        places = int(not p.placed[station, order])
        p.placed[station, order] = True
    else:
        places = quantity
    p.stations[station].room -= places
    p.stations[station].load += places
    p.lines[line].untaken = False
    p.orders[order].open_items -= quantity
    if weights.urge_ticks:
        change_urges(p, line)
    p.available[sku, station] -= quantity
    for k in range(p.first_with[sku], p.first_with[sku + 1]):
        pod = p.pods[p.holders[k].pod]
        if pod.last == station and 0 < p.holders[k].free < UNLIMITED:
            pod.movable = False  # one that was about to leave may be what the line is taken from
    look_at(p, order)
    rest = p.orders[order].left > 0
    p.numbers[COMPLETED] += not rest
    if weights.packing and not p.orders[order].ever:
        split = rest or p.orders[order].parts > 1
        p.numbers[PACKING_ROOM] += int(p.orders[order].split) - int(split)
        p.orders[order].split = split


@njit(cache=True)
def nearer(p, pod, other, station):
    """Whether a pod is sooner at a station than another one; of equals, that of the lower id."""
    difference = p.ticks[station, p.pods[pod].cell] - p.ticks[station, p.pods[other].cell]
    return difference < 0 or (difference == 0 and pod < other)


@njit(cache=True)
def find_nearest(p, station):
    """Of the pods found, keep the one that is soonest at a station."""
    best = p.found[0]
    for pod in p.found[1 : p.numbers[FOUND]]:
        if nearer(p, pod, best, station):
            best = pod
    p.found[0], p.numbers[FOUND] = best, 1


@njit(cache=True)
def find_scattered(p, station):
    """Find pods for the oldest line that wants several items, which pods have together: those with the most first.

    Returns
    -------
    The line, NONE for none.
    """
    oldest = NONE
    for sku in p.wanted[: p.numbers[WANTED]]:
        line, held = p.skus[sku].head, -1
        while line != NONE and (oldest == NONE or line < oldest):
            missing = p.lines[line].quantity - p.available[sku, station]
            if p.lines[line].quantity > 1 and missing > 0 and fits(p, line, station):
                if held < 0:
                    held = 0
                    for k in range(p.first_with[sku], p.first_with[sku + 1]):
                        if p.pods[p.holders[k].pod].able:
                            held += max(p.holders[k].free, 0)
                if held >= missing:
                    oldest = line
            line = p.lines[line].after
    if oldest == NONE:
        return NONE
    sku = p.lines[oldest].sku
    missing = p.lines[oldest].quantity - p.available[sku, station]
    while missing > 0:
        most, items = NONE, 0
        for k in range(p.first_with[sku], p.first_with[sku + 1]):
            pod, held = p.holders[k].pod, p.holders[k].free
            if p.pods[pod].able and (held > items or (held == items > 0 and nearer(p, pod, most, station))):
                most, items = pod, held
        p.found[p.numbers[FOUND]] = most
        p.numbers[FOUND] += 1
        p.pods[most].able = False
        missing -= items
    return oldest


@njit(cache=True)
def decide(words, at, ticks, placed, told, moved, leaving, asked):
    """Let stations take their turns, fewest pods first, until all are through.

    Lines that were taken are left in the account.

    Parameters
    ----------
    words, at, ticks, placed
        The period.
    told
        The tick; whether a station is at work; what the ages of a pod's lines have to add up to for it to be sent
        anywhere; then of each station the free places, of each the places that are taken, and of each the pods at or
        bound for it.
    moved
        Where pods are, as `move` takes them.
    leaving, asked
        Pods that leave a station, and where they are, shape (pods, 2); whether these were asked for.

    Returns
    -------
    Whether it matters which pods leave, so that they are to be asked for; then nothing was decided.
    """
    p = period_of(words, at, ticks, placed)
    bring_all(p, moved)
    for i in range(len(leaving)):
        p.pods[leaving[i, 0]].cell, p.pods[leaving[i, 0]].free = leaving[i, 1], True
    if begin(p, told) and not asked:
        return True
    share_visits(p)
    find_within(p)
    while begin_turn(p):
        for station in p.turn[: p.numbers[LENGTH]]:
            line, most = best_covered(p, station)
            if p.stations[station].inbound < p.weights[0].most_pods:
                scattered = bring_pods(p, station, line, most)
                if p.numbers[FOUND]:
                    line = send_found(p, station, scattered)
            if line != NONE:
                take(p, line, station)
            here = p.stations[station]
            here.open = line != NONE and (here.room > 0 or here.counts_orders)
    end(p)
    for i in range(len(leaving)):
        p.pods[leaving[i, 0]].free = False
    return False


@njit(cache=True)
def begin(p, told):
    """Begin the period; return whether pods that are not free are wanted enough to be sent somewhere."""
    for number in (TAKES, SENDS, COMPLETED, LOOKED):
        p.numbers[number] = 0
    p.numbers[NOW], p.numbers[AT_WORK] = told[0], told[1]
    n = len(p.stations)
    for i in range(n):
        here = p.stations[i]
        here.room, here.load, here.inbound = told[3 + i], told[3 + n + i], told[3 + 2 * n + i]
        here.open = here.room > 0
    return find_urgent(p, told[2])


@njit(cache=True)
def end(p):
    """Leave the account as it was before the period, and what was decided."""
    for taken in p.takes[: p.numbers[TAKES]]:
        quantity = p.lines[taken.line].quantity
        p.lines[taken.line].untaken = True
        p.orders[taken.order].open_items += quantity
        p.available[taken.sku, taken.station] += quantity
    for sent in p.sends[: p.numbers[SENDS]]:
        bring(p, sent.pod, sent.before)
    for order in p.looked[: p.numbers[LOOKED]]:
        p.orders[order].left = -1.0
    for pod in p.urgent[: p.numbers[URGENT]]:
        p.pods[pod].movable = False


@njit(cache=True)
def send_found(p, station, scattered):
    """Send the pods found to a station, and return the line that they are for, NONE for none.

    The one that only all of them bring, or else the best one. If another line were taken in place of the one that needs
    them all, that one might no longer fit, and pods would come for nothing.
    """
    found = p.found[: p.numbers[FOUND]]
    for pod in found:
        for entry in range(p.first[pod], p.first[pod + 1]):
            p.skus[p.entries[entry].sku].there = p.available[p.entries[entry].sku, station]
    for pod in found:
        send(p, pod, station)
    if scattered != NONE:
        return scattered
    line, most = NONE, 0.0
    for pod in found:
        for entry in range(p.first[pod], p.first[pod + 1]):
            sku = p.entries[entry].sku
            if p.skus[sku].number:
                line, most = better_line(p, station, sku, p.skus[sku].there, line, most)
    return line


@njit(cache=True)
def bring_pods(p, station, line, most):
    """Find the pods that are sent to a station instead of taking its best covered line, if that is better.

    Returns
    -------
    The line that only all of them together bring, NONE where there is one pod or none.
    """
    weights, scattered = p.weights[0], NONE
    p.numbers[FOUND] = 0
    if find_able(p, station):
        bound = 0.0 if line == NONE else weights.stay * most / (weights.handle_s * p.lines[line].quantity)
        best_pods(p, station, bound)
        if p.numbers[FOUND] > 1:
            find_nearest(p, station)
        if p.numbers[FOUND] == 0 and line == NONE:
            scattered = find_scattered(p, station)
        for pod in p.urgent[: p.numbers[URGENT]]:
            p.pods[pod].able = False
    return scattered


@njit(cache=True)
def begin_turn(p):
    """Line up the stations that go on, fewest pods first; return whether there is one."""
    number = 0
    for station in range(len(p.stations)):
        if p.stations[station].open:
            at = number
            while at > 0 and p.stations[p.turn[at - 1]].inbound > p.stations[station].inbound:
                p.turn[at] = p.turn[at - 1]
                at -= 1
            p.turn[at] = station
            number += 1
    p.numbers[LENGTH] = number
    return number > 0
