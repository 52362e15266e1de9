"""Code shared by compiled searches for paths: looks at a reservation table.

A table is what `rmfs_traffic.intervals` describes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rmfs_core import clock
from rmfs_core.jit import helper
from rmfs_traffic.paths import FOREVER, Query
from rmfs_traffic.reservations import Intervals, Reservations
from rmfs_traffic.roads import Roads

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


def search_once(search: Callable[[Roads, Reservations, Query], object], roads: Roads) -> None:
    """Search where nothing is reserved, which loads a compiled search, or compiles it: a rule's `prepare`."""
    locations = roads.layout.storage_locations
    search(roads, Reservations(roads.cells), Query(0, locations[0], 0, 0, locations[-1]))
