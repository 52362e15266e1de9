"""The turns of stations, compiled: how a period begins, and what taking a line and sending a pod change in it."""

from __future__ import annotations

import numpy as np

from rmfs_core.jit import njit
from rmfs_core.warehouse import BUSY, UNLIMITED, Lines, Stock
from rmfs_rules.pod_index.index import best_pods, find_within
from rmfs_rules.pod_index.period import (
    AT_WORK,
    FOUND,
    NONE,
    PACKING_ROOM,
    SENDS,
    TAKES,
    Bids,
    Bools,
    Ints,
    Period,
    Pods,
    Stations,
    Weights,
)
from rmfs_rules.pod_index.urging import NEVER, change_urges, count_lines, find_able, least_needed
from rmfs_rules.pod_index.worth import best_covered, better_line, bound_orders, fits, line_of, look_at, share_visits


@njit(cache=True)
def decide(
    lines: Lines,
    stock: Stock,
    weights: Weights,
    told: Ints,
    bound: Ints,
    places: Ints,
    ticks: Ints,
    now: int,
    packing: int,
) -> tuple[Ints, Ints]:
    """Let stations take their turns, fewest pods first, until all are through.

    Parameters
    ----------
    lines, stock, weights
        The warehouse, and the parameters of the rule.
    told
        The rows of `Stations`; they are changed.
    bound
        Pods at or bound for picking stations, and which they go to last, shape (pods, 2).
    places
        Stations that count orders, and ids of orders that have a place there, shape (places, 2).
    ticks
        Driving times to each station from each cell, shape (stations, cells).
    now, packing
        The tick; how many more split orders the packing stations have room for.

    Returns
    -------
    `Period.takes` and `Period.sends`.
    """
    stations = Stations(told[0], told[1], told[2], told[3], told[4], told[5])
    n_skus, n_pods, n_lines = len(lines.number), len(stock.at), lines.number.sum()
    covered, need = covers(lines, stock, stations, bound), least_needed(stations, weights)
    wanted, number, arrivals = np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.int64)
    movable = np.zeros(0, np.bool_)
    if covered or need != NEVER:
        wanted, number, arrivals = count_lines(lines, stock)
        movable = (stock.at != BUSY) & (number > 0) & (need != NEVER)
        if weights.urge_ticks and stations.load.any():  # else no pod waits to be wanted enough
            movable &= number * (now + weights.base_ticks) - arrivals >= need
    if not (covered or movable.any()):
        return np.zeros((0, 3), np.int64), np.zeros((0, 2), np.int64)
    last, available = count_items(stock, bound, n_skus, len(ticks))
    within, bearers = find_within(wanted if movable.any() else wanted[:0], stock, movable)
    split = np.zeros(0, np.bool_)
    if weights.packing:
        split = lines.open_lines < lines.begin[1:] - lines.begin[:-1]
    of_sku, urge = np.zeros((2, n_skus), np.int64), number * (now + weights.base_ticks) - arrivals
    p = Period(
        lines,
        stock,
        weights,
        stations,
        Pods(last, urge, movable, np.zeros(n_pods, np.bool_), np.zeros(n_pods), np.flatnonzero(movable)),
        Bids(np.empty(n_lines, np.int64), np.empty(n_lines), of_sku[0], of_sku[1], within, bearers),
        now,
        wanted,
        lines.listed_items.copy(),
        lines.quantity.copy(),
        share_visits(wanted, stock, available, number, weights.cost_s),
        available,
        find_placed(lines, places, stations),
        bound_orders(lines, weights),
        split,
        np.zeros(len(split), np.int64),
        ticks,
        np.empty((n_lines, 3), np.int64),
        np.empty((n_pods, 2), np.int64),
        np.empty(n_pods, np.int64),
        np.array([0, 0, 0, int(stations.load.any()), packing]),
    )
    turn = np.empty(len(ticks), np.int64)
    while True:
        stations_on = begin_turn(stations, turn)
        if not stations_on:
            return p.takes[: p.numbers[TAKES]], p.sends[: p.numbers[SENDS]]
        for station in turn[:stations_on]:
            line, most = best_covered(p, station)
            if stations.inbound[station] < weights.most_pods and find_able(p, station):
                line = bring_pods(p, station, line, most)
            if line != NONE:
                take(p, line, station)
            more = stations.room[station] > 0 or stations.counts_orders[station]
            stations.going_on[station] = line != NONE and more


@njit(cache=True)
def count_items(stock: Stock, bound: Ints, n_skus: int, n_stations: int) -> tuple[Ints, Ints]:
    """Return where pods go last, and the free items of these pods at each station; ``bound`` as in `decide`."""
    last, available = np.full(len(stock.at), NONE), np.zeros((n_skus, n_stations), np.int64)
    for i in range(len(bound)):
        pod, station = bound[i, 0], bound[i, 1]
        if last[pod] == NONE:  # a pod that is bound for several stations is listed for each
            last[pod] = station
            for entry in range(stock.of_pod[pod], stock.of_pod[pod + 1]):
                available[stock.sku[entry], station] += stock.items[entry]
    return last, available


@njit(cache=True)
def covers(lines: Lines, stock: Stock, stations: Stations, bound: Ints) -> bool:
    """Return whether a station with free places has items of a SKU with open lines; ``bound`` as in `decide`."""
    for i in range(len(bound)):
        pod, station = bound[i, 0], bound[i, 1]
        if stations.room[station] > 0:
            for entry in range(stock.of_pod[pod], stock.of_pod[pod + 1]):
                sku = stock.sku[entry]
                if lines.number[sku] and stock.items[entry] > 0:
                    return True
    return False


