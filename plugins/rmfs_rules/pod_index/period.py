"""A period of pod-index under construction, compiled: what lines are worth, and which pods are wanted enough."""

from __future__ import annotations

from math import exp
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.jit import helper, njit
from rmfs_core.warehouse import Lines, Stock

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Plain = tuple[Any, ...]
Stations = NDArray[np.void]
"""Stations by id, `CAPACITY`."""

NONE, NEVER = -1, 1 << 62
"""No line, pod or station; a tick, or a sum of ages, that is never reached."""
MOST_STEPS = 20
"""Priorities of more steps count as so many."""
CLOSE = 1e-9
"""Relative difference up to which two indices count as equal: sums of the same numbers in another order may differ."""

TAKES, SENDS, PACKING_ROOM = range(3)
"""Indices of ``Period.numbers``: lines taken, pods sent; how many more orders may be split."""


class Weights(NamedTuple):
    """The parameters of the rule, as `PodIndex` explains them; times that are compared with ages are in ticks."""

    visit_s: float
    cost_s: float
    finish: float
    stay: float
    elsewhere: float
    full: float
    handle_s: float
    near: float
    again: float
    due_factor: float
    due_s: float
    most_pods: int
    urge_ticks: int
    base_ticks: int
    priority: Floats  # priority_factor to the power of -20 to 20
    least: Floats  # 0, 1, 2 ... seconds to the power of ``finish``


class Pods(NamedTuple):
    """The pods; arrays of shape (pods,), except for the last one."""

    last: Ints  # the picking station that it goes to last, where its free items are; NONE: none
    urge: Ints  # ages of the open lines that it has items for, and base_ticks for each, added up
    movable: Bools  # whether it may be sent, and was wanted enough at the beginning
    able: Bools  # whether it may be sent to the station whose turn it is
    gain: Floats  # what it brings beyond a rate
    urgent: Ints  # ids of the pods that were movable at the beginning, ascending


class Bids(NamedTuple):
    """The lines that a station might be brought, side by side for each SKU."""

    items: Ints  # shape (lines,)
    worth: Floats  # shape (lines,)
    first: Ints  # the lines of a SKU are from first[sku] to before end[sku]; shape (n_skus,)
    end: Ints
    within: Ints  # SKUs with open lines that movable pods have; first and end of ``bearers``; shape (SKUs, 3)
    bearers: Ints  # entries of `Stock` of the movable pods, by SKU


class Period(NamedTuple):
    """All that turns read and change. *A line* is its position in the lists of `Lines` by SKU."""

    lines: Lines
    stock: Stock
    weights: Weights
    stations: Stations
    pods: Pods
    bids: Bids
    now: int  # the tick
    wanted: Ints  # the SKUs with open lines, ascending
    items: Ints  # items by position in the lists, 0 once taken
    quantity: Ints  # the same by line, as in ``Lines.quantity``
    share: Floats  # seconds of a visit that a line of a SKU bears; shape (n_skus,)
    available: Ints  # free items at stations, shape (n_skus, stations)
    placed: Bools  # orders with a slot at a station that counts orders, shape (stations, orders)
    power: Floats  # what the seconds of a line are divided by for its worth, 0 until worked out; shape (orders,)
    split: Bools  # whether an order is split, shape (orders,)
    ticks: Ints  # driving times to each station, shape (stations, cells)
    takes: Ints  # what was taken: station, order id, SKU; shape (lines, 3)
    sends: Ints  # what was sent: pod, station; shape (pods, 2)
    numbers: Ints  # see TAKES


@njit(cache=True, interpreted=True)
def count_lines(wanted: Ints, lines: Lines, stock: Stock) -> tuple[Ints, Ints]:
    """Return, by pod, how many open lines it has items for, and the ticks at which their orders arrived, added up."""
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
    return number, arrivals


