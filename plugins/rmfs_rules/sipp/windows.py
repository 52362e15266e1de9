"""Windows of departure in which the cells of a run are free."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import helper
from rmfs_traffic import FOREVER, Intervals

Ints = NDArray[np.int64]


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
