"""The turns of stations, compiled: how a period begins, and what taking a line and sending a pod change in it."""

from __future__ import annotations

import numpy as np

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.jit import njit
from rmfs_core.warehouse import BUSY, UNLIMITED, Lines, Stock
from rmfs_rules.pod_index import period
from rmfs_rules.pod_index.index import best_pods, find_within
from rmfs_rules.pod_index.period import NEVER, NONE, Bids, Bools, Ints, Period, Plain, Pods, Stations, Weights, fits


@njit(cache=True, interpreted=True)
def decide(
    open_lines: Plain, pods: Plain, given: Plain, capacities: Stations, now: int, without: int,
    placed: Bools, ticks: Ints, room: int,
) -> tuple[Ints, Ints]:  # fmt: skip
    """Let stations take their turns, fewest pods first, until all are through.

    Parameters
    ----------
    open_lines, pods, given
        Arrays of `Lines`, `Stock` and the parameters of the rule.
    capacities, now
        Stations, as the kernel has them; the tick.
    without
        Id of a station that takes nothing now, or `NONE`.
    placed
        Orders with a slot at a station that counts orders, shape (stations, orders), or (stations, 0): none.
    ticks
        Driving times to each station from each cell, shape (stations, cells).
    room
        How many more orders may be split.

    Returns
    -------
    `Period.takes` and `Period.sends`.
    """
    lines, stock, weights = Lines(*open_lines), Stock(*pods), Weights(*given)
    stations = capacities.copy()
    if without != NONE:
        stations[without]["free"] = 0
    n_skus, n_pods, n_lines, n_orders = len(lines.number), len(stock.at), lines.number.sum(), len(lines.items)
    takes, sends = np.empty((n_lines, 3), np.int64), np.empty((n_pods, 2), np.int64)
    need, covered = period.least_needed(stations, weights), period.covers(lines, stock, stations)
    if need == NEVER and not covered:
        return takes[:0], sends[:0]
    wanted = np.flatnonzero(lines.number)
    number, arrivals = period.count_lines(wanted, lines, stock)
    urge, movable = number * (now + weights.base_ticks) - arrivals, (stock.at != BUSY) & (number > 0)
    movable &= need != NEVER
    if period.waits(stations, weights):
        movable &= urge >= need
    if not covered and not movable.any():
        return takes[:0], sends[:0]
    available = count_items(stock, n_skus, len(ticks))
    share = period.share_visits(wanted, stock, available, number, weights)
    within, bearers = find_within(wanted if movable.any() else wanted[:0], stock, movable)
    of_sku = np.zeros((2, n_skus), np.int64)
    p = Period(
        lines, stock, weights, stations,
        Pods(stock.bound.copy(), urge, movable, np.zeros(n_pods, np.bool_), np.zeros(n_pods), np.flatnonzero(movable)),
        Bids(np.empty(n_lines, np.int64), np.empty(n_lines), of_sku[0], of_sku[1], within, bearers),
        now, wanted, lines.listed_items.copy(), lines.quantity.copy(), share, available,
        placed.copy() if placed.shape[1] else np.zeros((len(ticks), n_orders), np.bool_),
        np.zeros(n_orders), lines.open_lines < lines.begin[1:] - lines.begin[:-1], ticks,
        takes, sends, np.array([0, 0, room]),
    )  # fmt: skip
    going_on = stations["free"] > 0
    while going_on.any():
        turn = np.flatnonzero(going_on)
        for station in turn[np.argsort(stations["inbound"][turn], kind="mergesort")]:
            line, most = period.best_covered(p, station)
            if stations[station]["inbound"] < weights.most_pods and period.find_able(p, station):
                line = bring_pods(p, station, line, most)
            if line != NONE:
                take(p, line, station)
            more = stations[station]["free"] > 0 or stations[station]["counts_orders"] > 0
            going_on[station] = line != NONE and more
    return p.takes[: p.numbers[period.TAKES]], p.sends[: p.numbers[period.SENDS]]


@njit(cache=True, interpreted=True)
def count_items(stock: Stock, n_skus: int, n_stations: int) -> Ints:
    """Return the free items at each station of the pods that go there last, shape (n_skus, stations)."""
    available = np.zeros((n_skus, n_stations), np.int64)
    for pod in range(len(stock.bound)):
        station = stock.bound[pod]
        if station != NONE:
            for entry in range(stock.of_pod[pod], stock.of_pod[pod + 1]):
                available[stock.sku[entry], station] += stock.items[entry]
    return available


