"""The states of the compiled search, and the queue of states to be expanded.

A state is (gap, heading) at rest, numbered ``4 * gap + heading`` with the gap's number in the reservation table, so the
arrays are as long as four times the table's pool. A state is a row of ``states``; ``STAMP`` says which search wrote it
last: nothing has to be cleared in between. The queue is a binary heap of states that know their index in it, ordered by
(due, rest, cell, number): not by number alone, for the index of a cell in the pool depends on what was reserved before.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import UNREACHABLE
from rmfs_core.jit import helper
from rmfs_traffic import Intervals, Tracks
from rmfs_traffic.searching import far

Ints = NDArray[np.int64]

STAMP, ARRIVAL, PARENT, CELL, GAP_END, REST, DUE, DONE, PLACE, AHEAD = range(10)
"""Columns of a state.

Arrival in ticks, state before it (-1 for the first), cell, end of the gap; time to the goal without traffic. ``DUE`` is
the least estimate of a path by a run not driven yet; those with estimates up to ``DONE`` (-1: none) have been driven.
``PLACE`` is its index in the queue, -1 when it is not there; ``AHEAD`` and the three after it are ``DUE`` by heading.
"""
COLUMNS = AHEAD + 4


class Memory(NamedTuple):
    """Arrays that searches write, kept from one to the next.

    Parameters
    ----------
    states, queue
        Rows of the states, and states to be expanded: shapes (states, `COLUMNS`) and (states,).
    low, high
        Windows of departure, as `rmfs_rules.sipp.windows.narrow` has them: shape (4, windows).
    """

    states: Ints
    queue: Ints
    low: Ints
    high: Ints


class Problem(NamedTuple):
    """Arguments of one search.

    Parameters
    ----------
    me, goal
        The robot, and the cell that it has to reach.
    number
        Of the search; `STAMP` has it in the states that this search wrote.
    bound
        Tick before which no path arrives.
    tracks, table
        The roads, and who has reserved them.
    memory
        Memory that it writes.
    """

    me: int
    goal: int
    number: int
    bound: int
    tracks: Tracks
    table: Intervals
    memory: Memory


def memory_for(gaps: int) -> Memory:
    """Return arrays for searches of a table with so many gaps: states that none has reached, a window for each gap."""
    states = np.zeros((4 * gaps, COLUMNS), np.int64), np.zeros(4 * gaps, np.int64)
    return Memory(*states, np.zeros((4, gaps + 2), np.int64), np.zeros((4, gaps + 2), np.int64))


@helper
def left_from(cell: int, heading: int, tracks: Tracks) -> int:
    """Ticks of the fastest way to the goal without other robots, `UNREACHABLE` if there is none."""
    ticks = int(tracks.times[cell, heading])
    return ticks if ticks < far(tracks.times) else UNREACHABLE


@helper
def reach(into: int, time: int, parent: int, cell: int, gap_end: int, due: int, waiting: int, problem: Problem) -> int:
    """Note how a state is reached, earlier than before, and queue it; returns the length of the queue."""
    states, tracks = problem.memory.states, problem.tracks
    if states[into, STAMP] != problem.number:
        states[into, STAMP], states[into, PLACE] = problem.number, -1
    states[into, ARRIVAL], states[into, PARENT] = time, parent
    states[into, CELL], states[into, GAP_END] = cell, gap_end
    states[into, REST], states[into, DUE], states[into, DONE] = tracks.times[cell, into % 4], due, -1
    for difference in range(4):
        heading = (into + difference) % 4
        states[into, AHEAD + heading] = time + tracks.turns[difference] + left_from(cell, heading, tracks)
    return int(put(into, waiting, problem.memory))


@helper
def known(into: int, time: int, problem: Problem) -> bool:
    """Whether a state has been reached as early, or early enough with another heading."""
    states = problem.memory.states
    if states[into, STAMP] == problem.number and states[into, ARRIVAL] <= time:
        return True
    return bool(turned(into, time, problem))


@helper
def turned(into: int, time: int, problem: Problem) -> bool:
    """Whether a robot got there so early with another heading that there was time for the turn."""
    states, turns = problem.memory.states, problem.tracks.turns
    gap, heading = into // 4 * 4, into % 4
    for difference in range(1, 4):
        other = gap + (heading - difference) % 4
        # A tick to spare: two turns rounded to ticks may take one less than the turn they add up to.
        if states[other, STAMP] == problem.number and states[other, ARRIVAL] + turns[difference] < time:
            return True
    return False


@helper
def put(state: int, waiting: int, memory: Memory) -> int:
    """Queue a state, or move it up to where it belongs now; returns the length of the queue."""
    states, queue = memory.states, memory.queue
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


@helper
def take(waiting: int, memory: Memory) -> int:
    """Take the first state out of a queue of that length."""
    states, queue = memory.states, memory.queue
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
    return int(top)


@helper
def _before(a: int, b: int, states: Ints) -> bool:
    if states[a, DUE] != states[b, DUE]:
        return bool(states[a, DUE] < states[b, DUE])
    if states[a, REST] != states[b, REST]:
        return bool(states[a, REST] < states[b, REST])
    if states[a, CELL] != states[b, CELL]:  # not by number: where the table has a cell is a matter of its past
        return bool(states[a, CELL] < states[b, CELL])
    return a < b
