"""Which pods are wanted enough to be sent, compiled: the ages of the lines that they have items for, added up."""

from __future__ import annotations

from numba import njit

from rmfs_pod_index.period import AT_WORK, NONE, NOW, URGENT


@njit(cache=True)
def needed(load, capacity, urge_ticks, full):  # type: ignore[no-untyped-def]
    """Ticks that ages add up to before a pod is sent to a station of which so many places are taken."""
    return int(urge_ticks * (1 + (full - 1) * min(load, capacity) / capacity))


@njit(cache=True)
def next_urgent(lines_of, arrivals_of, now, need, base_ticks):  # type: ignore[no-untyped-def]
    """When the ages of the lines of the next pod add up to so many, NONE for never; and whether one's do now."""
    soonest, urgent_now = NONE, False
    for pod in range(len(lines_of)):
        number = lines_of[pod]
        missing = need - number * (now + base_ticks) + arrivals_of[pod]
        urgent_now = urgent_now or missing <= 0
        # Without a division where another pod is sooner
        if number and missing > 0 and (soonest == NONE or missing <= (soonest - 1) * number):
            soonest = -(-missing // number)
    return NONE if soonest == NONE else now + soonest, urgent_now


@njit(cache=True)
def find_urgent(urge, urgent, lines_of, arrivals_of, since, need):  # type: ignore[no-untyped-def]
    """Add up the ages for each pod, as of a tick, and list the pods for which they are enough; return how many."""
    number = 0
    for pod in range(len(urge)):
        urge[pod] = lines_of[pod] * since - arrivals_of[pod]
        if urge[pod] >= need:
            urgent[number] = pod
            number += 1
    return number


@njit(cache=True)
def change_urges(p, line, shelves, weights):  # type: ignore[no-untyped-def]
    """Take the age of a line from what the pods that have items for it are wanted."""
    age = p.numbers[NOW] + weights.base_ticks - p.arrival[p.order[line]]
    for k in range(shelves.first_with[p.sku[line]], shelves.first_with[p.sku[line] + 1]):
        entry = shelves.by_sku[k]
        if p.items[entry] > 0:
            p.urge[shelves.pod[entry]] -= age


@njit(cache=True)
def find_able(p, station, weights):  # type: ignore[no-untyped-def]
    """Mark the pods that may be sent to a station: movable, and wanted enough where it matters; return whether any."""
    waits, some = p.numbers[AT_WORK] and weights.urge_ticks, False
    need = needed(p.load[station], p.capacity[station], weights.urge_ticks, weights.full) if waits else 0
    for pod in p.urgent[: p.numbers[URGENT]]:
        # One that leaves the station has brought what it has
        p.able[pod] = p.movable[pod] and p.last[pod] != station and (not waits or p.urge[pod] >= need)
        some = some or p.able[pod]
    return some
