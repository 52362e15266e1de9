"""When a path can arrive at all: a search from the goal backwards, for a few states.

A label of a state (gap, heading) says: whoever is at rest there by a tick arrives no earlier than another tick. Labels
are taken in the order of that arrival, so every path arrives no earlier than the one that is taken says, as soon as it
leads over this or a later one; and every path does until the gap of the start is taken.
"""

from __future__ import annotations

import numpy as np

from rmfs_core.jit import inlined, njit
from rmfs_core.traffic import FOREVER
from rmfs_rules.helpers.searching import narrow
from rmfs_rules.sipp.states import ARRIVAL, CELL, DONE, DUE, PLACE, REST, STAMP, left_from, put, take

AMPLE = 10_000
"""Ticks to spare with which a state is taken for one that paths come to."""


@njit(cache=True)
def earliest(cell, heading, start, gap, goal, due, latest, labels, me, number, tracks, table, states, queue, low, high):
    """Tick before which no path arrives, at least ``due``, and the one at which none does any more.

    ``latest`` for both where no path arrives before that. ``gap`` is the one that the robot starts in; it looks at so
    many ``labels``.
    """
    brake = np.int64(FOREVER)
    for length in range(1, len(tracks.runs)):
        brake = min(brake, tracks.runs[length] - tracks.enter[length, length])
    waiting, last = 0, np.int64(due)
    for towards in range(4):  # they are taken first
        state = 4 * (table.first[goal] + table.count[goal]) + towards
        waiting = _note(state, goal, latest, due, -FOREVER, number, states, queue, waiting)
    while waiting:
        state = take(states, queue, waiting)
        waiting -= 1
        if states[state, CELL] != goal:
            latest = min(latest, last + 1)
            if labels == 0 or states[state, DUE] >= latest or -states[state, REST] >= AMPLE or state // 4 == gap:
                return min(states[state, DUE], latest), latest
        labels -= 1
        states[state, DONE] = states[state, ARRIVAL]
        arrives, waiting = _before(
            state, cell, heading, start, gap, brake, me, number, tracks, table, states, queue, waiting, low, high
        )
        if states[state, CELL] == goal:
            last = max(last, arrives)
    return latest, latest


@inlined
def _before(state, cell, heading, start, gap, brake, me, number, tracks, table, states, queue, waiting, low, high):
    """Note the states that runs into a state begin in; return when the last run arrives, and the queue's length."""
    to, towards, due = states[state, CELL], state % 4, states[state, DUE]
    rest, arrives = left_from(to, towards, tracks), np.int64(-FOREVER)
    begin, end = _gap(to, state // 4, me, table)
    by = min(end, states[state, ARRIVAL])
    soonest = start + tracks.times[cell, heading] - rest - 4  # four ticks for what is rounded
    at, offset = to, tracks.offsets[towards]
    for length in range(1, len(tracks.runs)):
        at -= offset
        if at < 0 or at >= len(tracks.moves) or not tracks.moves[at] >> towards & 1:
            break
        if not tracks.passable[at] and at != cell:
            break
        run = tracks.runs[length]
        low[0, 0], high[0, 0] = max(begin - tracks.enter[length, length], soonest - run), by - run
        n, now = 1 if low[0, 0] <= high[0, 0] else 0, 0
        ahead = length - 1
        while n and ahead >= 0:
            there, enter = at + ahead * offset, tracks.enter[length, ahead]
            count = table.count[there]
            if count and table.until[table.first[there] + count - 1] - enter > low[now, 0]:
                leave = tracks.leave[length, ahead]
                n = narrow(low, high, now, n, 1 - now, there, enter, leave, me, table)
                now = 1 - now
            ahead -= 1
        if n:
            arrives = max(arrives, high[now, n - 1] + run)
        if n and at == cell:
            turn, until = tracks.turns[(towards - heading) % 4], _gap(at, gap, me, table)[1]
            departure, final = _departs(start + turn, until - tracks.leave[length, 0], now, n, low, high)
            if departure <= final:
                alone, by = departure + run + rest, final - turn
                waiting = _note(4 * gap + heading, at, by, max(due, alone), alone, number, states, queue, waiting)
        if n and tracks.passable[at]:
            waiting = _note_all(
                at, towards, length, due, rest, start + _least(cell, at, tracks), brake, now, n,
                me, number, tracks, table, states, queue, waiting, low, high,
            )  # fmt: skip
        if not tracks.passable[at]:
            break
    return arrives, waiting


@inlined
def _gap(cell, gap, me, table):
    """Begin and end of a gap of a cell."""
    begin, last = np.int64(-FOREVER), table.first[cell] + table.count[cell]
    for p in range(table.first[cell], gap):
        if table.owner[p] != me:
            begin = table.until[p]
    return begin, table.since[gap] if gap < last else np.int64(FOREVER)


@inlined
def _note_all(
    at, towards, length, due, rest, soonest, brake, now, n, me, number, tracks, table, states, queue, waiting, low, high
):
    """Note every gap of a cell that a run may begin in, with each heading that the robot can have come with."""
    p = table.first[at]
    end = p + table.count[at]
    since = np.int64(-FOREVER)
    while since < high[now, n - 1]:
        while p < end and table.owner[p] == me:
            p += 1
        until = table.since[p] if p < end else np.int64(FOREVER)
        for difference in range(4):
            came, turn = (towards - difference) % 4, tracks.turns[difference]
            behind = at - tracks.offsets[came]
            if 0 <= behind < len(tracks.moves) and tracks.moves[behind] >> came & 1:
                ready, leave = max(since + brake, soonest) + turn, tracks.leave[length, 0]
                departure, final = _departs(ready, until - leave, now, n, low, high)
                if departure <= final:
                    onwards, by = tracks.runs[length] + rest, final - turn
                    arrival = max(due, departure + onwards)
                    waiting = _note(4 * p + came, at, by, arrival, ready + onwards, number, states, queue, waiting)
        if p >= end:
            break
        since = table.until[p]
        p += 1
    return waiting


@inlined
def _least(cell, at, tracks):
    """Ticks that a way between two cells takes at least: a run across, a run down, and a turn between them."""
    width = tracks.offsets[3]
    across, down = abs(at % width - cell % width), abs(at // width - cell // width)
    turn = min(tracks.turns[1], tracks.turns[3]) if across and down else np.int64(0)
    return tracks.runs[across] + tracks.runs[down] + turn


@inlined
def _departs(since, until, now, n, low, high):
    """First and last departure from a tick to another, in windows; the first is the later one if there is none."""
    first, last = np.int64(FOREVER), np.int64(-FOREVER)
    for w in range(n):
        begin, end = max(low[now, w], since), min(high[now, w], until)
        if begin <= end:
            first, last = min(first, begin), end
    return first, last


@inlined
def _note(state, cell, by, arrival, alone, number, states, queue, waiting):
    """Note that who is at rest in a state by a tick may arrive at another; labels that wait become one."""
    if states[state, STAMP] != number:
        states[state, STAMP], states[state, PLACE], states[state, DONE] = number, -1, -FOREVER
    if by <= states[state, DONE]:
        return waiting
    if states[state, PLACE] >= 0:
        states[state, ARRIVAL] = max(by, states[state, ARRIVAL])
        if arrival >= states[state, DUE]:
            return waiting
        by = states[state, ARRIVAL]
    states[state, ARRIVAL], states[state, CELL], states[state, DUE] = by, cell, arrival
    states[state, REST] = alone - arrival
    return put(state, states, queue, waiting)
