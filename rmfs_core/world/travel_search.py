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
from numba import njit
from numba.core import caching
from numpy.typing import NDArray

FAR = 1 << 40
FAR_32 = 1 << 30
"""The same in four bytes."""
NEXT, BEFORE, BUCKET = range(3)
"""Columns of a waiting state: its neighbours in the list of its bucket, -1 at the ends; bucket -1: it does not wait."""
MOST_BUCKETS = 4096
_OPTIONS: dict[str, Any] = {"cache": True, "forceinline": True, "_nrt": False}
inlined = njit(**_OPTIONS)
"""Compile a helper into the searches that call it, without counting who refers to its arrays: half of the time."""


def _load_or_nothing(cache: caching.Cache, *arguments: Any, _load: Any = caching.Cache.load_overload) -> Any:
    """Let numba compile anew where it fails to load what it has cached, of code that was moved or replaced since."""
    try:
        return _load(cache, *arguments)
    except Exception:  # whatever an old cache leads to: modules and names that are gone, files cut short
        return None


def _save_anew(file: Any, *arguments: Any, _save: Any = caching.IndexDataCacheFile.save) -> None:
    """Let numba begin a new index where it fails to read the one of what it has cached, for the same reasons."""
    try:
        _save(file, *arguments)
    except OSError:
        raise
    except Exception:
        file.flush()
        _save(file, *arguments)


# Here are the first searches that a run loads
caching.Cache.load_overload = _load_or_nothing  # type: ignore[method-assign]
caching.IndexDataCacheFile.save = _save_anew  # type: ignore[method-assign]


