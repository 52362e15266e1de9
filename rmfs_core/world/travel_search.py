"""The compiled searches behind `travel`: Dijkstra over (cell, heading) at rest, with whole runs as moves.

All arrays are flat over cells. ``passable`` marks the cells that may be crossed, ``lane`` the station whose queue a
cell belongs to (-1: none), ``offsets`` the step in cell index per heading, ``runs`` the ticks of a run by its length,
and ``turns`` the ticks of a turn by heading difference. A state is ``4 * cell + heading``.

A run is driven on only while it can still be the fastest to some cell ahead (`Work.losses`, `Work.gains`): that leaves
one or two cells of most runs. States wait in lists, one for each short span of ticks (Dial's buckets).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import inlined, njit
from rmfs_core.world.grid import SOUTH

FAR = 1 << 40
FAR_32 = 1 << 30
"""The same in four bytes."""
LAST, IDLE = -1, -2
"""In place of the state that waits behind another in its bucket: none does, and that one does not wait itself."""
MOST_BUCKETS = 4096


class Work(NamedTuple):
    """What a search writes on, for one search after the other, and what it knows of runs beforehand.

    Parameters
    ----------
    times, driven
        Ticks by state, and the length of the run that it was reached by, 0 for a turn.
    links, buckets, shift
        The states that wait: who is behind each, who is the first of each bucket, and log2 of the ticks of a bucket.
        Buckets are used in a circle that is longer than any two moves. A state that is reached earlier once more stays
        where it waits, as few are, and one that was taken out waits again: times are right in any order.
    losses
        Ticks that a stop after a run of so many cells costs at most, and some to spare. A run that comes to a cell
        later than another robot does that stops there, by more than that, is the fastest to no cell ahead. Three of the
        ticks to spare are for what is rounded, one for "earlier", so that of runs left out for each other one is left.
    gains
        Ticks that a longer run gains at most on one that has driven so many cells, and as many to spare: it gains
        only while that one speeds up yet, and nothing more once both have driven half of the way that is left.
    onwards
        Whether a run after a run may be as fast as one in place of both, but for rounding. If not, turns follow runs.
    """

    times: NDArray[np.int32] | NDArray[np.int64]
    driven: NDArray[np.int32]
    links: NDArray[np.int32]
    buckets: NDArray[np.int32]
    shift: int
    losses: NDArray[np.int64]
    gains: NDArray[np.int64]
    onwards: bool


def work_on(cells: int, runs: NDArray[np.int64], turns: NDArray[np.int64]) -> Work:
    """Return what searches on a grid of so many cells write on."""
    longest, length = len(runs) - 1, np.arange(len(runs))
    more = (longest - length) // 2
    gains = runs[length + more] - runs - (runs[-1] - runs[longest - more]) + 4
    move, shift = int(runs[-1] + turns.max()), 0
    while 2 << shift <= runs[1] or 2 * move >> shift > MOST_BUCKETS:
        shift += 1
    buckets = np.full(1 << ((2 * move >> shift) + 2).bit_length(), LAST, np.int32)  # a power of two
    slowest = cells * int(runs[1] + 2 * turns.max())  # no way visits a cell twice with one heading
    times: Any = np.empty(4 * cells, np.int32 if 4 * slowest + move < 1 << 31 else np.int64)
    links, losses = np.full(4 * cells, IDLE, np.int32), runs + runs[::-1] - runs[-1] + 4
    onwards = bool(2 * runs[1] - runs[min(2, longest)] < 3)  # the closest call; each is rounded by half a tick
    return Work(times, np.empty(4 * cells, np.int32), links, buckets, shift, losses, gains, onwards)


@njit(cache=True)
def times_to(goal, moves, passable, offsets, runs, turns, work):  # type: ignore[no-untyped-def]
    """Ticks from each (cell, heading) to rest at ``goal``: a search backwards from it."""
    _spread(goal, None, None, 0, 0, moves, passable, offsets, runs, turns, work)
    return _table(work.times).reshape((-1, 4))


@njit(cache=True)
def times_near(goal, wanted, spare, table, moves, passable, offsets, runs, turns, work):  # type: ignore[no-untyped-def]
    """Write to ``table`` the times of `times_to` on ways that are at most ``spare`` ticks longer than the fastest.

    Ways are from the rectangle around the ``wanted`` states, and the fastest is that from one of these. Returns how
    long ways may be: that, or `FAR` if none of the states is reached. What is no part of such a way gets what would be
    left of it: no more than its time.
    """
    beyond = np.empty(len(moves), np.int64)
    stop = _look(wanted, offsets[SOUTH], runs, beyond)
    within = _spread(goal, wanted, beyond, stop, spare, moves, passable, offsets, runs, turns, work)
    times = work.times
    for cell in range(len(moves)):
        left = max(within - beyond[cell], 0)
        for state in range(4 * cell, 4 * cell + 4):
            table[state] = min(times[state], left) if times[state] < _far(times) or within < FAR else FAR
    return within


@inlined
def _look(wanted, width, runs, beyond):  # type: ignore[no-untyped-def]
    """Write to ``beyond`` ticks that a way takes at least from the rectangle around some states to each cell.

    That is top speed all the way, and a stop for a row to drive along and one for a column; returns those of a stop. No
    move takes less than these ticks change by, and along a run a way through its end gets no shorter, but for one stop.
    """
    west, east, north, south = width, np.int64(0), len(beyond), np.int64(0)
    for state in wanted:
        row, column = state // 4 // width, state // 4 % width
        west, east, north, south = min(west, column), max(east, column), min(north, row), max(south, row)
    step = stop = runs[1]
    for length in range(1, len(runs)):
        step = min(step, runs[length] - runs[length - 1])
    for length in range(1, len(runs)):
        stop = min(stop, runs[length] - step * length)
    for row in range(len(beyond) // width):
        down = max(north - row, row - south, 0)
        for column in range(width):
            across = max(west - column, column - east, 0)
            beyond[row * width + column] = step * (down + across) + stop * (min(down, 1) + min(across, 1))
    return stop


@inlined
def _spread(goal, wanted, beyond, stop, spare, moves, passable, offsets, runs, turns, work):  # type: ignore[no-untyped-def]
    """Search backwards from a goal, only as far as `times_near` says if states are ``wanted``.

    Then a state waits by the least that a way through it takes, and one too long for the fastest way so far is none.
    """
    times, driven, links, buckets, shift, losses, gains, onwards = work
    _begin(times)
    waiting = bucket = 0
    within = np.int64(FAR)
    for heading in range(4):
        way = 0 if beyond is None else beyond[goal]
        waiting += _reach(4 * goal + heading, 0, way, 0, times, driven, links, buckets, shift)
    while waiting:
        while buckets[bucket] < 0:
            bucket, within = (bucket + 1) & (len(buckets) - 1), _within(wanted, spare, times)
        state = buckets[bucket]
        buckets[bucket], links[state] = links[state], IDLE
        waiting -= 1
        time, cell = times[state], state >> 2
        if time and not driven[state]:
            continue  # turned to while it waited
        for difference in range(1 if time and not onwards else 0, 4):
            heading, turned = (state - difference) & 3, time + turns[difference]
            if turned < times[4 * cell + heading]:
                times[4 * cell + heading], driven[4 * cell + heading] = turned, 0
            elif difference:
                continue
            before, length = cell - offsets[heading] if passable[cell] or cell == goal else -1, 1
            while 0 <= before < len(moves) and moves[before] >> heading & 1:
                into, arrival = 4 * before + heading, turned + runs[length]
                way = arrival if beyond is None else arrival + beyond[before]
                if way > within + stop:
                    break  # and so is every longer run, even with a stop less
                if arrival < times[into]:
                    new = way <= within and _reach(into, arrival, way, length, times, driven, links, buckets, shift)
                    waiting += new
                elif arrival - times[into] > min(losses[length], gains[driven[into]]):
                    break
                if not passable[before]:
                    break
                before -= offsets[heading]
                length += 1
    return _within(wanted, spare, times)


@inlined
def _within(wanted, spare, times):  # type: ignore[no-untyped-def]
    """Ticks to spare after the nearest wanted state so far, or `FAR` if none is reached."""
    nearest = np.int64(FAR)
    if wanted is not None:
        for state in wanted:
            if times[state] < _far(times):
                nearest = min(nearest, times[state] + spare)
    return nearest


@njit(cache=True)
def times_from(start, start_heading, lane, moves, passable, offsets, runs, turns, work):  # type: ignore[no-untyped-def]
    """Ticks from standing at ``start`` to rest in each cell, whatever the heading there."""
    times, driven, links, buckets, shift, losses, gains, onwards = work
    _begin(times)
    waiting, bucket = _reach(4 * start + start_heading, 0, 0, 0, times, driven, links, buckets, shift), 0
    while waiting:
        while buckets[bucket] < 0:
            bucket = (bucket + 1) & (len(buckets) - 1)
        state = buckets[bucket]
        buckets[bucket], links[state] = links[state], IDLE
        waiting -= 1
        time, cell = times[state], state >> 2
        if (time and not driven[state]) or not (passable[cell] or cell == start):
            continue
        for difference in range(1 if time and not onwards else 0, 4):
            heading, turned = (state + difference) & 3, time + turns[difference]
            if turned < times[4 * cell + heading]:
                times[4 * cell + heading], driven[4 * cell + heading] = turned, 0
            elif difference:
                continue
            after, length = cell, 0
            while moves[after] >> heading & 1:
                after += offsets[heading]
                length += 1
                if lane[after] >= 0 and lane[after] != lane[start]:
                    break
                into, arrival = 4 * after + heading, turned + runs[length]
                if arrival < times[into]:
                    waiting += _reach(into, arrival, arrival, length, times, driven, links, buckets, shift)
                elif arrival - times[into] > min(losses[length], gains[driven[into]]):
                    break
                if not passable[after]:
                    break
    fastest = np.empty(len(moves), times.dtype)
    for cell in range(len(moves)):
        at = 4 * cell
        fastest[cell] = min(times[at], times[at + 1], times[at + 2], times[at + 3])
    return _table(fastest)


@inlined
def _begin(times):  # type: ignore[no-untyped-def]
    """Forget the search before, of which nothing waits any more."""
    times.fill(_far(times))


@inlined
def _far(times):  # type: ignore[no-untyped-def]
    """What stands for a state that is not reached."""
    return FAR if times.itemsize == 8 else FAR_32


@njit(cache=True)
def _table(times):  # type: ignore[no-untyped-def]
    """Return times as a table that stays."""
    table = np.empty(len(times), np.int64)
    for i in range(len(times)):
        table[i] = times[i] if times[i] < _far(times) else FAR
    return table


@inlined
def _reach(state, time, way, length, times, driven, links, buckets, shift):  # type: ignore[no-untyped-def]
    """Note that a state is reached earlier than before, and let it wait by its ``way``; returns 1 if it did not yet."""
    times[state], driven[state] = time, length
    if links[state] != IDLE:
        return 0
    bucket = (way >> shift) & (len(buckets) - 1)
    links[state], buckets[bucket] = buckets[bucket], state
    return 1


@njit(cache=True)
def descend(cell, heading, goal, times, moves, passable, offsets, runs, turns):  # type: ignore[no-untyped-def]
    """Ends of the runs of a fastest path, read off the table of ``times_to``."""
    ends = []
    while cell != goal:
        found = False
        for difference in (0, 1, 3, 2):
            towards = (heading + difference) % 4
            left = times[cell, heading] - turns[difference]
            after, length = cell, 0
            while not found and moves[after] >> towards & 1:
                after += offsets[towards]
                length += 1
                if not (passable[after] or after == goal):
                    break
                if runs[length] + times[after, towards] == left:
                    found = True
            if found:
                cell, heading = after, towards
                ends.append(cell)
                break
        if not found:
            raise ValueError("the table of times does not belong to this goal")
    return np.array(ends, dtype=np.int64)