@njit(cache=True, interpreted=True)
def needed(stations: Stations, at: int, weights: Weights) -> int:
    """Return ticks that ages add up to before a pod is sent to a station, by the slots of it that are taken."""
    load, capacity = stations[at]["load"], stations[at]["capacity"]
    return int(weights.urge_ticks * (1 + (weights.full - 1) * min(load, capacity) / capacity))


@njit(cache=True, interpreted=True)
def waits(stations: Stations, weights: Weights) -> bool:
    """Return whether pods wait until they are wanted enough: while stations are at work."""
    return bool(weights.urge_ticks > 0 and stations["load"].any())


@njit(cache=True, interpreted=True)
def least_needed(stations: Stations, weights: Weights) -> int:
    """Return the least of what is needed at the stations that take another pod, `NEVER` where none does."""
    least = NEVER
    for i in range(len(stations)):
        if stations[i]["free"] and stations[i]["inbound"] < weights.most_pods:
            least = min(least, needed(stations, i, weights))
    return least


@helper
def covers(lines: Lines, stock: Stock, stations: Stations) -> bool:
    """Return whether a pod that goes to a station with free slots last has an item of an open line."""
    for pod in range(len(stock.bound)):
        if stock.bound[pod] != NONE and stations[stock.bound[pod]]["free"] > 0:
            for entry in range(stock.of_pod[pod], stock.of_pod[pod + 1]):
                if stock.items[entry] > 0 and lines.number[stock.sku[entry]]:
                    return True
    return False


