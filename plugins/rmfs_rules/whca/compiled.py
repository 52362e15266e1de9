"""The compiled search behind `rmfs_rules.whca`: A* over (cell, heading, time) at rest, in integer arrays.

A node is a row (cell, heading, time, end of the gap, parent, gap). Nodes are numbered as they are found, and of equally
good ones the older goes first. Of nodes in the same cell and gap with the same heading, less than a wait apart, only
the earliest counts: the others could do hardly anything that it cannot, and there would be countless ones, since runs
take times of all kinds. A robot that may stay where it is has a path always, unless the nodes run out: its chain of
waits reaches the window's end.
"""

from __future__ import annotations

from heapq import heappop, heappush

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import helper, njit
from rmfs_traffic import FOREVER, Intervals, Tracks
from rmfs_traffic.searching import Asked, Plain, far, free_for_good, gap_at

Ints = NDArray[np.int64]

CELL, HEADING, TIME, GAP_END, PARENT, GAP = range(6)


@njit(cache=True, interpreted=True)
def search(asking: Plain, window_end: int, wait: int, max_nodes: int, roads: Plain, taken: Plain) -> Ints | None:
    """Legs of the path found, as rows (end, wait), the last one perhaps a wait alone; None without a path.

    ``asking``, ``roads`` and ``taken`` are what `Asked`, `Tracks` and `Intervals` are made of.
    """
    asked, tracks, table = Asked(*asking), Tracks(*roads), Intervals(*taken)
    cell, heading, start, goal, me, times = asked.cell, asked.heading, asked.start, asked.goal, asked.me, tracks.times
    gap, end = gap_at(cell, start, me, table)
    if gap < 0 or times[cell, heading] >= far(times):
        return None
    # From `settled` on waiting is of no use, and only the first visit of a (cell, heading) counts: the window is over,
    # or nothing changes any more.
    bound, settled = np.int64(0), window_end
    if window_end >= FOREVER:
        bound = free_for_good(goal, me, table)
        if bound >= FOREVER:
            return None
        settled = last_end(table)
    steps = max(settled - start, 0) // wait + 1
    keys, earliest, known = np.full(1024, -1, np.int64), np.empty(1024, np.int64), 0
    nodes = np.empty((1024, 6), np.int64)
    nodes[0] = np.array([cell, heading, start, end, -1, gap])
    n = 1
    queue = [(max(start + times[cell, heading], bound), times[cell, heading], 0)]
    while queue and n < max_nodes:
        _, _, i = heappop(queue)
        at, time = nodes[i, CELL], nodes[i, TIME]
        if nodes[i, GAP_END] >= FOREVER and (at == goal or time >= window_end):
            rows: Ints = _legs(i, nodes)
            return rows
        if time >= window_end:
            continue
        if n + 4 * len(tracks.runs) >= len(nodes):
            larger = np.empty((2 * len(nodes) + 4 * len(tracks.runs), 6), np.int64)
            larger[:n] = nodes[:n]
            nodes = larger
        before = n
        through = at != goal or nodes[i, PARENT] < 0 or tracks.passable[goal]
        if time < settled and time + wait <= nodes[i, GAP_END]:
            _copy(i, n, nodes)
            nodes[n, TIME], nodes[n, PARENT] = time + wait, i
            n += 1
        if through:  # a storage location is no way through for a robot with a pod
            n = _expand(i, n, goal, me, nodes, tracks, table)
        kept = before
        for j in range(before, n):
            time = nodes[j, TIME]
            step = min((time - start) // wait, steps)
            key = np.int64(4 * (nodes[j, GAP] * (steps + 1) + step) + nodes[j, HEADING])
            more = _note(key, time, keys, earliest)
            if more < 0:
                continue
            known += more
            if 2 * known > len(keys):
                keys, earliest = _larger(keys, earliest)
            _copy(j, kept, nodes)
            rest = times[nodes[j, CELL], nodes[j, HEADING]]
            heappush(queue, (max(time + rest, bound), rest, kept))
            kept += 1
        n = kept
    return None


@helper
def _copy(i: int, to: int, nodes: Ints) -> None:
    """Copy a node; quicker than by a row, which is an array of its own."""
    if to != i:
        for column in range(GAP + 1):
            nodes[to, column] = nodes[i, column]


@helper
def _slot(key: int, keys: Ints) -> int:
    """Return the index of a key in a table of twice as many entries as keys, or where it would be."""
    slot = (key * 0x9E3779B1 >> 8) & (len(keys) - 1)
    while keys[slot] >= 0 and keys[slot] != key:
        slot = (slot + 1) & (len(keys) - 1)
    return slot


@helper
def _note(key: int, time: int, keys: Ints, earliest: Ints) -> int:
    """Note the earliest time of a key; returns how many more keys there are, -1 where it was known as early."""
    slot = _slot(key, keys)
    there = keys[slot] == key
    if there and time >= earliest[slot]:
        return -1
    keys[slot], earliest[slot] = key, time
    return 0 if there else 1


@njit(cache=True, interpreted=True)
def _larger(keys: Ints, values: Ints) -> tuple[Ints, Ints]:
    """Return a table of twice the size."""
    more, there = np.full(2 * len(keys), -1, np.int64), np.empty(2 * len(keys), np.int64)
    for i in range(len(keys)):
        if keys[i] >= 0:
            slot = _slot(keys[i], more)
            more[slot], there[slot] = keys[i], values[i]
    return more, there


@helper
def _expand(i: int, n: int, goal: int, me: int, nodes: Ints, tracks: Tracks, table: Intervals) -> int:
    """Append what turns and runs at once lead to from node ``i``; returns the number of nodes then."""
    cell, heading, leave_by = nodes[i, CELL], nodes[i, HEADING], nodes[i, GAP_END]
    longest = len(tracks.runs) - 1
    for difference in (0, 1, 3, 2):
        towards = (heading + difference) % 4
        offset = tracks.offsets[towards]
        departure = nodes[i, TIME] + tracks.turns[difference]
        common, length, at = 1, 0, cell
        while tracks.moves[at] >> towards & 1:
            at += offset
            length += 1
            if not (tracks.passable[at] or at == goal):
                break
            common = _passed(
                cell, offset, common, min(tracks.common[length], length), longest, departure, me, tracks, table
            )
            if common < min(tracks.common[length], length):
                break
            arrival = departure + tracks.runs[length]
            if (
                departure + tracks.leave[length, 0] <= leave_by
                and tracks.times[at, towards] < far(tracks.times)
                and _passed(cell, offset, common, length, length, departure, me, tracks, table) == length
            ):
                gap, end = gap_at(at, departure + tracks.enter[length, length], me, table)
                if gap >= 0 and arrival <= end:
                    nodes[n, CELL], nodes[n, HEADING], nodes[n, TIME] = at, towards, arrival
                    nodes[n, GAP_END], nodes[n, PARENT], nodes[n, GAP] = end, i, gap
                    n += 1
            if not tracks.passable[at]:
                break
    return n


@helper
def _passed(
    cell: int, offset: int, begin: int, end: int, length: int, departure: int, me: int, tracks: Tracks, table: Intervals
) -> int:
    """First of the cells ``begin`` to ``end`` of a run that is not free when it is passed; ``end`` if all are."""
    for i in range(begin, end):
        there = cell + i * offset
        enter, leave = departure + tracks.enter[length, i], departure + tracks.leave[length, i]
        if table.count[there] and not _is_free(there, enter, leave, me, table):
            return i
    return end


@njit(cache=True, interpreted=True)
def _legs(i: int, nodes: Ints) -> Ints:
    """Read the legs of a path back from its last node: waits in a row are one, that of the run that follows."""
    legs = []  # type: ignore[var-annotated]
    while nodes[i, PARENT] >= 0:
        before = nodes[i, PARENT]
        waited = nodes[i, TIME] - nodes[before, TIME] if nodes[i, CELL] == nodes[before, CELL] else 0
        if legs and waited:
            legs[-1] = legs[-1][0], legs[-1][1] + waited
        else:
            legs.append((nodes[i, CELL], waited))
        i = before
    rows = np.empty((len(legs), 2), np.int64)
    for j in range(len(legs)):
        rows[len(legs) - 1 - j] = np.array(legs[j])
    return rows


@helper
def _is_free(cell: int, begin: int, end: int, me: int, table: Intervals) -> bool:
    """Whether nobody else has a cell between two ticks."""
    first, count, since, until, owner = table
    for p in range(first[cell], first[cell] + count[cell]):
        if since[p] >= end:
            return True
        if until[p] > begin and owner[p] != me:
            return False
    return True


@njit(cache=True, interpreted=True)
def last_end(table: Intervals) -> int:
    """Latest end of an interval that has one; 0 if there is none."""
    latest = 0
    for cell in range(len(table.first)):
        for p in range(table.first[cell], table.first[cell] + table.count[cell]):
            if table.until[p] < FOREVER:
                latest = max(latest, table.until[p])
    return latest
