"""Compiled choice of orders by the lines that they lack; `choosing` says what is decided with it."""

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
Pairs = list[tuple[np.int64, np.int64]]

OUT = 1 << 20
"""What is added to the lines that an order lacks once it is chosen, or for each line that stock is too low for."""
SCALE = 1_000_000
"""What a missing line counts at a station that counts orders; at others that divided by the items of the order."""


class Choice(NamedTuple):
    """Stations, pods and orders while orders are chosen one after another: the first five change in place.

    Parameters
    ----------
    at
        Items that the pods of a station have left; below 0, pods will be sent with as many. int64, shape (stations,
        n_skus).
    supply
        Items that all pods together have left, int64, shape (n_skus,), or (0,): unlimited.
    lacks
        Lines of an order that a pod would have to be sent for, by station and place; `OUT` or more of orders that are
        chosen, or that stock is too low for. int32, shape (stations, places).
    free, load
        Free capacity and load of the stations, int64, shape (stations,).
    capacity, counts_orders, until
        Capacity of the stations, whether it is orders, not items, and the load from which on a station takes no more;
        shape (stations,).
    placed
        Whether an order has a place at a station that counts orders, shape (stations, places), or (0, 0): none has.
    largest
        Items of the largest order that fits beside others; a larger one takes all of a station.
    """

    at: Ints
    supply: Ints
    lacks: NDArray[np.int32]
    free: Ints
    load: Ints
    capacity: Ints
    counts_orders: Flags
    until: Floats
    placed: Flags
    largest: float


@inlined
def is_lacking(items: int, quantity: int) -> bool:
    """Whether a pod would have to be sent for a line where pods have so many items left, and for none before it."""
    return 0 <= items < quantity


@inlined
def takes_any(station: int, choice: Choice) -> bool:
    """Whether an order may fit a station."""
    least = 0 if len(choice.placed) else 1
    return bool(choice.free[station] >= least and choice.load[station] < choice.until[station])


@inlined
def size_at(order: int, station: int, lines: Lines, choice: Choice) -> int:
    """Capacity that an order takes up at a station."""
    if choice.counts_orders[station]:
        return 0 if len(choice.placed) and choice.placed[station, order] else 1
    return int(choice.capacity[station] if lines.items[order] > choice.largest else lines.items[order])


@inlined
def fits(order: int, station: int, lines: Lines, choice: Choice) -> bool:
    """Whether an order may be chosen for a station."""
    there = size_at(order, station, lines, choice) <= choice.free[station]
    return bool(there and choice.lacks[station, order] < OUT)


@inlined
def shared_by(order: int, station: int, lines: Lines, choice: Choice) -> int:
    """Places among which the lines that an order lacks are divided."""
    return 1 if choice.counts_orders[station] else int(lines.items[order])


@njit(cache=True)
def begin(lines: Lines, most: int, choice: Choice) -> None:
    """Count what orders lack at the stations that take any; ``most``: more items than this no line has."""
    for station in range(len(choice.at)):
        if not takes_any(station, choice):
            continue
        lacks, items = choice.lacks[station], choice.at[station]
        for order in range(len(lacks)):
            lacks[order] = lines.open_lines[order]
        for sku in range(len(items)):
            if items[sku] != 0:
                for at in range(lines.first[sku], lines.first[sku] + lines.number[sku]):
                    lacks[lines.listed_order[at]] -= not is_lacking(items[sku], lines.listed_items[at])
        for sku in range(len(choice.supply)):
            if choice.supply[sku] < most:
                for at in range(lines.first[sku], lines.first[sku] + lines.number[sku]):
                    lacks[lines.listed_order[at]] += OUT * (choice.supply[sku] < lines.listed_items[at])


