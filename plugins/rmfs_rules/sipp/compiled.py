"""The compiled search behind `rmfs_rules.sipp`: the same as the plain search of the tests, in integer arrays.

What the plain search does at once is put off here (partial expansion): a state first drives only the runs that could
be on a path as early as the estimate it was queued with, and is queued again with the least estimate of the runs left
out. Arrivals are the same.
"""

from __future__ import annotations

import numpy as np

from rmfs_core.clock import UNREACHABLE
from rmfs_core.jit import helper, njit
from rmfs_rules.sipp.backwards import earliest
from rmfs_rules.sipp.states import (
    AHEAD,
    ARRIVAL,
    CELL,
    DONE,
    DUE,
    GAP_END,
    PARENT,
    REST,
    Ints,
    Memory,
    Problem,
    known,
    left_from,
    put,
    reach,
    take,
    turned,
)
from rmfs_rules.sipp.windows import crossed, narrow
from rmfs_traffic import FOREVER, Intervals, Tracks
from rmfs_traffic.searching import Asked, Plain, far, free_for_good, gap_at

FAR = UNREACHABLE
LITTLE = 1_000
"""States that a search expands before it looks from the goal when a path can arrive at all."""
LABELS = 256
"""States that it looks at there."""
NONE, FOUND, UNDECIDED = range(3)


@njit(cache=True, interpreted=True)
def search(
    asking: Plain, latest: int, number: int, little: int, roads: Plain, taken: Plain, memory: Plain
) -> Ints | None:
    """Legs of the path that arrives first, as rows (end, wait); None when none does before ``latest``.

    After expanding ``little`` states it looks from the goal when a path can arrive at all, and begins anew with that:
    where others have the last cells before the goal for long, estimates are far too early. All in all it uses three
    numbers, up to ``number + 2``. ``asking``, ``roads``, ``taken`` and ``memory`` are what `Asked`, `Tracks`,
    `Intervals` and `Memory` are made of.
    """
    asked, tracks, table, arrays = Asked(*asking), Tracks(*roads), Intervals(*taken), Memory(*memory)
    cell, heading, start, goal, me = asked.cell, asked.heading, asked.start, asked.goal, asked.me
    gap, end = gap_at(cell, start, me, table)
    last = free_for_good(goal, me, table)
    if gap < 0 or last >= FOREVER or tracks.times[cell, heading] >= far(tracks.times):
        return None
    if cell == goal and end >= FOREVER:
        return np.empty((0, 2), np.int64)
    bound = _entered(last, tracks)
    rows, found = _forward(asked, gap, end, latest, little, Problem(me, goal, number, bound, tracks, table, arrays))
    if found != UNDECIDED:
        return rows if found == FOUND else None
    due = max(start + tracks.times[cell, heading], bound)
    bound, latest = earliest(
        asked, gap, due, latest, LABELS, Problem(me, goal, number + 1, bound, tracks, table, arrays)
    )
    rows, found = _forward(
        asked, gap, end, latest, FOREVER, Problem(me, goal, number + 2, bound, tracks, table, arrays)
    )
    return rows if found == FOUND else None


@njit(cache=True, interpreted=True)
def _forward(asked: Asked, gap: int, end: int, latest: int, most: int, problem: Problem) -> tuple[Ints, int]:
    """Rows of the path, as `search` returns them, and what came of it: at most so many states are expanded."""
    nothing = np.empty((0, 2), np.int64)
    states, tracks, goal = problem.memory.states, problem.tracks, problem.goal
    cell, heading, start = asked.cell, asked.heading, asked.start
    due = max(start + tracks.times[cell, heading], problem.bound)
    waiting = reach(4 * gap + heading, start, -1, cell, end, due, 0, problem)
    found = int(latest)
    while waiting:
        state = take(waiting, problem.memory)
        waiting -= 1
        if states[state, DUE] >= latest:
            return nothing, NONE
        time = states[state, ARRIVAL]
        if turned(state, time, problem):
            continue
        if states[state, CELL] == goal and states[state, GAP_END] >= FOREVER:
            return _legs(state, tracks, states), FOUND
        if states[state, CELL] == goal and states[state, PARENT] >= 0 and not tracks.passable[goal]:
            continue  # a storage location is no way through for a robot with a pod
        if most == 0:
            return nothing, UNDECIDED
        most -= 1
        limit = states[state, DUE]
        if states[state, DONE] >= 0:
            limit += (limit - time - states[state, REST]) // 2  # the farther off, the more at once
        found, left, waiting = _expand(state, limit, found, waiting, problem)
        if left < FAR:
            states[state, DONE], states[state, DUE] = limit, max(left, problem.bound)
            waiting = put(state, waiting, problem.memory)
    return nothing, NONE


@helper
def _entered(last: int, tracks: Tracks) -> int:
    """Earliest end of a run into a goal that is free for good from a tick on; 0 if nobody else ever has it."""
    if last == 0:
        return 0
    shortest = int(FAR)
    for length in range(1, len(tracks.runs)):
        shortest = min(shortest, tracks.runs[length] - tracks.enter[length, length])
    return last + shortest


@helper
def _expand(state: int, limit: int, found: int, waiting: int, problem: Problem) -> tuple[int, int, int]:
    """Turn and run from a state, wherever the estimate is up to ``limit`` and was not before, into every gap.

    Returns the best arrival at the goal so far, the least estimate of a run beyond the limit, and the queue's length.
    """
    left, states = int(FAR), problem.memory.states
    for difference in (0, 1, 3, 2):
        towards = (state + difference) % 4
        if states[state, AHEAD + towards] <= limit:
            ready = states[state, ARRIVAL] + problem.tracks.turns[difference]
            found, states[state, AHEAD + towards], waiting = _drive(
                state, towards, ready, limit, found, waiting, problem
            )
        left = min(left, states[state, AHEAD + towards])
    return found, left, waiting


