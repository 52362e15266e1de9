"""Compiled choices of orders by what they lack; `choosing` says what the arrays are."""

from __future__ import annotations

import numpy as np

from rmfs_core.jit import inlined, njit
from rmfs_rules.joint.covering_search import ENDLESS
from rmfs_rules.joint.lacking_search import (
    BLOCK,
    BLOCKS,
    ITEMS,
    NEVER,
    OUT,
    QUANTITY,
    SKU,
    WHERE,
    change,
    exclude,
    look_through,
    value_of,
)

FREE, CAPACITY, COUNTS, LOAD = range(4)
"""Rows of the stations."""
CHEAPEST, OLDEST = range(2)
"""Which orders go first: those that lack fewest lines for each place that they take, or the oldest."""


@inlined
def may_take(station, stations, until):
    """Whether a station takes orders at its load."""
    return stations[LOAD, station] < until[station]


@inlined
def size_at(items, station, stations, largest):
    """Capacity that an order takes up at a station where it has no place: all, if it is larger than any."""
    if stations[COUNTS, station]:
        return 1
    return stations[CAPACITY, station] if items > largest else items


@inlined
def fits(items, station, stations, until, largest):
    """Whether orders with so many items fit a station that takes any."""
    return size_at(items, station, stations, largest) <= stations[FREE, station] and may_take(station, stations, until)


@inlined
def has_place(place, station, placed):
    """Whether an order has a place at a station that counts orders."""
    found = False
    for pair in range(placed.shape[1]):
        found = found or (placed[0, pair] == place and placed[1, pair] == station)
    return found


@inlined
def order_fits(place, station, stations, until, placed, largest, kept):
    """Whether an order fits a station that takes any."""
    if has_place(place, station, placed):
        return stations[FREE, station] >= 0 and may_take(station, stations, until)
    return fits(kept.orders[ITEMS, place], station, stations, until, largest)


@inlined
def station_of(place, mode, stations, until, placed, largest, kept):
    """Station where an order lacks least, then with the lowest load, then the lowest id; -1 if it fits nowhere."""
    found, best, slot = -1, np.int64(NEVER), kept.orders[WHERE, place]
    for station in range(len(kept.counted)):
        lacks = np.int64(kept.lacks[station, slot])
        if lacks < OUT and order_fits(place, station, stations, until, placed, largest, kept):
            value = lacks if mode == OLDEST else value_of(lacks, station, kept.orders[ITEMS, place], kept.counted)
            if value < best or (value == best and stations[LOAD, station] < stations[LOAD, found]):
                found, best = station, value
    return found


@inlined
def cheapest(stations, until, placed, largest, kept):
    """Place of the order that lacks fewest lines for each place it takes, of equals the oldest; -1 if none fits."""
    value, place = np.int64(NEVER), np.int64(-1)
    for station in range(len(kept.counted)):
        if stations[FREE, station] <= 0 or not may_take(station, stations, until):
            continue
        for block in range(kept.counts[BLOCKS]):
            if kept.value[station, block] > value or not fits(kept.sizes[block], station, stations, until, largest):
                continue
            if kept.value[station, block] < 0:
                look_through(station, block, kept)
            one, who = kept.value[station, block], kept.who[station, block]
            if one < value or (one == value < NEVER and who < place):
                value, place = one, who
    for pair in range(placed.shape[1]):
        who, station = placed[0, pair], placed[1, pair]
        one = value_of(np.int64(kept.lacks[station, kept.orders[WHERE, who]]), station, np.int64(1), kept.counted)
        before = one < value or (one == value < NEVER and who < place)
        if before and order_fits(who, station, stations, until, placed, largest, kept):
            value, place = one, who
    return place


@inlined
def first_with(most, after, stations, until, placed, largest, kept):
    """Place of the oldest order after some place that lacks at most so many lines at a station where it fits, or -1."""
    place = np.int64(NEVER)
    for station in range(len(kept.counted)):
        if stations[FREE, station] <= 0 or not may_take(station, stations, until):
            continue
        for block in range(kept.counts[BLOCKS]):
            if kept.places[block * BLOCK] > place or not fits(kept.sizes[block], station, stations, until, largest):
                continue
            if kept.value[station, block] < 0:
                look_through(station, block, kept)
            if kept.least[station, block] > most or -1 < kept.places[(block + 1) * BLOCK - 1] <= after:
                continue
            for slot in range(block * BLOCK, (block + 1) * BLOCK):
                if kept.lacks[station, slot] <= most and kept.places[slot] > after:
                    place = min(place, kept.places[slot])
                    break
    for pair in range(placed.shape[1]):
        who, station = placed[0, pair], placed[1, pair]
        near = after < who < place and kept.lacks[station, kept.orders[WHERE, who]] <= most
        if near and order_fits(who, station, stations, until, placed, largest, kept):
            place = who
    return place if place < NEVER else np.int64(-1)