@njit(cache=True)
def take(order: int, station: int, lines: Lines, choice: Choice) -> None:
    """Choose an order for a station: no other has the same capacity and items."""
    size = size_at(order, station, lines, choice)
    choice.free[station] -= size
    choice.load[station] += size
    choice.lacks[:, order] += OUT
    for line in range(lines.begin[order], lines.begin[order + 1]):
        sku, quantity = lines.sku[line], lines.quantity[line]
        had = choice.at[station, sku]
        left = choice.at[station, sku] = had - quantity
        listed = range(lines.first[sku], lines.first[sku] + lines.number[sku] * (quantity > 0))
        for at in listed:
            was, now = is_lacking(had, lines.listed_items[at]), is_lacking(left, lines.listed_items[at])
            choice.lacks[station, lines.listed_order[at]] += np.int32(now) - np.int32(was)
        if len(choice.supply):
            had = choice.supply[sku]
            left = choice.supply[sku] = had - quantity
            for at in listed:
                if left < lines.listed_items[at] <= had:
                    choice.lacks[:, lines.listed_order[at]] += OUT


@njit(cache=True)
def take_all(pairs: Ints, lines: Lines, choice: Choice) -> None:
    """Choose orders (place, station), shape (n, 2)."""
    for pair in range(len(pairs)):
        take(pairs[pair, 0], pairs[pair, 1], lines, choice)


@njit(cache=True)
def best(orders: Ints, by_lines: bool, noise: Ints, lines: Lines, choice: Choice) -> tuple[np.int64, int]:
    """Order (place) and station with the fewest missing lines for each place that the order takes; -1, -1: none fits.

    Ties go to the oldest order, then to the station with the lowest load, then to the lowest id.

    Parameters
    ----------
    orders
        Those in question, oldest first.
    by_lines
        Whether lines alone count, not what they are for each place.
    noise
        What they lack besides, in millionths of a line, shape (orders, stations), or (0, 0): nothing.
    lines, choice
        See there.
    """
    found, at, least, end = np.int64(-1), -1, np.int64(1 << 40), len(orders)
    for station in range(len(choice.at)):
        if not takes_any(station, choice):
            continue
        for which in range(end):
            order = orders[which]
            lacks, by_chance = np.int64(choice.lacks[station, order]) * SCALE, np.int64(0)
            if len(noise):
                by_chance = noise[which, station]
            goes_first = order < found or (order == found and choice.load[station] < choice.load[at])
            shared = 1 if by_lines else shared_by(order, station, lines, choice)
            if lacks < (least + goes_first - by_chance) * shared and fits(order, station, lines, choice):
                found, at, least = order, station, lacks // shared + by_chance
                if least == 0:  # no later order goes first
                    end = which + 1
                    break
    return found, at


@njit(cache=True)
def fill(orders: Ints, oldest: bool, noise: Ints, lines: Lines, choice: Choice) -> Pairs:
    """Choose orders until nothing fits: the `best`, or the oldest that fits any; return them (place, station)."""
    chosen = [(np.int64(0), np.int64(0)) for _ in range(0)]
    while True:
        order, at = np.int64(-1), -1
        if oldest:
            for which in range(len(orders)):
                order, at = best(orders[which : which + 1], True, noise, lines, choice)
                if at >= 0:
                    break
        else:
            order, at = best(orders, False, noise, lines, choice)
        if at < 0:
            return chosen
        take(order, at, lines, choice)
        chosen.append((order, np.int64(at)))


@njit(cache=True)
def complete(orders: Ints, lines: Lines, choice: Choice) -> tuple[int, list[int]]:
    """Return the index of the first of some orders that lacks nothing at stations where it fits, and these stations."""
    first, stations = len(orders), [0 for _ in range(0)]
    for station in range(len(choice.at)):
        if takes_any(station, choice):
            for which in range(first + 1 if first < len(orders) else first):
                if choice.lacks[station, orders[which]] == 0 and fits(orders[which], station, lines, choice):
                    if which < first:
                        stations.clear()
                    first = which
                    stations.append(station)
                    break
    return first, stations
