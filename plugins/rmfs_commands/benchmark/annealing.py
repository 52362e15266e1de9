"""Simulated annealing over schedules, compiled: which line is picked when, at which station, from which pod.

A schedule is one array: the lines (ids) of station after station, in the order in which they are picked, `STOP` between
two stations. Lines side by side from one pod are one visit. The evaluator knows no roads: it takes fetching, carrying
and storing a pod for fixed times, and pods for there as soon as their robot can be. Robots differ in where they start.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import njit

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
STOP = -1
STOLEN = 1.0
"""Cost (s) of a line that a pod before its own would serve, since it has its SKU and is there when it is taken."""

OTHER_POD, OF_RUN, SWAP, JOIN = 0.1, 0.4, 0.9, 0.8
"""A random number below the first gives a run another pod, up to the second it moves a run, from the third on it swaps
two lines; else it moves one, which with the last as probability takes the pod of its neighbour."""


class Work(NamedTuple):
    """The lines to pick, and how long things take (s).

    Parameters
    ----------
    order, sku
        Of each line. Shape (lines,).
    orders, stations, robots, capacity
        Their numbers; items that a station takes at a time.
    stock
        Items on each pod, many where unlimited. Shape (pods, SKUs).
    first
        Seconds from where each robot starts to each pod. Shape (robots, pods).
    carry
        Seconds from each pod to each station, and as much to fetch it the next time. Shape (pods, stations).
    store, swap
        Seconds to bring a pod back, and between two pods at a station.
    pick, handle
        As `stations.pick_s` and `handle_s`.
    weights
        Costs of a second of mean turn-over, of a visit, and of a second of makespan. Shape (3,).
    """

    order: Ints
    sku: Ints
    orders: int
    stations: int
    robots: int
    capacity: int
    stock: Ints
    first: Floats
    carry: Floats
    store: float
    swap: float
    pick: float
    handle: float
    weights: Floats


@njit(cache=True)
def cost(sequence: Ints, pod_of: Ints, work: Work) -> float:
    """Return the cost of a schedule.

    Parameters
    ----------
    sequence
        The lines of all stations. Shape (lines + stations - 1,).
    pod_of
        The pod of each line. Shape (lines,).
    work
        The rest.
    """
    n = len(sequence)
    at, begin = np.zeros(work.stations, np.int64), np.zeros(work.stations, np.int64)
    station = 0
    for place in range(n):
        if sequence[place] == STOP:
            station += 1
            at[station] = begin[station] = place + 1
    handled = np.zeros(n)
    picker, gone = np.zeros(work.stations), np.full(work.stations, -work.swap)
    robots, free_pod, begun = np.zeros(work.robots), np.zeros(len(work.stock)), np.zeros(work.robots, np.bool_)
    done = np.zeros(work.orders)
    visits, stolen, last = 0, 0, 0.0
    while True:
        chosen, asked = -1, np.inf
        for s in range(work.stations):
            place = at[s]
            if place < n and sequence[place] != STOP:
                since = place - begin[s] - work.capacity
                when = handled[begin[s] + since] if since >= 0 else 0.0
                if when < asked:
                    chosen, asked = s, when
        if chosen < 0:
            break
        place = at[chosen]
        pod = pod_of[sequence[place]]
        robot = _fetcher(robots, begun, work.first[:, pod])
        fetch = work.carry[pod, chosen] if begun[robot] else work.first[robot, pod]
        begun[robot] = True
        leaves = max(asked, robots[robot], free_pod[pod])
        now = max(leaves + fetch + work.carry[pod, chosen], picker[chosen], gone[chosen] + work.swap)
        visits += 1
        while place < n and sequence[place] != STOP and pod_of[sequence[place]] == pod:
            line = sequence[place]
            since = place - begin[chosen] - work.capacity
            stolen += _stolen(line, sequence, pod_of, at[chosen], max(begin[chosen], place - work.capacity), work)
            if since >= 0:
                now = max(now, handled[begin[chosen] + since])
            handled[place] = now + work.handle
            done[work.order[line]] = max(done[work.order[line]], handled[place])
            gone[chosen] = now + work.pick
            now += work.handle
            place += 1
        picker[chosen] = now
        at[chosen] = place
        robots[robot] = free_pod[pod] = gone[chosen] + work.store
        last = max(last, now)
    given = work.weights[0] * done.mean() + work.weights[1] * visits + work.weights[2] * last
    return float(given + STOLEN * stolen)


@njit(cache=True)
def _fetcher(free: Floats, begun: Any, ways: Floats) -> int:
    """Return the robot with the shortest way of those that have not begun; if all have, the first to be free."""
    nearest = int(np.argmin(free))
    for robot in range(len(ways)):
        if not begun[robot] and (begun[nearest] or ways[robot] < ways[nearest]):
            nearest = robot
    return nearest


@njit(cache=True)
def _stolen(line: int, sequence: Ints, pod_of: Ints, visit: int, least: int, work: Work) -> bool:
    """Whether a pod before that of a ``visit`` has a line's SKU, and is there yet when the line is taken."""
    one = visit - 1
    while one >= least:
        other = pod_of[sequence[one]]
        if work.stock[other, work.sku[line]] > 0:
            return True
        while one >= least and pod_of[sequence[one]] == other:
            one -= 1
    return False