class Work(NamedTuple):
    """What a search writes on, for one search after the other, and what it knows of runs beforehand.

    Parameters
    ----------
    times, driven
        Ticks by state, and the length of the run that it was reached by, 0 for a turn.
    links, buckets, shift
        The states that wait: neighbours in the lists, their first states, and log2 of the ticks of a bucket. Buckets
        are used in a circle that is longer than any move. A state that is reached earlier than when it was taken out
        waits again, so any span is right; one no longer than the shortest move never lets that happen.
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
    while 2 << shift <= runs[1] or move >> shift > MOST_BUCKETS:
        shift += 1
    buckets = np.full(1 << ((move >> shift) + 2).bit_length(), -1, np.int32)  # a power of two
    slowest = cells * int(runs[1] + 2 * turns.max())  # no way visits a cell twice with one heading
    times: Any = np.empty(4 * cells, np.int32 if 4 * slowest + move < 1 << 31 else np.int64)
    links, losses = np.full((4 * cells, 3), -1, np.int32), runs + runs[::-1] - runs[-1] + 4
    onwards = bool(2 * runs[1] - runs[min(2, longest)] < 3)  # the closest call; each is rounded by half a tick
    return Work(times, np.empty(4 * cells, np.int32), links, buckets, shift, losses, gains, onwards)


@njit(cache=True)
def times_to(goal, moves, passable, offsets, runs, turns, work):  # type: ignore[no-untyped-def]
    """Ticks from each (cell, heading) to rest at ``goal``: a search backwards from it."""
    _spread(goal, np.empty(0, np.int64), 0, moves, passable, offsets, runs, turns, work)
    return _table(work.times).reshape((-1, 4))


@njit(cache=True)
def times_near(goal, wanted, spare, table, moves, passable, offsets, runs, turns, work):  # type: ignore[no-untyped-def]
    """Write to ``table`` what `times_to` returns, up to ``spare`` ticks more than the least of the ``wanted`` states.

    Returns how much that is; all other states get that. `FAR` if the table is whole.
    """
    within = _spread(goal, wanted, spare, moves, passable, offsets, runs, turns, work)
    times = work.times
    for i in range(len(times)):
        if times[i] <= within:
            table[i] = times[i] if times[i] < FAR_32 or times.itemsize == 8 else FAR
        else:
            table[i] = within
    return within


@inlined
def _spread(goal, wanted, spare, moves, passable, offsets, runs, turns, work):  # type: ignore[no-untyped-def]
    """Search backwards from a goal, only as far as `times_near` says if states are ``wanted``."""
    times, driven, links, buckets, shift, losses, gains, onwards = work
    _begin(times)
    waiting = bucket = 0
    within, looked, span = np.int64(FAR), np.int64(0), np.int64(1) << shift
    for heading in range(4):
        waiting += _reach(4 * goal + heading, 0, 0, times, driven, links, buckets, shift)
    while waiting:
        while buckets[bucket] < 0:
            bucket = (bucket + 1) & (len(buckets) - 1)
        state = buckets[bucket]
        waiting -= _take(state, links, buckets)
        time, cell = times[state], state >> 2
        if within == FAR and time >= looked:
            within, looked = _within(wanted, time - span, spare, times), time + span
        if time > within + span or (time and not driven[state]):
            continue  # all that is near has been taken, and the others wait no longer; or turned to while it waited
        for difference in range(1 if time and not onwards else 0, 4):
            heading, turned = (state - difference) & 3, time + turns[difference]
            if turned < times[4 * cell + heading]:
                times[4 * cell + heading], driven[4 * cell + heading] = turned, 0
            elif difference:
                continue
            before, length = cell - offsets[heading] if passable[cell] or cell == goal else -1, 1
            while 0 <= before < len(moves) and moves[before] >> heading & 1:
                into, arrival = 4 * before + heading, turned + runs[length]
                if arrival < times[into]:
                    waiting += _reach(into, arrival, length, times, driven, links, buckets, shift)
                elif arrival - times[into] > min(losses[length], gains[driven[into]]):
                    break
                if not passable[before]:
                    break
                before -= offsets[heading]
                length += 1
    return within


@inlined
def _within(wanted, by, spare, times):  # type: ignore[no-untyped-def]
    """Ticks to spare after the nearest wanted state, or `FAR` if none is reached by a tick."""
    nearest = np.int64(FAR)
    for state in wanted:
        if times[state] <= by:
            nearest = min(nearest, times[state] + spare)
    return nearest


@njit(cache=True)
def times_from(start, start_heading, lane, moves, passable, offsets, runs, turns, work):  # type: ignore[no-untyped-def]
    """Ticks from standing at ``start`` to rest in each cell, whatever the heading there."""
    times, driven, links, buckets, shift, losses, gains, onwards = work
    _begin(times)
    waiting, bucket = _reach(4 * start + start_heading, 0, 0, times, driven, links, buckets, shift), 0
    while waiting:
        while buckets[bucket] < 0:
            bucket = (bucket + 1) & (len(buckets) - 1)
        state = buckets[bucket]
        waiting -= _take(state, links, buckets)
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
                    waiting += _reach(into, arrival, length, times, driven, links, buckets, shift)
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
    times.fill(FAR if times.itemsize == 8 else FAR_32)


@njit(cache=True)
def _table(times):  # type: ignore[no-untyped-def]
    """Return times as a table that stays."""
    table = np.empty(len(times), np.int64)
    for i in range(len(times)):
        table[i] = times[i] if times[i] < FAR_32 or times.itemsize == 8 else FAR
    return table


@inlined
def _reach(state, time, length, times, driven, links, buckets, shift):  # type: ignore[no-untyped-def]
    """Note that a state is reached earlier than before, and let it wait; returns 1 if it did not yet."""
    times[state], driven[state] = time, length
    bucket = (time >> shift) & (len(buckets) - 1)
    if links[state, BUCKET] == bucket:
        return 0
    new = 1
    if links[state, BUCKET] >= 0:
        new -= _take(state, links, buckets)
    behind = buckets[bucket]
    links[state, NEXT], links[state, BEFORE], links[state, BUCKET] = behind, -1, bucket
    if behind >= 0:
        links[behind, BEFORE] = state
    buckets[bucket] = state
    return new


@inlined
def _take(state, links, buckets):  # type: ignore[no-untyped-def]
    """Let a state wait no longer; returns 1."""
    behind, before = links[state, NEXT], links[state, BEFORE]
    if before >= 0:
        links[before, NEXT] = behind
    else:
        buckets[links[state, BUCKET]] = behind
    if behind >= 0:
        links[behind, BEFORE] = before
    links[state, BUCKET] = -1
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
