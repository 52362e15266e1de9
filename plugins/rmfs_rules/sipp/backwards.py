"""When a path can arrive at all: a search from the goal backwards, for a few states.

A label of a state (gap, heading) says: a robot at rest there by a tick arrives no earlier than another tick. Labels
are taken in the order of that arrival, so every path arrives no earlier than the one that is taken says, as soon as it
leads over this or a later one; and every path does until the gap of the start is taken.
"""

from __future__ import annotations

from rmfs_core.jit import helper, njit
from rmfs_rules.sipp.states import ARRIVAL, CELL, DONE, DUE, PLACE, REST, STAMP, Ints, Problem, left_from, put, take
from rmfs_rules.sipp.windows import narrow
from rmfs_traffic import FOREVER, Intervals, Tracks
from rmfs_traffic.searching import Asked

AMPLE = 10_000
"""Ticks to spare with which a state is taken for one that paths come to."""


@njit(cache=True, interpreted=True)
def earliest(asked: Asked, gap: int, due: int, latest: int, labels: int, problem: Problem) -> tuple[int, int]:
    """Tick before which no path arrives, at least ``due``, and the one at which none does any more.

    ``latest`` for both where no path arrives before that. ``gap`` is the one that the robot starts in; it looks at so
    many ``labels``.
    """
    brake, goal, tracks, states = int(FOREVER), problem.goal, problem.tracks, problem.memory.states
    for length in range(1, len(tracks.runs)):
        brake = min(brake, tracks.runs[length] - tracks.enter[length, length])
    waiting, last = 0, int(due)
    for towards in range(4):  # they are taken first
        state = 4 * (problem.table.first[goal] + problem.table.count[goal]) + towards
        waiting = _note(state, goal, latest, due, -FOREVER, waiting, problem)
    while waiting:
        state = take(waiting, problem.memory)
        waiting -= 1
        if states[state, CELL] != goal:
            latest = min(latest, last + 1)
            if labels == 0 or states[state, DUE] >= latest or -states[state, REST] >= AMPLE or state // 4 == gap:
                return min(states[state, DUE], latest), latest
        labels -= 1
        states[state, DONE] = states[state, ARRIVAL]
        arrives, waiting = _before(state, asked, gap, brake, waiting, problem)
        if states[state, CELL] == goal:
            last = max(last, arrives)
    return latest, latest


@helper
def _before(state: int, asked: Asked, gap: int, brake: int, waiting: int, problem: Problem) -> tuple[int, int]:
    """Note the states that runs into a state begin in; return when the last run arrives, and the queue's length."""
    cell, heading, start, me, goal = asked.cell, asked.heading, asked.start, problem.me, problem.goal
    tracks, table = problem.tracks, problem.table
    states, low, high = problem.memory.states, problem.memory.low, problem.memory.high
    to, towards, due = states[state, CELL], state % 4, states[state, DUE]
    rest, arrives = left_from(to, towards, tracks), int(-FOREVER)
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
        soon = start + _least(cell, at, tracks)
        if n and to != goal and at != cell:
            n = _note_all(at, towards, length, due, rest, soon, brake, now, n, 0, True, problem)
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
                waiting = _note(4 * gap + heading, at, by, max(due, alone), alone, waiting, problem)
        if n and tracks.passable[at]:
            waiting = _note_all(at, towards, length, due, rest, soon, brake, now, n, waiting, False, problem)
        if not tracks.passable[at]:
            break
    return arrives, waiting


@helper
def _gap(cell: int, gap: int, me: int, table: Intervals) -> tuple[int, int]:
    """Begin and end of a gap of a cell."""
    begin, last = int(-FOREVER), table.first[cell] + table.count[cell]
    for p in range(table.first[cell], gap):
        if table.owner[p] != me:
            begin = table.until[p]
    return begin, table.since[gap] if gap < last else int(FOREVER)


@helper
def _changes(state: int, by: int, arrival: int, problem: Problem) -> bool:
    """Whether `_note` of a label would change something."""
    states = problem.memory.states
    if states[state, STAMP] != problem.number:
        return True
    if by <= states[state, DONE]:
        return False
    return bool(states[state, PLACE] < 0 or by > states[state, ARRIVAL] or arrival < states[state, DUE])


@helper
def _note_all(
    at: int, towards: int, length: int, due: int, rest: int, soonest: int, brake: int, now: int, n: int, waiting: int,
    looking: bool, problem: Problem,
) -> int:  # fmt: skip
    """Note every gap of a cell that a run may begin in, with each heading that the robot can have come with.

    Returns the queue's length. If it is only ``looking``, it notes nothing, and returns one more where a label would
    change.
    """
    tracks, table, low, high = problem.tracks, problem.table, problem.memory.low, problem.memory.high
    p = table.first[at]
    end = p + table.count[at]
    since = int(-FOREVER)
    while since < high[now, n - 1]:
        while p < end and table.owner[p] == problem.me:
            p += 1
        until = table.since[p] if p < end else int(FOREVER)
        for difference in range(4):
            came, turn = (towards - difference) % 4, tracks.turns[difference]
            behind = at - tracks.offsets[came]
            if 0 <= behind < len(tracks.moves) and tracks.moves[behind] >> came & 1:
                ready, leave = max(since + brake, soonest) + turn, tracks.leave[length, 0]
                departure, final = _departs(ready, until - leave, now, n, low, high)
                if departure <= final:
                    onwards, by = tracks.runs[length] + rest, final - turn
                    arrival = max(due, departure + onwards)
                    if not looking:
                        waiting = _note(4 * p + came, at, by, arrival, ready + onwards, waiting, problem)
                    elif _changes(4 * p + came, by, arrival, problem):
                        return waiting + 1
        if p >= end:
            break
        since = table.until[p]
        p += 1
    return waiting


@helper
def _least(cell: int, at: int, tracks: Tracks) -> int:
    """Ticks that a way between two cells takes at least: a run across, a run down, and a turn between them."""
    width = tracks.offsets[3]
    across, down = abs(at % width - cell % width), abs(at // width - cell // width)
    turn = min(tracks.turns[1], tracks.turns[3]) if across and down else 0
    return int(tracks.runs[across] + tracks.runs[down] + turn)


@helper
def _departs(since: int, until: int, now: int, n: int, low: Ints, high: Ints) -> tuple[int, int]:
    """First and last departure from a tick to another, in windows; the first is the later one if there is none."""
    first, last = int(FOREVER), int(-FOREVER)
    for w in range(n):
        begin, end = max(low[now, w], since), min(high[now, w], until)
        if begin <= end:
            first, last = min(first, begin), end
    return first, last


@helper
def _note(state: int, cell: int, by: int, arrival: int, alone: int, waiting: int, problem: Problem) -> int:
    """Note that who is at rest in a state by a tick may arrive at another; labels that wait become one."""
    states = problem.memory.states
    if states[state, STAMP] != problem.number:
        states[state, STAMP], states[state, PLACE], states[state, DONE] = problem.number, -1, -FOREVER
    if by <= states[state, DONE]:
        return waiting
    if states[state, PLACE] >= 0:
        states[state, ARRIVAL] = max(by, states[state, ARRIVAL])
        if arrival >= states[state, DUE]:
            return waiting
        by = states[state, ARRIVAL]
    states[state, ARRIVAL], states[state, CELL], states[state, DUE] = by, cell, arrival
    states[state, REST] = alone - arrival
    return int(put(state, waiting, problem.memory))
