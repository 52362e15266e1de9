"""A period of pod-index under construction, as compiled code reads and changes it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.warehouse import Lines, Stock

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NONE = -1
CLOSE = 1e-9
"""Relative difference up to which two indices count as equal: sums of the same numbers in another order may differ."""

TAKES, SENDS, FOUND, AT_WORK, PACKING_ROOM = range(5)
"""Indices of ``Period.numbers``: lines taken, pods sent, pods in ``found``; whether a station is at work; how many more
split orders the packing stations have room for."""

POWER, WORTH, SECONDS = range(3)
"""Columns of ``Period.orders``: what the seconds of a line are divided by for its worth, 0 until worked out; how many
times more its lines are worth by priority and due time, at most; seconds to handle its open items at the beginning."""


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
    due_factor: float
    due_s: float
    most_pods: int
    urge_ticks: int
    base_ticks: int
    packing: bool  # whether there is a packing_capacity
    priority: Floats  # priority_factor to the power of -20 to 20
    least: Floats  # 0, 1, 2 ... seconds to the power of ``finish``


class Stations(NamedTuple):
    """The picking stations; arrays of shape (stations,)."""

    room: Ints  # free places
    load: Ints  # places that are taken
    capacity: Ints  # all places
    inbound: Ints  # pods at or bound for it
    counts_orders: Ints  # whether its places are for orders: 0 or 1
    going_on: Ints  # whether it may take another turn: 0 or 1


class Pods(NamedTuple):
    """The pods; arrays of shape (pods,), but for the last one."""

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
    placed: Bools  # orders with a place at a station that counts orders; shape (stations, orders), or (stations, 0)
    orders: Floats  # see POWER, shape (orders, 3)
    split: Bools  # whether an order is split; shape (orders,), (0,) without a packing capacity
    parts: Ints  # at how many stations this period takes lines of an order; as ``split``
    ticks: Ints  # driving times to each station, shape (stations, cells)
    takes: Ints  # what was taken: station, order id, SKU; shape (lines, 3)
    sends: Ints  # what was sent: pod, station; shape (pods, 2)
    found: Ints  # pods that are to be sent, shape (pods,)
    numbers: Ints  # see TAKES
