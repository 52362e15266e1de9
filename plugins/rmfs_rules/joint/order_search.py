"""Compiled choice of orders by the lines that they lack; `choosing` says what is decided with it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import helper, njit
from rmfs_core.warehouse import Lines

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Pairs = list[tuple[np.int64, np.int64]]

OUT = 1 << 20
"""Addition to the lines that an order lacks once it is chosen, or for each line that stock is too low for."""
SCALE = 1_000_000
"""Weight of a missing line at a station that counts orders; at others that divided by the items of the order."""


class Choice(NamedTuple):
    """Orders, stations and pods while orders are chosen one after another; ``at`` to ``stations`` change in place.

    Parameters
    ----------
    lines
        The orders, which stay as they are.
    at
        Items that the pods of a station have left; below 0, pods will be sent with as many. int64, shape (stations,
        n_skus).
    supply
        Items that all pods together have left, int64, shape (n_skus,), or (0,): unlimited.
    lacks
        Lines of an order that a pod would have to be sent for, by station and row; `OUT` or more of orders that are
        chosen, or that stock is too low for. Whatever at a station that takes none. int32, shape (stations, rows).
    stations
        The stations by id, as `WarehouseView.capacities` has them.
    until
        Load from which on a station takes no more, float64, shape (stations,).
    placed
        Whether an order has a slot at a station that counts orders, shape (stations, orders), or (stations, 0): none.
    largest
        Items of the largest order that fits together with others; a larger one takes all of a station.
    """

    lines: Lines
    at: Ints
    supply: Ints
    lacks: NDArray[np.int32]
    stations: NDArray[np.void]
    until: Floats
    placed: Flags
    largest: float


@helper
def is_lacking(items: int, quantity: int) -> bool:
    """Whether a pod would have to be sent for a line where pods have so many items left, and for none before it."""
    return 0 <= items < quantity


@helper
def takes_any(station: int, c: Choice) -> bool:
    """Whether an order may fit a station."""
    there = c.stations[station]
    return bool(there["free"] >= int(not c.placed.shape[1]) and there["load"] < c.until[station])


@helper
def size_at(order: int, station: int, c: Choice) -> int:
    """Capacity that an order takes up at a station."""
    if c.stations[station]["counts_orders"]:
        return int(not (c.placed.shape[1] and c.placed[station, order]))
    return int(c.stations[station]["capacity"] if c.lines.items[order] > c.largest else c.lines.items[order])


@helper
def fits(order: int, station: int, c: Choice) -> bool:
    """Whether an order may be chosen for a station."""
    return bool(size_at(order, station, c) <= c.stations[station]["free"] and c.lacks[station, order] < OUT)


@njit(cache=True, interpreted=True)
def take(order: int, station: int, c: Choice) -> None:
    """Choose an order for a station: no other has the same capacity and items."""
    lines, size = c.lines, size_at(order, station, c)
    c.stations[station]["free"] -= size
    c.stations[station]["load"] += size
    c.lacks[:, order] += OUT
    for line in range(lines.begin[order], lines.begin[order + 1]):
        sku, quantity = lines.sku[line], lines.quantity[line]
        listed = range(lines.first[sku], lines.first[sku] + lines.number[sku] * (quantity > 0))
        had = c.at[station, sku]
        left = c.at[station, sku] = had - quantity
        for at in listed:
            was, now = is_lacking(had, lines.listed_items[at]), is_lacking(left, lines.listed_items[at])
            c.lacks[station, lines.listed_order[at]] += np.int32(now) - np.int32(was)
        if len(c.supply):
            had = c.supply[sku]
            left = c.supply[sku] = had - quantity
            for at in listed:
                if left < lines.listed_items[at] <= had:
                    c.lacks[:, lines.listed_order[at]] += OUT


@njit(cache=True, interpreted=True)
def begin(chosen: Ints, most: int, c: Choice) -> None:
    """Count what orders lack at the stations that take any, once some (row, station) are chosen.

    ``most``: more items than this no line has.
    """
    lines = c.lines
    for station in range(len(c.at)):
        if takes_any(station, c):
            lacks, items = c.lacks[station], c.at[station]
            lacks[:] = lines.open_lines
            for sku in range(len(items)):
                if items[sku] != 0:
                    for at in range(lines.first[sku], lines.first[sku] + lines.number[sku]):
                        lacks[lines.listed_order[at]] -= not is_lacking(items[sku], lines.listed_items[at])
            for sku in range(len(c.supply)):
                if c.supply[sku] < most:
                    for at in range(lines.first[sku], lines.first[sku] + lines.number[sku]):
                        lacks[lines.listed_order[at]] += OUT * (c.supply[sku] < lines.listed_items[at])
    for pair in range(len(chosen)):
        take(chosen[pair, 0], chosen[pair, 1], c)


@njit(cache=True, interpreted=True)
def best(orders: Ints, by_lines: bool, noise: Ints, c: Choice) -> tuple[np.int64, int]:
    """Order (row) and station with the fewest missing lines for each slot that the order takes; -1, -1: none fits.

    Ties go to the oldest order, then to the station with the lowest load, then to the lowest id.

    Parameters
    ----------
    orders
        Those in question, oldest first.
    by_lines
        Whether lines alone count, not what they are for each slot.
    noise
        Noise added to what they lack, in millionths of a line, shape (orders, stations), or (0, 0): nothing.
    c
        See there.
    """
    found, at, least, end = np.int64(-1), -1, np.int64(1 << 40), len(orders)
    for station in range(len(c.at)):
        there = c.stations[station]
        if not takes_any(station, c):
            continue
        for which in range(end):
            order = orders[which]
            lacks, by_chance = np.int64(c.lacks[station, order]) * SCALE, np.int64(0)
            if len(noise):
                by_chance = noise[which, station]
            goes_first = order < found or (order == found and there["load"] < c.stations[at]["load"])
            shared = 1 if by_lines or there["counts_orders"] else int(c.lines.items[order])
            if lacks < (least + goes_first - by_chance) * shared and fits(order, station, c):
                found, at, least = order, station, lacks // shared + by_chance
                if least == 0:  # no later order goes first
                    end = which + 1
                    break
    return found, at


@njit(cache=True, interpreted=True)
def fill(orders: Ints, oldest: bool, noise: Ints, c: Choice) -> Pairs:
    """Choose orders until nothing fits: the `best`, or the oldest that fits any; return them (row, station)."""
    chosen = [(np.int64(0), np.int64(0)) for _ in range(0)]
    for which in range(len(orders)):
        order, at = best(orders[which : which + 1] if oldest else orders, oldest, noise, c)
        if at >= 0:
            take(order, at, c)
            chosen.append((order, np.int64(at)))
        elif not oldest:
            break
    return chosen


@njit(cache=True, interpreted=True)
def complete(orders: Ints, c: Choice) -> tuple[int, list[int]]:
    """Return the index of the first of some orders that lacks nothing at stations where it fits, and these stations."""
    for which in range(len(orders)):
        order = orders[which]
        for at in range(len(c.at)):
            if c.lacks[at, order] == 0 and fits(order, at, c):
                return which, [at for at in range(at, len(c.at)) if c.lacks[at, order] == 0 and fits(order, at, c)]
    return len(orders), [0 for _ in range(0)]
