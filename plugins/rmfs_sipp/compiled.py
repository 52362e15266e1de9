"""The compiled search behind `rmfs_sipp`: the same as `rmfs_sipp.plain`, in integer arrays.

A state is (gap, heading) at rest, numbered ``4 * gap + heading`` with the gap's number in the reservation table, so the
arrays of a search are as long as four times the table's pool. ``stamp`` says which search wrote a state last: nothing
has to be cleared in between.

What the plain search does at once is put off here (partial expansion): a state first drives only the runs that could
be on a path without delay, and is queued again with the estimate of the best run left out. Arrivals are the same.
"""

from __future__ import annotations

from heapq import heappop, heappush

import numpy as np
from numba import njit

from rmfs_core.traffic import FOREVER
from rmfs_core.traffic.intervals import free_for_good, gap_at, narrow
from rmfs_core.travel import UNREACHABLE

FAR = UNREACHABLE
SLACK = 2000
"""Ticks by which the limit of a state grows when it is queued again; twice as far each time."""


@njit(cache=True)
def search(cell, heading, start, goal, me, number, tracks, table, states, windows):  # type: ignore[no-untyped-def]
    """Runs of the path that arrives first, as rows (end, departure, arrival); None when there is no path."""
    runs, enter, times = tracks.runs, tracks.enter, tracks.times
    stamp, arrival, parent, where, gap_end = states
    gap, end = gap_at(cell, start, me, table)
    last = free_for_good(goal, me, table)
    if gap < 0 or last >= FOREVER or times[cell, heading] >= FAR:
        return None
    if cell == goal and end >= FOREVER:
        return np.empty((0, 3), np.int64)
    bound = np.int64(0)
    if last > 0:
        # The goal is entered once it is free for good, and the rest of the run from there is no shorter than this.
        bound = last + min(runs[1], np.int64(runs[len(runs) - 1] - enter[len(runs) - 1, len(runs) - 1]))
        for length in range(1, len(runs)):
            bound = min(bound, last + runs[length] - enter[length, length])
    first_state = 4 * gap + heading
    stamp[first_state], arrival[first_state], parent[first_state] = number, start, -1
    where[first_state], gap_end[first_state] = cell, end
    queue = [
        (max(start + times[cell, heading], bound), times[cell, heading], np.int64(first_state), np.int64(start), -1)
    ]
    found = np.int64(FOREVER)
    while queue:
        _, rest, state, time, done = heappop(queue)
        if time > arrival[state] or _turned(state, time, number, tracks.turns, stamp, arrival):
            continue
        if where[state] == goal and gap_end[state] >= FOREVER:
            return _runs(state, tracks, states)
        if where[state] == goal and parent[state] >= 0 and not tracks.passable[goal]:
            continue  # a storage location is no way through for a robot with a pod
        limit = time + rest if done < 0 else done + SLACK * (1 + (done - time - rest) // SLACK)
        found, left = _expand(
            state, time, done, limit, goal, me, number, bound, found, queue, tracks, table, states, windows
        )
        if left < FAR:
            heappush(queue, (max(left, bound), rest, state, time, limit))
    return None


@njit(cache=True)
def _expand(  # type: ignore[no-untyped-def]
    state, time, done, limit, goal, me, number, bound, found, queue, tracks, table, states, windows
):
    """Turn and run from a state, wherever the estimate lies between ``done`` and ``limit``, into every gap.

    Returns the best arrival at the goal so far, and the least estimate of a run beyond the limit.
    """
    cell, heading = states[3][state], state % 4
    low, high = windows
    longest = len(tracks.runs) - 1
    left = np.int64(FAR)
    for difference in (0, 1, 3, 2):
        towards = (heading + difference) % 4
        offset = tracks.offsets[towards]
        now = 0
        ready = time + tracks.turns[difference]
        # No run clears the first cell faster than the longest one.
        low[now, 0], high[now, 0] = ready, states[4][state] - tracks.leave[longest, 0]
        if high[now, 0] < ready:
            continue
        n, common, length, at = 1, 1, 0, cell
        while tracks.moves[at] >> towards & 1:
            at += offset
            length += 1
            if not (tracks.passable[at] or at == goal):
                break
            rest = tracks.times[at, towards]
            estimate = ready + tracks.runs[length] + rest
            if estimate > limit:
                left = min(left, estimate)
            elif estimate > done:
                while common < min(tracks.common[length], length):
                    there = cell + common * offset
                    if table.count[there]:
                        begin, stop = tracks.enter[longest, common], tracks.leave[longest, common]
                        n = narrow(low[now], high[now], n, low[1 - now], high[1 - now], there, begin, stop, me, table)
                        now = 1 - now
                    common += 1
                if n == 0:
                    break
                departure = low[now, 0]
                if max(departure + tracks.runs[length] + rest, bound) < found and _better(
                    at, towards, length, departure, me, number, tracks, table, states
                ):
                    found = _arrive(
                        state, cell, length, towards, at, rest, n, now, common, goal, me, number, bound, found, queue,
                        tracks, table, states, windows,
                    )  # fmt: skip
            if not tracks.passable[at]:
                break
    return found, left


@njit(cache=True)
def _known(into, time, number, turns, stamp, arrival):  # type: ignore[no-untyped-def]
    """Whether a state has been reached as early, or early enough with another heading."""
    if stamp[into] == number and arrival[into] <= time:
        return True
    return _turned(into, time, number, turns, stamp, arrival)


@njit(cache=True)
def _turned(into, time, number, turns, stamp, arrival):  # type: ignore[no-untyped-def]
    """Whether a robot got there so early with another heading that there was time for the turn."""
    gap, heading = into // 4 * 4, into % 4
    for difference in range(1, 4):
        other = gap + (heading - difference) % 4
        # A tick to spare: two turns rounded to ticks may take one less than the turn they add up to.
        if stamp[other] == number and arrival[other] + turns[difference] < time:
            return True
    return False


@njit(cache=True)
def _better(at, towards, length, departure, me, number, tracks, table, states):  # type: ignore[no-untyped-def]
    """Whether a run that departs no earlier could come into some gap of its last cell before all runs so far."""
    first, count, since, until, owner = table
    stamp, arrival = states[0], states[1]
    p, end = first[at], first[at] + count[at]
    free_since = np.int64(-FOREVER)
    while True:
        while p < end and owner[p] == me:
            p += 1
        free_until = since[p] if p < end else FOREVER
        time = max(departure, free_since - tracks.enter[length, length]) + tracks.runs[length]
        into = 4 * p + towards
        if time <= free_until and not _known(into, time, number, tracks.turns, stamp, arrival):
            return True
        if p >= end:
            return False
        free_since = until[p]
        p += 1


@njit(cache=True)
def _arrive(  # type: ignore[no-untyped-def]
    state, cell, length, towards, at, rest, n, now, common, goal, me, number, bound, found, queue,
    tracks, table, states, windows,
):  # fmt: skip
    """Drive one run as early as can be into each gap of its last cell; windows ``now`` stay as they are."""
    stamp, arrival, parent, where, gap_end = states
    first, count, since, until, owner = table
    lows, highs = windows
    offset = tracks.offsets[towards]
    leave_by = gap_end[state] - tracks.leave[length, 0]
    for i in range(common, length):
        there = cell + i * offset
        if count[there]:
            begin, stop = tracks.enter[length, i], tracks.leave[length, i]
            to = 3 if now == 2 else 2
            n = narrow(lows[now], highs[now], n, lows[to], highs[to], there, begin, stop, me, table)
            now = to
    low, high = lows[now], highs[now]
    p, end = first[at], first[at] + count[at]
    free_since = np.int64(-FOREVER)
    w = 0
    while w < n:
        while p < end and owner[p] == me:
            p += 1
        free_until = since[p] if p < end else FOREVER
        earliest = free_since - tracks.enter[length, length]
        while w < n and high[w] < earliest:
            w += 1
        if w == n or max(low[w], earliest) > leave_by:
            break
        time = max(low[w], earliest) + tracks.runs[length]
        into = 4 * p + towards
        if time <= free_until and not _known(into, time, number, tracks.turns, stamp, arrival):
            estimate = max(time + rest, bound)
            if estimate < found:
                stamp[into], arrival[into], parent[into] = number, time, state
                where[into], gap_end[into] = at, free_until
                heappush(queue, (estimate, rest, np.int64(into), np.int64(time), -1))
                if at == goal and free_until >= FOREVER:
                    found = time
        if p >= end:
            break
        free_since = until[p]
        p += 1
    return found


@njit(cache=True)
def _runs(state, tracks, states):  # type: ignore[no-untyped-def]
    """Read the runs of a path back from its last state."""
    _, arrival, parent, where, _ = states
    steps = 0
    at = state
    while parent[at] >= 0:
        at = parent[at]
        steps += 1
    rows = np.empty((steps, 3), np.int64)
    at = state
    for i in range(steps - 1, -1, -1):
        before = parent[at]
        length = abs(where[at] - where[before]) // abs(tracks.offsets[at % 4])
        rows[i, 0], rows[i, 1], rows[i, 2] = where[at], arrival[at] - tracks.runs[length], arrival[at]
        at = before
    return rows
