"""Compiled work on the intervals of a reservation table.

The intervals of a cell lie side by side in a pool: those of cell ``c`` are entries ``first[c]`` to
``first[c] + count[c]``, ascending and disjoint, with ``room[c]`` entries set aside, at least one more than there are.
The gap before entry ``p`` is known by ``p``, the one after the last entry by the entry behind it: so every gap of every
cell has a number of its own, below the pool's size.
"""

from __future__ import annotations

import numpy as np

from rmfs_core.jit import njit
from rmfs_core.world.travel_search import straight_run

FOREVER = 1 << 50
"""End, in ticks, of what has no end."""


@njit(cache=True, interpreted=True)
def conflict(cells, begins, ends, me, first, count, since, until, owner):
    """Position of the first interval that overlaps one of another owner, and that one's entry; (-1, -1) if none."""
    for i in range(len(cells)):
        cell = cells[i]
        for p in range(first[cell], first[cell] + count[cell]):
            if since[p] >= ends[i]:
                break
            if until[p] > begins[i] and owner[p] != me:
                return i, p
    return -1, -1


@njit(cache=True, interpreted=True)
def drive(cell, heading, tick, since, legs, width, kinematics, passing):
    """Rows of cells that legs occupy, from when, until when; and cell, heading and tick of the end.

    ``legs`` has an end and a wait in each row; `Roads` says what the last two are. The cells are none where a leg is no
    straight run; then cell and heading are where that begins and the number of the leg.
    """
    cells = 1
    at = cell
    for i in range(len(legs)):
        length = straight_run(at, legs[i, 0], width)[1]
        if length < 0:
            return np.empty((3, 0), np.int64), at, i, tick
        cells += length
        at = legs[i, 0]
    rows = np.empty((3, cells), np.int64)
    n, begin, at = 0, since, cell
    for i in range(len(legs)):
        to = legs[i, 0]
        tick += legs[i, 1]
        if to == at:
            continue
        towards, length = straight_run(at, to, width)
        step = (to - at) // length
        tick += kinematics[(towards - heading) % 4]
        for k in range(length):
            rows[0, n] = at + k * step
            rows[1, n] = tick + passing[0, length, k] if k else begin
            rows[2, n] = tick + passing[1, length, k]
            n += 1
        begin = tick + passing[0, length, length]
        tick += kinematics[4 + length]
        at, heading = to, towards
    rows[0, n], rows[1, n], rows[2, n] = at, begin, FOREVER
    return rows, at, heading, tick


@njit(cache=True, interpreted=True)
def settle(
    cell, heading, tick, legs, width, kinematics, passing,
    before, me, used, room, first, count, since, until, owner,
):  # fmt: skip
    """Reserve what legs occupy instead of the cells ``before``, unless another has one of them.

    Returns what `drive` and `replace` do.
    """
    rows, at, heading, tick = drive(cell, heading, tick, tick, legs, width, kinematics, passing)
    found, entry, done = -1, -1, 0
    if rows.size:
        found, entry, done, used = replace(
            rows[0], rows[1], rows[2], before, me, used, room, first, count, since, until, owner
        )
    return rows, at, heading, tick, found, entry, done, used


@njit(cache=True, interpreted=True)
def replace(cells, begins, ends, before, me, used, room, first, count, since, until, owner):
    """Reserve intervals instead of the cells ``before``, unless another has one of them.

    Returns what `conflict` and `insert` do.
    """
    found, entry = conflict(cells, begins, ends, me, first, count, since, until, owner)
    done = 0
    if found < 0:
        remove(before, me, first, count, since, until, owner)
        done, used = insert(cells, begins, ends, 0, me, used, room, first, count, since, until, owner)
    return found, entry, done, used


@njit(cache=True, interpreted=True)
def insert(cells, begins, ends, begin_at, me, used, room, first, count, since, until, owner):
    """Insert intervals from ``begin_at`` on; what touches or overlaps one of the same owner becomes one with it.

    Returns how many are in, and how much of the pool is used; fewer than all are in when the pool is full.
    """
    for i in range(begin_at, len(cells)):
        cell, begin, end = cells[i], begins[i], ends[i]
        if count[cell] + 1 >= room[cell]:
            wanted = 2 * room[cell]
            if used + wanted > len(since):
                return i, used
            _move(cell, used, first, count, since, until, owner)
            room[cell] = wanted
            used += wanted
        low = first[cell]
        high = low + count[cell]
        p = low
        while p < high and (until[p] < begin or (until[p] == begin and owner[p] != me)):
            p += 1
        q = p
        while q < high and since[q] <= end and owner[q] == me:
            begin = min(begin, since[q])
            end = max(end, until[q])
            q += 1
        if q == p:
            for r in range(high, p, -1):
                since[r], until[r], owner[r] = since[r - 1], until[r - 1], owner[r - 1]
            count[cell] += 1
        else:
            for r in range(q, high):
                s = r - (q - p - 1)
                since[s], until[s], owner[s] = since[r], until[r], owner[r]
            count[cell] -= q - p - 1
        since[p], until[p], owner[p] = begin, end, me
    return len(cells), used


@njit(cache=True, interpreted=True)
def _move(cell, to, first, count, since, until, owner):
    """Move the intervals of a cell to another index of the pool."""
    for i in range(count[cell]):
        p, q = first[cell] + i, to + i
        since[q], until[q], owner[q] = since[p], until[p], owner[p]
    first[cell] = to


@njit(cache=True, interpreted=True)
def remove(cells, me, first, count, since, until, owner):
    """Remove the intervals of an owner from some cells."""
    for i in range(len(cells)):
        cell = cells[i]
        q = first[cell]
        for p in range(first[cell], first[cell] + count[cell]):
            if owner[p] != me:
                since[q], until[q], owner[q] = since[p], until[p], owner[p]
                q += 1
        count[cell] = q - first[cell]


@njit(cache=True, interpreted=True)
def forget(tick, first, count, since, until, owner):
    """Remove what ended by ``tick``."""
    for cell in range(len(first)):
        low = first[cell]
        past = 0
        while past < count[cell] and until[low + past] <= tick:
            past += 1
        if past:
            for p in range(low, low + count[cell] - past):
                since[p], until[p], owner[p] = since[p + past], until[p + past], owner[p + past]
            count[cell] -= past


@njit(cache=True, interpreted=True)
def pack(room, first, count, since, until, owner, to_since, to_until, to_owner):
    """Copy all intervals to another pool, with little space to spare; returns how much of it is used."""
    used = 0
    for cell in range(len(first)):
        for i in range(count[cell]):
            p, q = first[cell] + i, used + i
            to_since[q], to_until[q], to_owner[q] = since[p], until[p], owner[p]
        first[cell] = used
        room[cell] = count[cell] + 2
        used += room[cell]
    return used
