"""Worth of the lines of a period, and the best line that a station covers; compiled."""

from __future__ import annotations

from math import exp

import numpy as np

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.jit import inlined, njit
from rmfs_core.warehouse import Lines, Stock
from rmfs_rules.pod_index.period import CLOSE, NONE, PACKING_ROOM, POWER, SECONDS, WORTH, Floats, Ints, Period, Weights

MOST_STEPS = 20
"""Priorities of more steps count as so many."""


@njit(cache=True)
def share_visits(wanted: Ints, stock: Stock, available: Ints, number: Ints, cost_s: float) -> Floats:
    """Return seconds of a visit for each line of a SKU that no station has; 0 for other SKUs.

    That is ``cost_s`` to the lines on the pod with most of them that has the SKU; ``number`` has them by pod.
    """
    share = np.zeros(len(available))
    for sku in wanted:
        most, here = 0, False
        for station in range(available.shape[1]):
            here = here or available[sku, station] > 0
        if not here:
            for k in range(stock.of_sku[sku], stock.of_sku[sku + 1]):
                entry = stock.by_sku[k]
                if stock.items[entry] > 0:
                    most = max(most, number[stock.pod[entry]])
        if most > 0:
            share[sku] = cost_s / most
    return share


@njit(cache=True)
def bound_orders(lines: Lines, weights: Weights) -> Floats:
    """Return `Period.orders` before any power is worked out."""
    orders = np.zeros((len(lines.items), 3))
    for order in range(len(orders)):
        steps = min(max(lines.priority[order], -MOST_STEPS), MOST_STEPS)
        worth = weights.priority[steps + MOST_STEPS]
        orders[order, WORTH] = worth * weights.due_factor if lines.due_s[order] < np.inf else worth
        orders[order, SECONDS] = weights.handle_s * lines.items[order]
    return orders


@inlined
def look_at(p: Period, order: int) -> float:
    """Work out the power of an order; return the seconds of the lines that it has left."""
    weights, lines, seconds = p.weights, p.lines, 0.0
    factor = weights.priority[min(max(lines.priority[order], -MOST_STEPS), MOST_STEPS) + MOST_STEPS]
    for line in range(lines.begin[order], lines.begin[order + 1]):
        if p.quantity[line]:
            seconds += weights.handle_s * p.quantity[line] + p.share[lines.sku[line]]
    if lines.due_s[order] < np.inf:
        slack_s = max(lines.due_s[order] - p.now / TICKS_PER_S, 0.0)
        factor = (1.0 + (weights.due_factor - 1.0) * exp(-slack_s / weights.due_s)) * factor
    p.orders[order, POWER] = seconds**weights.finish / factor
    return seconds


@njit(cache=True, _nrt=False)
def line_of(lines: Lines, at: int) -> int:
    """Return the line at a position in the lists by SKU: an older order's are the lower ones."""
    line = lines.begin[lines.listed_order[at]]
    while not 0 <= at - lines.first[lines.sku[line]] < lines.number[lines.sku[line]]:
        line += 1
    return line  # type: ignore[no-any-return]


@inlined
def fits(p: Period, order: int, quantity: int, station: int) -> bool:
    """Return whether a line that is not taken fits the free places of a station."""
    if p.weights.packing and not (p.split[order] or p.lines.open_lines[order] == 1 or p.numbers[PACKING_ROOM] > 0):
        return False
    if p.stations.counts_orders[station]:
        return p.stations.room[station] > 0 or p.placed[station, order]  # type: ignore[no-any-return]
    return quantity <= p.stations.room[station]  # type: ignore[no-any-return]


@inlined
def worth_of(p: Period, order: int, seconds: float, share: float, bound: float) -> float:
    """Return the worth of a line of so many seconds; -1 where it is certainly less than ``bound``.

    Then no power is worked out, which takes longer than all else: its order has this line's share of a visit left, and
    the seconds to handle all its items, or more.
    """
    o = p.orders[order]
    if o[POWER] == 0.0:
        least = p.weights.least
        if seconds * ((1 + CLOSE) * o[WORTH]) < bound * least[min(int(o[SECONDS] + share), len(least) - 1)]:
            return -1.0
        look_at(p, order)
    return seconds / o[POWER]  # type: ignore[no-any-return]


@inlined
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


@njit(cache=True)
def best_covered(p: Period, station: int) -> tuple[int, float]:
    """Return the line of the largest worth that the pods of a station cover, `NONE` for none, and its worth."""
    best, most = NONE, 0.0
    for sku in p.wanted:
        if p.available[sku, station] > 0:
            best, most = better_line(p, station, sku, 0, best, most)
    return best, most
