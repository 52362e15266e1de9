"""Code shared by compiled searches for paths: looks at a reservation table.

A table is what `rmfs_traffic.intervals` describes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core import clock
from rmfs_core.jit import helper
from rmfs_traffic import FOREVER, Intervals, Query, Reservations, Roads

Ints = NDArray[np.int64]

far: Any = helper(clock.far)
"""`rmfs_core.clock.far` in compiled code."""


Plain = tuple[Any, ...]
"""Values of a named tuple. A search that takes a few microseconds is handed plain tuples, and names them itself:
numba takes twice as long to look at named ones."""


class Asked(NamedTuple):
    """A robot that asks for a path, as `rmfs_traffic.Query` has it."""

    me: int
    cell: int
    heading: int
    start: int
    goal: int

    @staticmethod
    def by(query: Query) -> Plain:
        """Return what a query asks."""
        return query.robot, query.cell, query.heading, query.start_tick, query.goal


@helper
def gap_at(cell: int, tick: int, me: int, table: Intervals) -> tuple[int, int]:
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


@helper
def free_for_good(cell: int, me: int, table: Intervals) -> int:
    """Tick from which on nobody else has a cell any more: 0 if nobody does, FOREVER if someone stays."""
    first, count, _, until, owner = table
    for p in range(first[cell] + count[cell] - 1, first[cell] - 1, -1):
        if owner[p] != me:
            return int(until[p])
    return 0


@helper
def crossed(low: Ints, high: Ints, now: int, n: int, cell: int, enter: int, leave: int, table: Intervals) -> bool:
    """Whether a cell has reservations during runs in windows of departure; `narrow` changes nothing if not."""
    first, end = table.first[cell], table.first[cell] + table.count[cell]
    return bool(
        first < end and table.since[first] - leave < high[now, n - 1] and table.until[end - 1] - enter > low[now, 0]
    )


@helper
def narrow(
    low: Ints, high: Ints, now: int, n: int, to: int, cell: int, enter: int, leave: int, me: int, table: Intervals
) -> int:
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