@njit(cache=True, interpreted=True)
def next_urgent(open_lines: Plain, pods: Plain, given: Plain, capacities: Stations, now: int) -> int:
    """Return the tick at which the next pod is wanted enough while nothing but the time changes, `NEVER` for never.

    The arguments are as in `turns.decide`.
    """
    lines, stock, weights = Lines(*open_lines), Stock(*pods), Weights(*given)
    need, tick = least_needed(capacities, weights), NEVER
    if need == NEVER or not waits(capacities, weights):
        return NEVER
    number, arrivals = count_lines(np.flatnonzero(lines.number), lines, stock)
    for pod in range(len(number)):
        missing = need - number[pod] * (now + weights.base_ticks) + arrivals[pod]
        if number[pod] and missing > 0:
            tick = min(tick, now - (-missing // number[pod]))
    return tick


@njit(cache=True, interpreted=True)
def find_able(p: Period, station: int) -> bool:
    """Mark the pods that may be sent to a station: movable, and wanted enough where it matters; return whether any."""
    pods, need, some = p.pods, 0, False
    if waits(p.stations, p.weights):
        need = needed(p.stations, station, p.weights)
    for pod in pods.urgent:
        # A pod that leaves the station has brought its items
        pods.able[pod] = pods.movable[pod] and pods.last[pod] != station and pods.urge[pod] >= need
        some = some or pods.able[pod]
    return some


@njit(cache=True, interpreted=True)
def share_visits(wanted: Ints, stock: Stock, available: Ints, number: Ints, weights: Weights) -> Floats:
    """Return seconds of a visit for each line of a SKU: ``cost_s`` if no station has it, else ``again`` times that.

    ``cost_s`` is divided by the lines on the pod with most of them that has the SKU; ``number`` has them by pod.
    """
    share = np.zeros(len(available))
    for sku in wanted:
        most, here = 0, False
        for station in range(available.shape[1]):
            here = here or available[sku, station] > 0
        if not here or weights.again > 0:
            for k in range(stock.of_sku[sku], stock.of_sku[sku + 1]):
                entry = stock.by_sku[k]
                if stock.items[entry] > 0:
                    most = max(most, number[stock.pod[entry]])
        if most > 0:
            share[sku] = (weights.again * weights.cost_s if here else weights.cost_s) / most
    return share


@helper
def priority_factor(p: Period, order: int) -> float:
    """Return how many times more the lines of an order are worth by its priority."""
    steps = min(max(p.lines.priority[order], -MOST_STEPS), MOST_STEPS)
    return p.weights.priority[steps + MOST_STEPS]  # type: ignore[no-any-return]


@helper
def look_at(p: Period, order: int) -> float:
    """Work out the power of an order; return the seconds of the lines that it has left."""
    weights, lines, factor, seconds = p.weights, p.lines, priority_factor(p, order), 0.0
    for line in range(lines.begin[order], lines.begin[order + 1]):
        if p.quantity[line]:
            seconds += weights.handle_s * p.quantity[line] + p.share[lines.sku[line]]
    if lines.due_s[order] < np.inf:
        slack_s = max(lines.due_s[order] - p.now / TICKS_PER_S, 0.0)
        factor = (1.0 + (weights.due_factor - 1.0) * exp(-slack_s / weights.due_s)) * factor
    p.power[order] = seconds**weights.finish / factor
    return seconds


@njit(cache=True, interpreted=True, _nrt=False)
def line_of(lines: Lines, at: int) -> int:
    """Return the line at a position in the lists by SKU: an older order's are the lower ones."""
    line = lines.begin[lines.listed_order[at]]
    while not 0 <= at - lines.first[lines.sku[line]] < lines.number[lines.sku[line]]:
        line += 1
    return line  # type: ignore[no-any-return]


@helper
def fits(p: Period, order: int, quantity: int, station: int) -> bool:
    """Return whether a line that is not taken fits the free slots of a station."""
    if not (p.numbers[PACKING_ROOM] > 0 or p.split[order] or p.lines.open_lines[order] == 1):
        return False
    there = p.stations[station]
    if there["counts_orders"]:
        return bool(there["free"] > 0 or p.placed[station, order])
    return bool(quantity <= there["free"])


@helper
def worth_of(p: Period, order: int, seconds: float, share: float, bound: float) -> float:
    """Return the worth of a line of so many seconds; -1 where it is certainly less than ``bound``.

    Then no power is worked out, which takes longer than all else: its order has this line's share of a visit left, and
    the seconds to handle all its items, or more; and its due time makes it worth ``due_factor`` times more at most.
    """
    if p.power[order] == 0.0:
        weights, factor = p.weights, priority_factor(p, order)
        if p.lines.due_s[order] < np.inf:
            factor *= weights.due_factor
        least = weights.least[min(int(weights.handle_s * p.lines.items[order] + share), len(weights.least) - 1)]
        if seconds * ((1 + CLOSE) * factor) < bound * least:
            return -1.0
        look_at(p, order)
    return seconds / p.power[order]  # type: ignore[no-any-return]


@helper
def better_line(p: Period, station: int, sku: int, more_than: int, best: int, most: float) -> tuple[int, float]:
    """Return the best of a line and the lines of a SKU that a station covers, `NONE` for none, and its worth.

    That is the line of the largest worth, the oldest of equals, of those that want more items than ``more_than``.
    """
    lines, handle_s = p.lines, p.weights.handle_s
    here, share = p.available[sku, station], p.share[sku]
    for at in range(lines.first[sku], lines.first[sku] + lines.number[sku]):
        quantity, order = p.items[at], lines.listed_order[at]
        if quantity and more_than < quantity <= here and fits(p, order, quantity, station):
            seconds = handle_s * quantity + share
            w = worth_of(p, order, seconds, share, most)
            if (w >= 0 and best == NONE) or w > most or (w == most and line_of(lines, at) < line_of(lines, best)):
                best, most = at, w
    return best, most


@njit(cache=True, interpreted=True)
def best_covered(p: Period, station: int) -> tuple[int, float]:
    """Return the line of the largest worth that the pods of a station cover, `NONE` for none, and its worth."""
    best, most = NONE, 0.0
    for sku in p.wanted:
        if p.available[sku, station] > 0:
            best, most = better_line(p, station, sku, 0, best, most)
    return best, most