@njit(cache=True)
def find_placed(lines: Lines, places: Ints, stations: Stations) -> Bools:
    """Return `Period.placed`; ``places`` as in `decide`."""
    n_orders = len(lines.items) if stations.counts_orders.any() else 0
    placed = np.zeros((len(stations.room), n_orders), np.bool_)
    for i in range(len(places)):
        station, order_id = places[i, 0], places[i, 1]
        if order_id < len(lines.place) and lines.place[order_id] >= 0:
            placed[station, lines.place[order_id]] = True
    return placed


@njit(cache=True)
def begin_turn(stations: Stations, turn: Ints) -> int:
    """Line up the stations that go on in ``turn``, fewest pods first; return how many."""
    number = 0
    for station in range(len(turn)):
        if stations.going_on[station]:
            at = number
            while at > 0 and stations.inbound[turn[at - 1]] > stations.inbound[station]:
                turn[at] = turn[at - 1]
                at -= 1
            turn[at] = station
            number += 1
    return number


@njit(cache=True)
def bring_pods(p: Period, station: int, line: int, most: float) -> int:
    """Send pods to a station instead of taking its best covered line, if that is better.

    Returns
    -------
    The line to be taken, `NONE` for none: the best one of the pod that was sent, or that which only all of the pods
    that were sent bring. (If another line were taken in place of that one, it might no longer fit, and pods would come
    for nothing.)
    """
    weights = p.weights
    best_pods(p, station, 0.0 if line == NONE else weights.stay * most / (weights.handle_s * p.items[line]))
    if p.numbers[FOUND]:
        pod = p.found[0]
        for other in p.found[1 : p.numbers[FOUND]]:
            if nearer(p, other, pod, station):
                pod = other
        send(p, pod, station)
        line, most = NONE, 0.0
        for entry in range(p.stock.of_pod[pod], p.stock.of_pod[pod + 1]):
            sku = p.stock.sku[entry]
            line, most = better_line(p, station, sku, p.available[sku, station] - p.stock.items[entry], line, most)
    elif line == NONE:
        line = find_scattered(p, station)
        for pod in p.found[: p.numbers[FOUND]]:
            send(p, pod, station)
    return line


@njit(cache=True)
def find_scattered(p: Period, station: int) -> int:
    """Find pods for the oldest line that wants several items, which pods have together: those with the most first.

    Returns
    -------
    The line, `NONE` for none.
    """
    lines, stock, able, oldest, oldest_sku = p.lines, p.stock, p.pods.able, NONE, NONE
    for sku in p.wanted:
        held = -1
        for at in range(lines.first[sku], lines.first[sku] + lines.number[sku]):
            order, quantity = lines.listed_order[at], p.items[at]
            if oldest != NONE and line_of(lines, at) > line_of(lines, oldest):
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
            p.found[p.numbers[FOUND]] = most
            p.numbers[FOUND] += 1
            able[most] = False
            missing -= items
    return oldest


@njit(cache=True)
def nearer(p: Period, pod: int, other: int, station: int) -> bool:
    """Return whether a pod is sooner at a station than another one; of equals, that of the lower id."""
    difference = p.ticks[station, p.stock.cell[pod]] - p.ticks[station, p.stock.cell[other]]
    return difference < 0 or (difference == 0 and pod < other)


@njit(cache=True)
def send(p: Period, pod: int, station: int) -> None:
    """Decide a trip: a pod goes to a station last, which then has its free items."""
    sends, before = p.numbers[SENDS], p.pods.last[pod]
    p.sends[sends, 0], p.sends[sends, 1] = pod, station
    p.numbers[SENDS] += 1
    for entry in range(p.stock.of_pod[pod], p.stock.of_pod[pod + 1]):
        if before != NONE:
            p.available[p.stock.sku[entry], before] -= p.stock.items[entry]
        p.available[p.stock.sku[entry], station] += p.stock.items[entry]
    p.pods.last[pod], p.pods.movable[pod] = station, False
    p.stations.inbound[station] += 1


@njit(cache=True)
def take(p: Period, at: int, station: int) -> None:
    """Assign a line."""
    lines, stock, quantity, order = p.lines, p.stock, p.items[at], p.lines.listed_order[at]
    line, takes = line_of(lines, at), p.numbers[TAKES]
    sku = lines.sku[line]
    p.takes[takes, 0], p.takes[takes, 1], p.takes[takes, 2] = station, lines.order_id[order], sku
    p.numbers[TAKES] += 1
    p.numbers[AT_WORK] = 1
    places = quantity
    if p.stations.counts_orders[station]:
        places = int(not p.placed[station, order])
        p.placed[station, order] = True
    p.stations.room[station] -= places
    p.stations.load[station] += places
    p.items[at] = p.quantity[line] = 0
    change_urges(p, sku, order)
    p.available[sku, station] -= quantity
    for k in range(stock.of_sku[sku], stock.of_sku[sku + 1]):
        entry = stock.by_sku[k]
        if p.pods.last[stock.pod[entry]] == station and 0 < stock.items[entry] < UNLIMITED:
            p.pods.movable[stock.pod[entry]] = False  # one that was about to leave may be what the line is taken from
    rest = look_at(p, order) > 0
    if p.weights.packing:
        p.parts[order] += not _has_part(p.takes[:takes], station, lines.order_id[order])
        if lines.open_lines[order] == lines.begin[order + 1] - lines.begin[order]:  # it was not split before
            split = rest or p.parts[order] > 1
            p.numbers[PACKING_ROOM] += int(p.split[order]) - int(split)
            p.split[order] = split


@njit(cache=True)
def _has_part(takes: Ints, station: int, order_id: int) -> bool:
    """Return whether a station has taken a line of an order already."""
    return ((takes[:, 0] == station) & (takes[:, 1] == order_id)).any()  # type: ignore[no-any-return]