@njit(cache=True, interpreted=True)
def bring_pods(p: Period, station: int, line: int, most: float) -> int:
    """Send pods to a station instead of taking its best covered line, if that is better.

    Returns
    -------
    The line to be taken, `NONE` for none: the best one of the pod that was sent, or that which only all of the pods
    that were sent bring. (If another line were taken instead of that one, it might no longer fit, and pods would come
    for nothing.)
    """
    weights = p.weights
    found = best_pods(p, station, 0.0 if line == NONE else weights.stay * most / (weights.handle_s * p.items[line]))
    if len(found):
        pod = found[0]
        for other in found[1:]:
            if nearer(p, other, pod, station):
                pod = other
        send(p, pod, station)
        line, most = NONE, 0.0
        for entry in range(p.stock.of_pod[pod], p.stock.of_pod[pod + 1]):
            sku = p.stock.sku[entry]
            line, most = period.better_line(
                p, station, sku, p.available[sku, station] - p.stock.items[entry], line, most
            )
    elif line == NONE:
        line = send_scattered(p, station)
    return line


@njit(cache=True, interpreted=True)
def send_scattered(p: Period, station: int) -> int:
    """Send pods for the oldest line that wants several items, which pods have together: those with the most first.

    Returns
    -------
    The line, `NONE` for none.
    """
    lines, stock, able, oldest, oldest_sku = p.lines, p.stock, p.pods.able, NONE, NONE
    for sku in p.wanted:
        held = -1
        for at in range(lines.first[sku], lines.first[sku] + lines.number[sku]):
            order, quantity = lines.listed_order[at], p.items[at]
            if oldest != NONE and period.line_of(lines, at) > period.line_of(lines, oldest):
                break
            missing = quantity - p.available[sku, station]
            if quantity > 1 and missing > 0 and fits(p, order, quantity, station):
                if held < 0:
                    held = 0
                    for k in range(stock.of_sku[sku], stock.of_sku[sku + 1]):
                        if able[stock.pod[stock.by_sku[k]]]:
                            held += max(stock.items[stock.by_sku[k]], 0)
                if held >= missing:
                    oldest, oldest_sku = at, sku
    if oldest != NONE:
        missing = p.items[oldest] - p.available[oldest_sku, station]
        while missing > 0:
            most, items = NONE, 0
            for k in range(stock.of_sku[oldest_sku], stock.of_sku[oldest_sku + 1]):
                pod, held = stock.pod[stock.by_sku[k]], stock.items[stock.by_sku[k]]
                if able[pod] and (held > items or (held == items > 0 and nearer(p, pod, most, station))):
                    most, items = pod, held
            send(p, most, station)
            able[most] = False
            missing -= items
    return oldest


@njit(cache=True, interpreted=True)
def nearer(p: Period, pod: int, other: int, station: int) -> bool:
    """Return whether a pod is sooner at a station than another one; of equals, that of the lower id."""
    difference = p.ticks[station, p.stock.cell[pod]] - p.ticks[station, p.stock.cell[other]]
    return difference < 0 or (difference == 0 and pod < other)


@njit(cache=True, interpreted=True)
def send(p: Period, pod: int, station: int) -> None:
    """Decide a trip: a pod goes to a station last, which then has its free items."""
    sends, before = p.numbers[period.SENDS], p.pods.last[pod]
    p.sends[sends, 0], p.sends[sends, 1] = pod, station
    p.numbers[period.SENDS] += 1
    for entry in range(p.stock.of_pod[pod], p.stock.of_pod[pod + 1]):
        if before != NONE:
            p.available[p.stock.sku[entry], before] -= p.stock.items[entry]
        p.available[p.stock.sku[entry], station] += p.stock.items[entry]
    p.pods.last[pod], p.pods.movable[pod] = station, False
    p.stations[station]["inbound"] += 1


@njit(cache=True, interpreted=True)
def take(p: Period, at: int, station: int) -> None:
    """Assign a line."""
    lines, stock, quantity, order = p.lines, p.stock, p.items[at], p.lines.listed_order[at]
    line, takes = period.line_of(lines, at), p.numbers[period.TAKES]
    sku = lines.sku[line]
    p.takes[takes, 0], p.takes[takes, 1], p.takes[takes, 2] = station, lines.order_id[order], sku
    p.numbers[period.TAKES] += 1
    places = quantity
    if p.stations[station]["counts_orders"]:
        places = int(not p.placed[station, order])
        p.placed[station, order] = True
    p.stations[station]["free"] -= places
    p.stations[station]["load"] += places
    p.items[at] = p.quantity[line] = 0
    p.available[sku, station] -= quantity
    age = p.now + p.weights.base_ticks - int(lines.arrival_s[order] * TICKS_PER_S + 0.5)
    for k in range(stock.of_sku[sku], stock.of_sku[sku + 1]):
        pod, held = stock.pod[stock.by_sku[k]], stock.items[stock.by_sku[k]]
        p.pods.urge[pod] -= age * (held > 0)
        if p.pods.last[pod] == station and 0 < held < UNLIMITED:
            p.pods.movable[pod] = False  # one that was about to leave may be what the line is taken from
    rest = period.look_at(p, order) > 0
    if lines.open_lines[order] == lines.begin[order + 1] - lines.begin[order]:  # it was not split before
        before = p.takes[:takes]
        split = rest or ((before[:, 0] != station) & (before[:, 1] == lines.order_id[order])).any()
        p.numbers[period.PACKING_ROOM] += int(p.split[order]) - int(split)
        p.split[order] = split