@njit(cache=True)
def anneal(
    sequence: Ints, pod_of: Ints, work: Work, steps: int, hot: float, cold: float, seed: int
) -> tuple[Ints, Ints, float]:
    """Return the best schedule that so many random changes lead to, its pods, and its cost.

    A change moves a line, or a run of lines of one pod, elsewhere, gives a run another pod, or swaps two lines. One
    that costs more is kept with the probability of Metropolis, at temperatures from ``hot`` to ``cold`` (s).
    """
    np.random.seed(seed)
    n = len(sequence)
    left = work.stock.copy()
    for line in range(len(pod_of)):
        left[pod_of[line], work.sku[line]] -= 1
    now, order, at = cost(sequence, pod_of, work), sequence.copy(), pod_of.copy()
    best, best_order, best_at = now, order.copy(), at.copy()
    tried, tried_at = order.copy(), at.copy()
    for step in range(steps):
        heat = hot * (cold / hot) ** (step / steps)
        place = np.random.randint(n)
        if order[place] == STOP:
            continue
        tried[:], tried_at[:] = order, at
        first, last = _change(place, order, at, tried, tried_at, len(work.stock))
        holds = _give(order, first, last, at, tried_at, left, work.sku)
        price = cost(tried, tried_at, work) if holds else np.inf
        if holds and (price <= now or np.random.random() < np.exp((now - price) / heat)):
            order[:], at[:], now = tried, tried_at, price
            if now < best - 1e-9:
                best = now
                best_order[:], best_at[:] = order, at
        else:
            _give(order, first, last, tried_at, at, left, work.sku)
    return best_order, best_at, best


@njit(cache=True)
def _change(place: int, order: Ints, at: Ints, tried: Ints, tried_at: Ints, pods: int) -> tuple[int, int]:
    """Change a schedule at a place, in ``tried`` and ``tried_at``; return the places of lines that it is about."""
    n, first, last = len(order), place, place
    kind, pod = np.random.random(), at[order[place]]
    if kind < OF_RUN:
        while first > 0 and order[first - 1] != STOP and at[order[first - 1]] == pod:
            first -= 1
        while last + 1 < n and order[last + 1] != STOP and at[order[last + 1]] == pod:
            last += 1
    if kind < OTHER_POD:
        other = np.random.randint(pods)
        for one in range(first, last + 1):
            tried_at[order[one]] = other
    elif kind >= SWAP:
        other = np.random.randint(n)
        tried[place], tried[other] = order[other], order[place]
    else:
        to = _move(first, last, order, tried)
        if first == last:
            beside = to - 1 if np.random.random() < 0.5 else to + 1
            if np.random.random() < JOIN and 0 <= beside < n and tried[beside] != STOP:
                tried_at[order[place]] = at[tried[beside]]
            elif np.random.random() < 0.3:
                tried_at[order[place]] = np.random.randint(pods)
    return first, last


@njit(cache=True)
def _move(first: int, last: int, order: Ints, tried: Ints) -> int:
    """Move lines elsewhere; return where the first of them is then."""
    size, rest = last - first + 1, 0
    to = np.random.randint(len(order) - size + 1)
    for one in range(len(order)):
        if one < first or one > last:
            tried[rest if rest < to else rest + size] = order[one]
            rest += 1
    tried[to : to + size] = order[first : last + 1]
    return int(to)


@njit(cache=True)
def _give(order: Ints, first: int, last: int, at: Ints, to: Ints, left: Ints, sku: Ints) -> bool:
    """Count lines as served by other pods; return whether these have enough."""
    for one in range(first, last + 1):
        line = order[one]
        left[at[line], sku[line]] += 1
        left[to[line], sku[line]] -= 1
    enough = True
    for one in range(first, last + 1):
        enough &= left[to[order[one]], sku[order[one]]] >= 0
    return enough
