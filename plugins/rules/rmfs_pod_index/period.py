"""What a period of pod-index consists of: all that its compiled parts read and write."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NONE = -1


class Shelves(NamedTuple):
    """Which pods have which SKUs; it never changes in a run.

    Parameters
    ----------
    first, sku
        Where the entries of pod p begin (those of the next one begin where they end), and the SKU id of each.
    pod
        Pod id of each entry.
    first_with, by_sku
        Where in ``by_sku`` the entries of SKU i begin.
    """

    first: Ints
    sku: Ints
    pod: Ints
    first_with: Ints
    by_sku: Ints


class Weights(NamedTuple):
    """Parameters of the rule, as its class explains them."""

    handle_s: float
    cost_s: float
    finish: float
    visit_s: float
    stay: float
    elsewhere: float
    most_pods: int
    urge_ticks: int
    full: float
    packing: bool
    near: float


class Period(NamedTuple):
    """A period under construction: what there is to take and to send, and what was so far.

    Parameters
    ----------
    order, sku, quantity
        Of each open line of the backlog, oldest order first: its order's position, SKU id and items.
    age
        Of each order: ticks since it came, and what a line counts besides; empty where no pod waits for that.
    factor
        Of each order: how many times a line of it is worth more; empty where all are equal.
    by_sku, first, wanted
        The lines sorted by SKU; where those of SKU i begin; the SKUs that have any, ascending.
    share
        Of each SKU: seconds of a visit that a line of it has to bear.
    left
        Of each order: seconds of its lines that are left; below 0 where not needed yet.
    power
        Of each order: what the seconds of a line are divided by for its worth.
    open_items
        Of each order: items of its lines that are left.
    least
        What ``power`` is at least where so many items are left, were all lines worth as much; by number of items.
    untaken
        Of each line: whether it may be taken.
    items
        Of each entry of the shelves: free items.
    movable
        Of each pod: whether it may be sent.
    last
        Of each pod: the station where it goes last, whose its free items are; NONE for none.
    ages, urge
        Of each SKU, the ages of its lines that are left, added up; of each pod, those of its SKUs. Not known before
        ``numbers`` says so.
    available
        Items of each SKU that the pods of each station have free, shape (stations, SKUs).
    room, load, capacity, inbound, counts_orders, open
        Of each station: free places, places that are taken, all places, pods at or bound for it, what its places are
        for, whether it may go on.
    placed
        Of each station that counts orders: which orders have a place there, shape (stations, orders).
    split, single, before, parts
        Of each order, where packing stations are full at some number of split orders: whether it is split; has one open
        line; was split before; at how many stations this period has parts of it.
    turn
        Stations in the order of the turn.
    takes, sends, found
        (line, station) taken and (pod, station) sent so far; pods that are equally good.
    numbers
        Numbers: takes, sends, found, length of the turn, whether a station is at work, room at the packing stations,
        orders of which all lines are taken, whether ``ages`` and ``urge`` are known.
    """

    order: Ints
    sku: Ints
    quantity: Ints
    age: Ints
    factor: Floats
    by_sku: Ints
    first: Ints
    wanted: Ints
    share: Floats
    left: Floats
    power: Floats
    open_items: Ints
    least: Floats
    untaken: Bools
    items: Ints
    movable: Bools
    last: Ints
    ages: Ints
    urge: Ints
    available: Ints
    room: Ints
    load: Ints
    capacity: Ints
    inbound: Ints
    counts_orders: Bools
    open: Bools
    placed: Bools
    split: Bools
    single: Bools
    before: Bools
    parts: Ints
    turn: Ints
    takes: Ints
    sends: Ints
    found: Ints
    numbers: Ints


TAKES, SENDS, FOUND, LENGTH, AT_WORK, PACKING_ROOM, COMPLETED, URGES = range(8)
"""Where in ``Period.numbers`` each number is."""
