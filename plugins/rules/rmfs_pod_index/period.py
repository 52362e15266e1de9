"""What pod-index keeps and works on: all that its compiled parts read and write."""

from __future__ import annotations

from typing import Any, NamedTuple, get_type_hints

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NONE = -1
CLOSE = 1e-9
"""Relative difference up to which two indices count as equal: sums of the same numbers in another order may differ."""


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
    base_ticks: int
    due_factor: float
    due_s: float
    packing: bool
    near: float


class Period(NamedTuple):
    """An account of lines and items that is kept from call to call, and a period under construction.

    Parameters
    ----------
    order, sku, quantity
        Of each line that ever was in the backlog, oldest first: ids of its order and SKU, and items.
    before, after
        Of each open line: the open lines of its SKU that came before and after it; NONE for none.
    untaken
        Of each line: whether it is open and not taken in this period.
    w, q
        Worth and items of the lines that a station might be brought, by SKU.
    takes
        (line, station) taken so far.
    arrival, due_s, worth
        Of each order, by id: when it came, when it is due, how many times more it is worth by its priority.
    begin, end
        Of each order: its lines.
    open_items
        Of each order: items of its lines that are left.
    highest
        Of each order: how many times more it is worth at most, and a trifle.
    left, power, looked
        Of each order: seconds of its lines that are left, below 0 where not needed yet; what the seconds of a line are
        divided by for its worth; the orders for which these are known.
    base, root
        Of each order: a number of seconds, and what it is to the power of ``finish``.
    split, single, ever, parts
        Of each order, where packing stations are full at some number of split orders: whether it is split; has one open
        line; was split before; at how many stations this period has parts of it.
    head, tail, number, arrivals
        Of each SKU: its first and last open line, how many there are, and when their orders came, added up.
    wanted, share, start, stop, there
        The SKUs that have open lines, ascending; of each SKU: seconds of a visit that a line of it has to bear; where
        its lines are in ``w``; what a station had before pods were sent.
    items
        Of each entry of the shelves: free items.
    lines_of, arrivals_of
        Of each pod: how many open lines it has items for, and when their orders came, added up.
    urge, urgent
        Of each pod: the ages of these lines, added up; the pods for which it is enough at some station.
    movable, last, able
        Of each pod: whether it may be sent; the station where it goes last, whose its free items are, NONE for none;
        whether it may be sent to the station whose turn it is.
    values, gaining
        Of each pod: what it brings beyond a rate; the pods that bring anything.
    found, asked
        The pods that are equally good; of each pod, whether it was asked where it is.
    sends
        (pod, station) sent so far.
    available
        Items of each SKU that the pods of each station have free, shape (SKUs, stations).
    room, load, capacity, inbound, counts_orders, open
        Of each station: free places, places that are taken, all places, pods at or bound for it, what its places are
        for, whether it may go on.
    turn
        Stations in the order of the turn.
    placed
        Of each station that counts orders: which orders have a place there, shape (stations, orders).
    least
        So many seconds to the power of ``finish``: what it takes to know what a line could be worth at most.
    numbers
        See below.
    """

    order: Ints
    sku: Ints
    quantity: Ints
    before: Ints
    after: Ints
    untaken: Bools
    w: Floats
    q: Ints
    takes: Ints
    arrival: Ints
    due_s: Floats
    worth: Floats
    begin: Ints
    end: Ints
    open_items: Ints
    highest: Floats
    left: Floats
    base: Floats
    root: Floats
    power: Floats
    looked: Ints
    split: Bools
    single: Bools
    ever: Bools
    parts: Ints
    head: Ints
    tail: Ints
    number: Ints
    arrivals: Ints
    wanted: Ints
    share: Floats
    start: Ints
    stop: Ints
    there: Ints
    items: Ints
    lines_of: Ints
    arrivals_of: Ints
    urge: Ints
    urgent: Ints
    movable: Bools
    last: Ints
    able: Bools
    values: Floats
    gaining: Ints
    found: Ints
    asked: Bools
    sends: Ints
    available: Ints
    room: Ints
    load: Ints
    capacity: Ints
    inbound: Ints
    counts_orders: Bools
    open: Bools
    turn: Ints
    placed: Bools
    least: Floats
    numbers: Ints


TAKES, SENDS, FOUND, LENGTH, AT_WORK, PACKING_ROOM, COMPLETED, WANTED, URGENT, GAINING, LOOKED, NOW, ASKED = range(13)
"""Where in ``Period.numbers`` each number is: how many of ``takes``, ``sends``, ``found``, ``turn``, ``wanted``,
``urgent``, ``gaining`` and ``looked`` there are; whether a station is at work; room at the packing stations; orders of
which all lines are taken; the tick; how many pods were asked where they are."""

OF_LINES = ("order", "sku", "quantity", "before", "after", "untaken", "w", "q", "takes")
OF_ORDERS = (
    "arrival",
    "due_s",
    "worth",
    "begin",
    "end",
    "open_items",
    "highest",
    "left",
    "base",
    "root",
    "power",
    "looked",
)
PACKED = ("split", "single", "ever", "parts")


def new_period(skus: int, pods: int, stations: int, entries: int) -> Period:
    """Return an account without lines, and without items."""
    lengths = dict.fromkeys((*OF_LINES, *OF_ORDERS, *PACKED), 0)
    lengths |= dict.fromkeys(("head", "tail", "number", "arrivals", "wanted", "share", "start", "stop", "there"), skus)
    lengths |= dict.fromkeys(("lines_of", "arrivals_of", "urge", "urgent", "movable", "last", "able"), pods)
    lengths |= dict.fromkeys(("values", "gaining", "found", "asked", "sends"), pods)
    lengths |= dict.fromkeys(("room", "load", "capacity", "inbound", "counts_orders", "open", "turn"), stations)
    lengths |= {"items": entries, "available": skus, "placed": 0, "least": 0, "numbers": 13}
    kinds: dict[Any, Any] = {Ints: np.int64, Floats: np.float64, Bools: np.bool_}
    widths = {"takes": (2,), "sends": (2,), "available": (stations,), "placed": (0,)}
    arrays = {
        name: np.zeros((lengths[name], *widths.get(name, ())), kinds[kind])
        for name, kind in get_type_hints(Period).items()
    }
    for name in ("head", "tail", "last"):
        arrays[name][:] = NONE
    return Period(**arrays)


def with_room(period: Period, names: tuple[str, ...], length: int) -> Period:
    """Return a period in which some arrays are at least so long, with zeros at the end."""
    arrays = {name: getattr(period, name) for name in names}
    if all(len(array) >= length for array in arrays.values()):
        return period
    grown = {name: np.zeros((2 * length + 64, *array.shape[1:]), array.dtype) for name, array in arrays.items()}
    for name, array in arrays.items():
        grown[name][: len(array)] = array
    return with_arrays(period, grown)


def with_arrays(period: Period, arrays: dict[str, NDArray[Any]]) -> Period:
    """Return a period in which some arrays are others."""
    names = Period.__annotations__
    return Period(*(arrays.get(name, array) for name, array in zip(names, period, strict=True)))
