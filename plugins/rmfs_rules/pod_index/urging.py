"""Which pods are wanted enough to be sent, compiled: the ages of the lines that they have items for, added up."""

from __future__ import annotations

from rmfs_core.jit import njit
from rmfs_rules.pod_index.period import AT_WORK, NONE, NOW, URGENT, period_of


@njit(cache=True)
def needed(load, capacity, urge_ticks, full):
    """Ticks that ages add up to before a pod is sent to a station of which so many places are taken."""
    return int(urge_ticks * (1 + (full - 1) * min(load, capacity) / capacity))


@njit(cache=True)
def next_urgent(words, at, ticks, placed, now, need):
    """When the ages of the lines of the next pod add up to so many, NONE for never; of those whose do not now."""
    p = period_of(words, at, ticks, placed)
    soonest, since = NONE, now + p.weights[0].base_ticks
    for pod in p.ages:
        number = pod.lines_of
        missing = need - number * since + pod.arrivals_of
        # Without a division where another pod is sooner
        if number and missing > 0 and (soonest == NONE or missing <= (soonest - 1) * number):
            soonest = -(-missing // number)
    return NONE if soonest == NONE else now + soonest


@njit(cache=True)
def find_front(p, now):
    """List the pods of which one is next from now on, whatever the ages have to add up to; return how many.

    No pod with as many lines or more is wanted as much.
    """
    number, lines, since = 0, 0, now + p.weights[0].base_ticks
    while True:
        best, most = NONE, 0
        for pod in range(len(p.ages)):
            wanted = p.ages[pod]
            if wanted.lines_of > lines:
                urge = wanted.lines_of * since - wanted.arrivals_of
                if best == NONE or urge > most or (urge == most and wanted.lines_of > p.ages[best].lines_of):
                    best, most = pod, urge
        if best == NONE:
            return number
        p.front[number] = p.ages[best]
        lines = p.ages[best].lines_of
        number += 1


@njit(cache=True)
def find_urgent(p, need):
    """List the free pods whose lines' ages add up to enough to be sent somewhere; return whether others' do."""
    number, others, since = 0, False, p.numbers[NOW] + p.weights[0].base_ticks
    for i in range(len(p.ages)):
        wanted = p.ages[i]
        urge = wanted.lines_of * since - wanted.arrivals_of
        if wanted.lines_of and urge >= need:
            pod = p.pods[i]
            if pod.free:
                p.urgent[number] = i
                number += 1
                pod.urge, pod.movable = urge, True
            else:
                others = True
    p.numbers[URGENT] = number
    return others


@njit(cache=True)
def change_urges(p, line):
    """Take the age of a line from what the pods that have items for it are wanted."""
    age = p.numbers[NOW] + p.weights[0].base_ticks - p.orders[p.lines[line].order].arrival
    for k in range(p.first_with[p.lines[line].sku], p.first_with[p.lines[line].sku + 1]):
        if p.holders[k].free > 0:
            p.pods[p.holders[k].pod].urge -= age


@njit(cache=True)
def find_able(p, station):
    """Mark the pods that may be sent to a station: movable, and wanted enough where it matters; return whether any."""
    weights = p.weights[0]
    waits, some = p.numbers[AT_WORK] and weights.urge_ticks, False
    here = p.stations[station]
    need = needed(here.load, here.capacity, weights.urge_ticks, weights.full) if waits else 0
    for i in p.urgent[: p.numbers[URGENT]]:
        pod = p.pods[i]
        # One that leaves the station has brought what it has
        pod.able = pod.movable and pod.last != station and (not waits or pod.urge >= need)
        some = some or pod.able
    return some