@njit(cache=True)
def complete(after, stations, until, placed, largest, kept):
    """Place of the oldest order after some place that lacks nothing at a station where it fits, and the stations.

    The place is -1 if there is no such order.
    """
    place, able = first_with(0, after, stations, until, placed, largest, kept), np.zeros(len(kept.counted), np.bool_)
    for station in range(len(able)):
        if place >= 0 and not kept.lacks[station, kept.orders[WHERE, place]]:
            able[station] = order_fits(place, station, stations, until, placed, largest, kept)
    return place, able


@inlined
def noisiest(noise, stations, until, placed, largest, kept):
    """Place of the order that lacks least, with what it lacks besides by chance, and its station; -1 if none fits."""
    value, place, found = np.int64(NEVER), np.int64(-1), -1
    for one in range(len(noise)):
        for station in range(len(kept.counted)):
            lacks = np.int64(kept.lacks[station, kept.orders[WHERE, one]])
            if noise[one, station] >= value or lacks >= OUT:
                continue
            worth = noise[one, station]
            if lacks:
                worth += value_of(lacks, station, kept.orders[ITEMS, one], kept.counted)
            if worth < value and order_fits(one, station, stations, until, placed, largest, kept):
                value, place, found = worth, np.int64(one), station
    return place, found


@inlined
def give(place, station, kept):
    """Let an order have what it wants at a station, and no other the same."""
    exclude(kept.orders[WHERE, place], OUT, kept)
    for line in range(kept.starts[place], kept.starts[place + 1]):
        sku, quantity, row = kept.lines[SKU, line], kept.lines[QUANTITY, line], len(kept.counted)
        change(station, sku, kept.at[station, sku] - quantity, kept)
        if kept.at[row, sku] < ENDLESS:
            change(row, sku, kept.at[row, sku] - quantity, kept)


@njit(cache=True)
def take(place, station, stations, placed, largest, kept):
    """Let an order be chosen for a station."""
    give(place, station, kept)
    if not has_place(place, station, placed):
        size = size_at(kept.orders[ITEMS, place], station, stations, largest)
        stations[FREE, station] -= size
        stations[LOAD, station] += size


@njit(cache=True)
def station_for(place, mode, stations, until, placed, largest, kept):
    """Do what `station_of` does, for who is not compiled."""
    return station_of(place, mode, stations, until, placed, largest, kept)


@njit(cache=True)
def fill(mode, noise, stations, until, placed, largest, kept):
    """Places and stations of the orders that are chosen until nothing fits, shape (n, 2).

    Without ``noise``, by order and station, ties between stations go to the one with the lowest load.
    """
    chosen = [(np.int64(0), np.int64(0)) for _ in range(0)]
    while True:
        if len(noise):
            place, station = noisiest(noise, stations, until, placed, largest, kept)
        else:
            if mode == OLDEST:
                place = first_with(OUT - 1, -1, stations, until, placed, largest, kept)
            else:
                place = cheapest(stations, until, placed, largest, kept)
            station = station_of(place, mode, stations, until, placed, largest, kept) if place >= 0 else -1
        if place < 0:
            break
        take(place, station, stations, placed, largest, kept)
        chosen.append((place, np.int64(station)))
    pairs = np.empty((len(chosen), 2), np.int64)
    for i in range(len(chosen)):
        pairs[i, 0], pairs[i, 1] = chosen[i]
    return pairs


@njit(cache=True)
def foremost(number, stations, until, placed, largest, kept):
    """Places of the orders that go first, at most so many, as if each were taken where nothing changes by it."""
    places = [np.int64(0) for _ in range(0)]
    while len(places) < number:
        place = cheapest(stations, until, placed, largest, kept)
        if place < 0:
            break
        exclude(kept.orders[WHERE, place], OUT, kept)
        places.append(place)
    return np.array(places, np.int64)
