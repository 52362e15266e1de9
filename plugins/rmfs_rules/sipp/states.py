"""The states of the compiled search, and the queue of those that are to be expanded.

A state is (gap, heading) at rest, numbered ``4 * gap + heading`` with the gap's number in the reservation table, so the
arrays are as long as four times the table's pool. A state is a row of ``states``; ``STAMP`` says which search wrote it
last: nothing has to be cleared in between. The queue is a binary heap of states that know their place in it, ordered by
(due, rest, number).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import UNREACHABLE
from rmfs_core.jit import inlined
from rmfs_rules.helpers.searching import far

STAMP, ARRIVAL, PARENT, CELL, GAP_END, REST, DUE, DONE, PLACE, AHEAD = range(10)
"""Columns of a state.

Arrival in ticks, state before it (-1 for the first), cell, end of the gap; time to the goal without traffic. ``DUE`` is
the least estimate of a path by a run not driven yet; those with estimates up to ``DONE`` (-1: none) have been driven.
``PLACE`` is its place in the queue, -1 when it is not there; ``AHEAD`` and the three after it are ``DUE`` by heading.
"""
COLUMNS = AHEAD + 4


def empty_states(number: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return so many states that no search has reached, and a queue with room for them all."""
    return np.zeros((number, COLUMNS), dtype=np.int64), np.zeros(number, dtype=np.int64)


@inlined
def left_from(cell, heading, tracks):
    """Ticks of the fastest way to the goal without other robots, `UNREACHABLE` if there is none."""
    ticks = np.int64(tracks.times[cell, heading])
    return ticks if ticks < far(tracks.times) else UNREACHABLE


@inlined
def reach(into, number, time, parent, cell, gap_end, due, tracks, states, queue, waiting):
    """Note how a state is reached, earlier than before, and queue it; returns the length of the queue."""
    if states[into, STAMP] != number:
        states[into, STAMP], states[into, PLACE] = number, -1
    states[into, ARRIVAL], states[into, PARENT] = time, parent
    states[into, CELL], states[into, GAP_END] = cell, gap_end
    states[into, REST], states[into, DUE], states[into, DONE] = tracks.times[cell, into % 4], due, -1
    for difference in range(4):
        heading = (into + difference) % 4
        states[into, AHEAD + heading] = time + tracks.turns[difference] + left_from(cell, heading, tracks)
    return put(into, states, queue, waiting)


@inlined
def known(into, time, number, turns, states):
    """Whether a state has been reached as early, or early enough with another heading."""
    if states[into, STAMP] == number and states[into, ARRIVAL] <= time:
        return True
    return turned(into, time, number, turns, states)


@inlined
def turned(into, time, number, turns, states):
    """Whether a robot got there so early with another heading that there was time for the turn."""
    gap, heading = into // 4 * 4, into % 4
    for difference in range(1, 4):
        other = gap + (heading - difference) % 4
        # A tick to spare: two turns rounded to ticks may take one less than the turn they add up to.
        if states[other, STAMP] == number and states[other, ARRIVAL] + turns[difference] < time:
            return True
    return False


@inlined
def put(state, states, queue, waiting):
    """Queue a state, or move it up to where it belongs now; returns the length of the queue."""
    i = states[state, PLACE]
    if i < 0:
        i = waiting
        waiting += 1
    while i > 0:
        up = (i - 1) // 2
        if not _before(state, queue[up], states):
            break
        queue[i] = queue[up]
        states[queue[i], PLACE] = i
        i = up
    queue[i], states[state, PLACE] = state, i
    return waiting


@inlined
def take(states, queue, waiting):
    """Take the first state out of a queue of that length."""
    top, last = queue[0], queue[waiting - 1]
    i, down = 0, 1
    while down < waiting - 1:
        if down + 1 < waiting - 1 and _before(queue[down + 1], queue[down], states):
            down += 1
        if not _before(queue[down], last, states):
            break
        queue[i] = queue[down]
        states[queue[i], PLACE] = i
        i, down = down, 2 * down + 1
    queue[i], states[last, PLACE] = last, i
    states[top, PLACE] = -1
    return top


@inlined
def _before(a, b, states):
    if states[a, DUE] != states[b, DUE]:
        return states[a, DUE] < states[b, DUE]
    if states[a, REST] != states[b, REST]:
        return states[a, REST] < states[b, REST]
    return a < b
