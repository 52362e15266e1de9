"""Compiled search for the best order of a station; `pairs` says what is decided with it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import inlined, njit

if TYPE_CHECKING:
    from rmfs_core.warehouse import Lines

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


class Space(NamedTuple):
    """What a station has space for.

    Parameters
    ----------
    room, free
        Capacity for any order, and for those that the pod which stands there can complete; items, or orders. Below 0:
        not even for an order that has a place there.
    capacity
        Of the empty station.
    largest
        Items of the largest order that fits any station; a larger one fits an empty station.
    counts_orders
        Whether capacity is orders, not items.
    """

    room: int
    free: int
    capacity: int
    largest: float
    counts_orders: bool


class Order(NamedTuple):
    """In which order orders go that have the same score, and which do not go at all; all by place.

    Parameters
    ----------
    taken
        Those that are assigned already, shape (orders,).
    first
        Those that go before all others, shape (orders,), or (0,): none.
    rank
        The lowest goes first, shape (orders,), or (0,): the oldest goes first.
    """

    taken: Flags
    first: Flags
    rank: Floats


class Counts(NamedTuple):
    """What SKUs count at a station.

    An order scores the sum over its open lines of min(items, ``most`` of the SKU), and `SHARE` times the share of its
    open lines whose SKU is in ``shares``: less than an item.

    Parameters
    ----------
    most
        By SKU, shape (n_skus,), or (0,): nothing counts.
    shares
        1 or 0 by SKU, shape (n_skus,), or (0,): none.
    """

    most: Ints
    shares: Ints


SHARE = 0.5
"""What an order counts all of whose lines are in `Counts.shares`."""


@inlined
def fits(lines: Lines, place: int, free: int, space: Space, placed: Flags) -> bool:
    """Whether an order fits a station with so much capacity free; ``placed``: the orders that have a place there."""
    items = lines.items[place]
    if items == 0:
        return False
    if space.counts_orders:
        return free >= (0 if len(placed) and placed[place] else 1)
    return items <= free or (items > space.largest and 0 < free == space.capacity)


@inlined
def goes_before(place: int, other: int, scores: Floats, order: Order) -> bool:
    """Whether an order goes before another (-1: none): ``first``, score, rank, age."""
    if other < 0:
        return True
    if len(order.first) and order.first[place] != order.first[other]:
        return bool(order.first[place])
    if scores[place] != scores[other]:
        return bool(scores[place] > scores[other])
    if len(order.rank) and order.rank[place] != order.rank[other]:
        return bool(order.rank[place] < order.rank[other])
    return place < other


@inlined
def score_of(lines: Lines, place: int, counts: Counts) -> float:
    """Score of one order."""
    score: float = 0.0
    shared: float = 0.0
    for line in range(lines.begin[place], lines.begin[place + 1]):
        if len(counts.most):
            score += min(lines.quantity[line], counts.most[lines.sku[line]])
        if len(counts.shares) and lines.quantity[line] > 0:
            shared += counts.shares[lines.sku[line]]
    return float(score + SHARE * (shared / lines.open_lines[place]))


@inlined
def best_of(
    lines: Lines, places: Ints, scores: Floats, order: Order, free: int, space: Space, placed: Flags, best: int
) -> int:
    """Of an order and those at some places that fit, the one that goes first."""
    for place in places:
        fitting = scores[place] >= 0 and not order.taken[place] and fits(lines, place, free, space, placed)
        if fitting and goes_before(place, best, scores, order):
            best = place
    return best


@inlined
def best_of_all(lines: Lines, scores: Floats, order: Order, space: Space, placed: Flags, best: int) -> int:
    """Of an order and all that fit, the one that goes first, where those with a score have been looked at."""
    for place in range(len(lines.items)):
        if not order.taken[place] and fits(lines, place, space.room, space, placed):
            if goes_before(place, best, scores, order):
                best = place
            if not len(order.first) and not len(order.rank):
                break  # the oldest of those that score nothing
    return best


@inlined
def score_all(lines: Lines, counts: Counts, scores: Floats, scored: Ints) -> int:
    """Add up the scores of the orders that score anything; note their places, and return how many there are."""
    number = 0
    for sku in range(len(counts.shares)):
        if counts.shares[sku] > 0:
            for at in range(lines.first[sku], lines.first[sku] + lines.number[sku]):
                place = lines.listed_order[at]
                if scores[place] == 0:
                    scored[number] = place
                    number += 1
                scores[place] += counts.shares[sku]
    for place in scored[:number]:
        scores[place] = SHARE * (scores[place] / lines.open_lines[place])
    for sku in range(len(counts.most)):
        most = counts.most[sku]
        if most > 0:
            for at in range(lines.first[sku], lines.first[sku] + lines.number[sku]):
                place = lines.listed_order[at]
                if scores[place] == 0:
                    scored[number] = place
                    number += 1
                scores[place] += min(lines.listed_items[at], most)
    return number


@inlined
def listed(lines: Lines, counts: Counts) -> int:
    """Number of open lines of the SKUs that count."""
    number = 0
    for sku in range(len(counts.most)):
        if counts.most[sku] > 0:
            number += lines.number[sku]
    for sku in range(len(counts.shares)):
        if counts.shares[sku] > 0:
            number += lines.number[sku]
    return number


@njit(cache=True)
def best_by_score(
    lines: Lines, scores: Floats, order: Order, space: Space, placed: Flags, completed: Ints
) -> tuple[int, float]:
    """Place and score of the order that goes first at a station, of those with a score of 0 or more; -1: none fits.

    Parameters
    ----------
    lines
        The open lines.
    scores
        By place, shape (orders,).
    order
        What goes first of those with the same score.
    space, placed
        What fits; `fits`.
    completed
        Places of the orders that the pod at the station can complete.
    """
    best = best_of(lines, np.arange(len(scores)), scores, order, space.room, space, placed, -1)
    best = best_of(lines, completed, scores, order, space.free, space, placed, best)
    return best, scores[best] if best >= 0 else 0.0


@njit(cache=True)
def best_by_sku(
    lines: Lines, counts: Counts, zeros: Floats, order: Order, space: Space, placed: Flags, completed: Ints
) -> tuple[int, float]:
    """As `best_by_score`, where an order scores what its SKUs count.

    Only orders are scored that score anything: those in the lists of the SKUs that count. ``zeros`` are by place,
    before and afterwards.
    """
    scores, number, best = zeros, 0, -1
    for_all = space.room > 0 or len(placed) > 0
    scored = np.empty((listed(lines, counts) if for_all else 0) + len(completed), np.int64)
    if for_all:
        number = score_all(lines, counts, scores, scored)
        best = best_of(lines, scored[:number], scores, order, space.room, space, placed, best)
    for place in completed:
        if scores[place] == 0:
            scores[place] = score_of(lines, place, counts)
            scored[number] = place
            number += 1
    best = best_of(lines, completed, scores, order, space.free, space, placed, best)
    if for_all and (best < 0 or scores[best] == 0 or (len(order.first) and not order.first[best])):
        best = best_of_all(lines, scores, order, space, placed, best)
    found = best, scores[best] if best >= 0 else 0.0
    for place in scored[:number]:
        scores[place] = 0
    return found


@njit(cache=True)
def best_by_skus(
    lines: Lines, table: Counts, zeros: Floats, order: Order, spaces: Ints, largest: float, placed: Flags,
    completed: Ints, ends: Ints,
) -> tuple[Ints, Floats]:  # fmt: skip
    """As `best_by_sku`, for several stations at once: places, and scores, shape (stations asked for,).

    Parameters
    ----------
    lines, zeros, order
        See there.
    table
        What SKUs count at all stations, shapes (stations, n_skus), or (stations, 0).
    spaces
        Id of each station asked for, and its `Space`: room, free, capacity, and whether it counts orders; shape
        (stations asked for, 5).
    largest
        The same for all.
    placed
        Orders that have a place there, shape (stations asked for, orders), or (.., 0): none has any anywhere.
    completed, ends
        Orders that the pod at each of these stations can complete, one after another, and where those of each end.
    """
    places, scores, begin = np.empty(len(spaces), np.int64), np.empty(len(spaces), np.float64), 0
    for i in range(len(spaces)):
        at = spaces[i, 0]
        space = Space(spaces[i, 1], spaces[i, 2], spaces[i, 3], largest, spaces[i, 4] != 0)
        counts = Counts(table.most[at], table.shares[at])
        there = completed[begin : ends[i]]
        places[i], scores[i] = best_by_sku(lines, counts, zeros, order, space, placed[i], there)
        begin = ends[i]
    return places, scores


@njit(cache=True)
def completed_by(lines: Lines, sku: Ints, items: Ints) -> Ints:
    """Places of the orders of which all open lines can be served with so many items of SKUs, each SKU once."""
    enough, found = np.zeros(len(lines.items), np.int32), [np.int64(0) for _ in range(0)]
    for entry in range(len(sku)):
        first = lines.first[sku[entry]]
        for at in range(first, first + lines.number[sku[entry]]):
            if lines.listed_items[at] <= items[entry]:
                place = lines.listed_order[at]
                enough[place] += 1
                if enough[place] == lines.open_lines[place]:
                    found.append(place)
    places = np.empty(len(found), np.int64)
    for i in range(len(found)):
        places[i] = found[i]
    return places
