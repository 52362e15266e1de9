"""Compiled search for the best pair of order and station; `pairs` says what is decided with it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import helper, njit
from rmfs_core.warehouse import Lines

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

HEAD = np.dtype([(name, np.int64) for name in ("known", "row", "pod")] + [("score", np.float64)])
"""Which order goes first at a station.

``row``: that order, by row (-1: none fits), and ``score``: what it scores there, where it is ``known``; else
`best_pair` looks anew. ``pod``: that which stands there, -1 for none, where capacity is kept for what it completes.
"""


class Stations(NamedTuple):
    """The stations in one decision.

    Parameters
    ----------
    capacities
        Of each, by id, `CAPACITY`, shape (stations,); ``free`` below 0: not even orders fit that take up none.
    heads
        Each by id, `HEAD`, shape (stations,).
    largest
        Items of the largest order that fits any station; a larger one fits an empty station.
    extra
        Addition of each station to the scores of all orders, float64, shape (stations,).
    placed
        Orders that have a slot there, by row, shape (stations, orders), or (stations, 0): none anywhere.
    kept
        Capacity that a station with something to do keeps for what the pod that stands there completes.
    coming
        Whether the pod that stands at a station (row) comes to another (column), or (0, 0): no capacity is kept.
    of_pod, sku, left
        Entries of the stock as `Stock` has them, and items of each that are not taken in this decision; shape (0,) if
        no capacity is kept.
    """

    capacities: NDArray[np.void]
    heads: NDArray[np.void]
    largest: int
    extra: Floats
    placed: Flags
    kept: int
    coming: Flags
    of_pod: Ints
    sku: Ints
    left: Ints


class Precedence(NamedTuple):
    """In which order orders go that have the same score, and which do not go at all; all by row.

    Parameters
    ----------
    taken
        Orders that are assigned already, shape (orders,).
    first
        Orders that go before all others, shape (orders,), or (0,): none.
    rank
        The lowest goes first, shape (orders,), or (0,): the oldest goes first.
    """

    taken: Flags
    first: Flags
    rank: Floats


class Scores(NamedTuple):
    """Scores of orders at stations.

    An order scores the sum over its open lines of min(items, ``table`` of the SKU), or what is ``given``.

    Parameters
    ----------
    table
        By SKU, shape (stations, n_skus), or (stations, 0): nothing counts.
    given
        By row, below 0: never there; shape (stations, orders), or (stations, 0): the sums.
    zeros
        By row, before and after each search.
    """

    table: Ints
    given: Floats
    zeros: Floats


@helper
def room(at: int, stations: Stations) -> int:
    """Capacity for any order: all that is free, except for what a station with something to do keeps."""
    free = int(stations.capacities[at]["free"])
    return min(free, max(free - stations.kept, 0)) if stations.capacities[at]["load"] else free


@helper
def size_at(lines: Lines, row: int, at: int, stations: Stations) -> int:
    """Capacity that an order takes up at a station."""
    if stations.capacities[at]["counts_orders"]:
        return 0 if stations.placed.shape[1] and stations.placed[at, row] else 1
    items = lines.items[row]
    return int(stations.capacities[at]["capacity"] if items > stations.largest else items)


@helper
def fits(lines: Lines, row: int, at: int, free: int, stations: Stations) -> bool:
    """Whether an order fits a station with so much capacity free."""
    return bool(lines.items[row] > 0 and free >= 0 and size_at(lines, row, at, stations) <= free)


@helper
def goes_before(row: int, other: int, scores: Floats, order: Precedence) -> bool:
    """Whether an order goes before another (-1: none): ``first``, score, rank, age."""
    if other < 0:
        return True
    if len(order.first) and order.first[row] != order.first[other]:
        return bool(order.first[row])
    if scores[row] != scores[other]:
        return bool(scores[row] > scores[other])
    if len(order.rank) and order.rank[row] != order.rank[other]:
        return bool(order.rank[row] < order.rank[other])
    return row < other


@helper
def best_of(
    lines: Lines, rows: Ints, scores: Floats, order: Precedence, at: int, free: int, stations: Stations, best: int
) -> int:
    """Of an order and those at some rows that fit, the one that goes first."""
    for row in rows:
        if scores[row] >= 0 and not order.taken[row] and fits(lines, row, at, free, stations):
            best = row if goes_before(row, best, scores, order) else best
    return best


@helper
def score_of(lines: Lines, row: int, at: int, scores: Scores) -> float:
    """Score of one order at a station."""
    if scores.given.shape[1]:
        return float(scores.given[at, row])
    score: float = 0.0
    if scores.table.shape[1]:
        for line in range(lines.begin[row], lines.begin[row + 1]):
            score += min(lines.quantity[line], scores.table[at, lines.sku[line]])
    return score


@helper
def score_listed(lines: Lines, scores: Scores, at: int, scored: Ints) -> int:
    """Add up the scores of the orders that score anything; note their rows, and return how many there are."""
    sums, number = scores.zeros, 0
    for sku in range(scores.table.shape[1]):
        most = scores.table[at, sku]
        if most > 0:
            for entry in range(lines.first[sku], lines.first[sku] + lines.number[sku]):
                row = lines.listed_order[entry]
                if sums[row] == 0:
                    scored[number] = row
                    number += 1
                sums[row] += min(lines.listed_items[entry], most)
    return number


@njit(cache=True, interpreted=True)
def completed_by(lines: Lines, stations: Stations, pod: int) -> Ints:
    """Rows of the orders of which all open lines can be served with what is left on a pod."""
    begin, end, number = stations.of_pod[pod], stations.of_pod[pod + 1], 0
    for entry in range(begin, end):
        number += lines.number[stations.sku[entry]]
    served, rows, number = np.zeros(len(lines.items), np.int32), np.empty(number, np.int64), 0
    for entry in range(begin, end):
        first = lines.first[stations.sku[entry]]
        for at in range(first, first + lines.number[stations.sku[entry]]):
            if lines.listed_items[at] <= stations.left[entry]:
                row = lines.listed_order[at]
                served[row] += 1
                if served[row] == lines.open_lines[row]:
                    rows[number] = row
                    number += 1
    return rows[:number]


@njit(cache=True, interpreted=True)
def best_order(lines: Lines, scores: Scores, order: Precedence, at: int, stations: Stations) -> tuple[int, float]:
    """Row and score of the order that goes first at a station; -1: none fits.

    Only orders are scored that score anything: those in the lists of the SKUs that count.
    """
    for_all, free = room(at, stations), stations.capacities[at]["free"]
    if free < 0 or (free == 0 and not stations.placed[at].any()):
        return -1, 0.0
    completed = np.empty(0, np.int64)
    if for_all < free and stations.heads[at]["pod"] >= 0:
        completed = completed_by(lines, stations, stations.heads[at]["pod"])
    if scores.given.shape[1]:
        given = scores.given[at]
        best = best_of(lines, np.arange(len(given)), given, order, at, for_all, stations, -1)
        best = best_of(lines, completed, given, order, at, free, stations, best)
        return best, given[best] if best >= 0 else 0.0
    sums, number, best = scores.zeros, 0, -1
    any_fits = for_all > 0 or stations.placed.shape[1] > 0
    most = len(completed)
    for sku in range(scores.table.shape[1]):
        most += lines.number[sku] * (scores.table[at, sku] > 0)
    scored = np.empty(most, np.int64)
    if any_fits:
        number = score_listed(lines, scores, at, scored)
        best = best_of(lines, scored[:number], sums, order, at, for_all, stations, best)
    for row in completed:
        if sums[row] == 0:
            sums[row] = score_of(lines, row, at, scores)
            scored[number] = row
            number += 1
    best = best_of(lines, completed, sums, order, at, free, stations, best)
    if any_fits and (best < 0 or sums[best] == 0 or (len(order.first) and not order.first[best])):
        for other in range(len(lines.items)):  # orders that score nothing
            if not order.taken[other] and fits(lines, other, at, for_all, stations):
                best = other if goes_before(other, best, sums, order) else best
                if not len(order.first) and not len(order.rank):
                    break  # the oldest of them
    found = best, sums[best] if best >= 0 else 0.0
    for row in scored[:number]:
        sums[row] = 0
    return found


@njit(cache=True, interpreted=True)
def best_pair(lines: Lines, scores: Scores, order: Precedence, stations: Stations) -> tuple[int, int]:
    """Order (row) and station that go next; -1 and -1: nothing fits. Looks at stations whose head is not known."""
    best, best_value = -1, 0.0
    for at in range(len(stations.heads)):
        head = stations.heads[at]
        if not head["known"]:
            head["known"] = 1
            head["row"], head["score"] = best_order(lines, scores, order, at, stations)
        if head["row"] < 0:
            continue
        value = head["score"] + stations.extra[at]
        before = best < 0
        if not before:
            one, other = head["row"], stations.heads[best]["row"]
            if len(order.first) and order.first[one] != order.first[other]:
                before = order.first[one]
            elif value != best_value:
                before = value > best_value
            elif len(order.rank) and order.rank[one] != order.rank[other]:
                before = order.rank[one] < order.rank[other]
            elif one != other:
                before = one < other
            else:
                before = stations.capacities[at]["load"] < stations.capacities[best]["load"]
        if before:
            best, best_value = at, value
    return (stations.heads[best]["row"] if best >= 0 else -1), best


@njit(cache=True, interpreted=True)
def assign(lines: Lines, order: Precedence, stations: Stations, row: int, at: int) -> None:
    """Let a station have an order; pods that come to it serve it, and have less left where they stand now."""
    size = size_at(lines, row, at, stations)
    stations.capacities[at]["free"] -= size
    stations.capacities[at]["load"] += size
    order.taken[row] = True
    for other in range(len(stations.heads)):
        head = stations.heads[other]
        if other == at or head["row"] == row:
            head["known"] = 0
        if len(stations.coming) and stations.coming[other, at]:
            head["known"] = 0
            for entry in range(stations.of_pod[head["pod"]], stations.of_pod[head["pod"] + 1]):
                for line in range(lines.begin[row], lines.begin[row + 1]):
                    if lines.sku[line] == stations.sku[entry]:
                        stations.left[entry] -= lines.quantity[line]


@njit(cache=True, interpreted=True)
def assign_best(told: tuple[tuple[Any, ...], ...], most: int) -> Ints:
    """Assign the best pairs, ``most`` at most; return row and station of each, in this order, shape (pairs, 2).

    ``told`` is what `Lines`, `Scores`, `Precedence` and `Stations` are made of.
    """
    lines, scores, order, stations = Lines(*told[0]), Scores(*told[1]), Precedence(*told[2]), Stations(*told[3])
    chosen, number = np.empty((most, 2), np.int64), 0
    while number < most:
        row, at = best_pair(lines, scores, order, stations)
        if row < 0:
            break
        assign(lines, order, stations, row, at)
        chosen[number, 0], chosen[number, 1] = row, at
        number += 1
    return chosen[:number]


@njit(cache=True, interpreted=True)
def values_of(lines: Lines, scores: Scores, row: int, stations: Stations) -> Floats:
    """Score and ``extra`` of an order at each station where it fits, -inf elsewhere; shape (stations,)."""
    values = np.full(len(stations.heads), -np.inf)
    for at in range(len(values)):
        free, pod = stations.capacities[at]["free"], stations.heads[at]["pod"]
        fitting = fits(lines, row, at, room(at, stations), stations)
        if not fitting and stations.kept > 0 and pod >= 0 and fits(lines, row, at, free, stations):
            fitting = (completed_by(lines, stations, pod) == row).any()
        if fitting:
            values[at] = score_of(lines, row, at, scores) + stations.extra[at]
    return values
