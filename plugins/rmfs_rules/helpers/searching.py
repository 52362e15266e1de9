"""What compiled searches for paths share: looks at a reservation table.

A table is what `rmfs_core.traffic.intervals` describes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from rmfs_core import clock
from rmfs_core.jit import inlined, njit
from rmfs_core.traffic import FOREVER, Query, Reservations, Roads

far: Any = inlined(clock.far)
"""`rmfs_core.clock.far` in compiled code."""


@njit(cache=True)
def last_end(first, count, until):
    """Latest end of an interval that has one; 0 if there is none."""
    latest = 0
    for cell in range(len(first)):
        for p in range(first[cell], first[cell] + count[cell]):
            if until[p] < FOREVER:
                latest = max(latest, until[p])
    return latest


@inlined
def gap_at(cell, tick, me, table):
    """Number and end of the gap of a cell that holds ``tick``; (-1, -1) when another has the cell then."""
    first, count, since, until, owner = table
    p, end = first[cell], first[cell] + count[cell]
    while p < end and (owner[p] == me or until[p] <= tick):
        p += 1
    if p == end:
        return p, FOREVER
    if since[p] <= tick:
        return -1, -1
    return p, since[p]


@inlined
def free_for_good(cell, me, table):
    """Tick from which on nobody else has a cell any more: 0 if nobody does, FOREVER if someone stays."""
    first, count, _, until, owner = table
    for p in range(first[cell] + count[cell] - 1, first[cell] - 1, -1):
        if owner[p] != me:
            return until[p]
    return 0


@inlined
def narrow(low, high, now, n, to, cell, enter, leave, me, table):
    """Narrow windows of departure to those in which a cell is free as well.

    Windows are closed, ascending and disjoint: ``low[now, i]`` to ``high[now, i]`` for the first ``n`` of them. The run
    has the cell from ``enter`` to ``leave`` ticks after its departure. Writes the windows left to rows ``to``, returns
    their number.
    """
    first, count, since, until, owner = table
    m = w = 0
    p, end = first[cell], first[cell] + count[cell]
    free_since = np.int64(-FOREVER)
    while w < n:
        while p < end and owner[p] == me:
            p += 1
        earliest = free_since - enter
        latest = (since[p] if p < end else FOREVER) - leave
        while w < n and high[now, w] < earliest:
            w += 1
        while w < n and low[now, w] <= latest:
            begin, stop = max(low[now, w], earliest), min(high[now, w], latest)
            if begin <= stop:
                low[to, m], high[to, m] = begin, stop
                m += 1
            if high[now, w] > latest:
                break
            w += 1
        if p >= end:
            break
        free_since = until[p]
        p += 1
    return m


def search_once(search: Callable[[Roads, Reservations, Query], object], roads: Roads) -> None:
    """Search where nothing is reserved, which loads a compiled search, or compiles it: a rule's `prepare`."""
    locations = roads.layout.storage_locations
    search(roads, Reservations(roads.cells), Query(0, locations[0], 0, 0, locations[-1]))