@helper
def _drive(
    state: int, towards: int, ready: int, limit: int, found: int, waiting: int, problem: Problem
) -> tuple[int, int, int]:
    """Do what `_expand` does, in one heading."""
    goal, tracks, table = problem.goal, problem.tracks, problem.table
    states, low, high = problem.memory.states, problem.memory.low, problem.memory.high
    cell, done, offset = states[state, CELL], states[state, DONE], tracks.offsets[towards]
    longest = len(tracks.runs) - 1
    left = int(FAR)
    # No run clears the first cell faster than the longest one.
    low[0, 0], high[0, 0] = ready, states[state, GAP_END] - tracks.leave[longest, 0]
    now, n, common, length, at, departure = 0, 1 if low[0, 0] <= high[0, 0] else 0, 1, 0, cell, ready
    while n and tracks.moves[at] >> towards & 1:
        at += offset
        length += 1
        if not (tracks.passable[at] or at == goal):
            break
        ahead = tracks.runs[length] + left_from(at, towards, tracks)
        if departure + ahead <= limit:
            while n and common < min(tracks.common[length], length):
                there = cell + common * offset
                begin, stop = tracks.enter[longest, common], tracks.leave[longest, common]
                if crossed(low, high, now, n, there, begin, stop, table):
                    n = narrow(low, high, now, n, 1 - now, there, begin, stop, problem.me, table)
                    now = 1 - now
                common += 1
            if n == 0:
                break
            departure = low[now, 0]
        estimate = departure + ahead
        if estimate > limit:
            left = min(left, estimate)
            if estimate - _saved(length, tracks) >= left:
                break
        elif (
            estimate > done
            and max(estimate, problem.bound) < found
            and _better(at, towards, length, departure, problem)
        ):
            found, waiting = _arrive(state, towards, length, at, n, now, common, found, waiting, problem)
        if not tracks.passable[at]:
            break
    return found, left, waiting


@helper
def _saved(length: int, tracks: Tracks) -> int:
    """Ticks by which the estimate of a longer run in the same heading may be less, at most.

    A robot that stops after ``length`` cells and drives on as far as the longer run takes longer by what it loses at
    the stop, most of it when the longer run is the longest. Three ticks to spare for what is rounded.
    """
    longest = len(tracks.runs) - 1
    return int(tracks.runs[length] + tracks.runs[longest - length] - tracks.runs[longest] + 3)


@helper
def _better(at: int, towards: int, length: int, departure: int, problem: Problem) -> bool:
    """Whether a run that departs no earlier could come into some gap of its last cell before all runs so far."""
    tracks, table = problem.tracks, problem.table
    p = table.first[at]
    end = p + table.count[at]
    free_since = int(-FOREVER)
    while True:
        while p < end and table.owner[p] == problem.me:
            p += 1
        free_until = table.since[p] if p < end else FOREVER
        time = max(departure, free_since - tracks.enter[length, length]) + tracks.runs[length]
        if time <= free_until and not known(4 * p + towards, time, problem):
            return True
        if p >= end:
            return False
        free_since = table.until[p]
        p += 1


@helper
def _arrive(
    state: int, towards: int, length: int, at: int, n: int, now: int, common: int, found: int, waiting: int,
    problem: Problem,
) -> tuple[int, int]:  # fmt: skip
    """Drive one run as early as can be into each gap of its last cell; windows ``now`` stay as they are."""
    tracks, table = problem.tracks, problem.table
    states, low, high = problem.memory.states, problem.memory.low, problem.memory.high
    cell = states[state, CELL]
    leave_by = states[state, GAP_END] - tracks.leave[length, 0]
    rest = tracks.times[at, towards]
    while n and common < length:
        there = cell + common * tracks.offsets[towards]
        begin, stop = tracks.enter[length, common], tracks.leave[length, common]
        if crossed(low, high, now, n, there, begin, stop, table):
            to = 3 if now == 2 else 2
            n = narrow(low, high, now, n, to, there, begin, stop, problem.me, table)
            now = to
        common += 1
    p = table.first[at]
    end = p + table.count[at]
    free_since = int(-FOREVER)
    w = 0
    while w < n:
        while p < end and table.owner[p] == problem.me:
            p += 1
        free_until = table.since[p] if p < end else FOREVER
        earliest = free_since - tracks.enter[length, length]
        while w < n and high[now, w] < earliest:
            w += 1
        if w == n or max(low[now, w], earliest) > leave_by:
            break
        time = max(low[now, w], earliest) + tracks.runs[length]
        into, due = 4 * p + towards, max(time + rest, problem.bound)
        if time <= free_until and due < found and not known(into, time, problem):
            waiting = reach(into, time, state, at, free_until, due, waiting, problem)
            if at == problem.goal and free_until >= FOREVER:
                found = time
        if p >= end:
            break
        free_since = table.until[p]
        p += 1
    return found, waiting


@njit(cache=True, interpreted=True)
def _legs(state: int, tracks: Tracks, states: Ints) -> Ints:
    """Read the legs of a path back from its last state."""
    steps = 0
    at = state
    while states[at, PARENT] >= 0:
        at = states[at, PARENT]
        steps += 1
    rows = np.empty((steps, 2), np.int64)
    at = state
    for i in range(steps - 1, -1, -1):
        before = states[at, PARENT]
        length = abs(states[at, CELL] - states[before, CELL]) // abs(tracks.offsets[at % 4])
        moved = tracks.turns[(at - before) % 4] + tracks.runs[length]
        rows[i, 0], rows[i, 1] = states[at, CELL], states[at, ARRIVAL] - states[before, ARRIVAL] - moved
        at = before
    return rows
