"""The compiled searches behind `travel`: Dijkstra over (cell, heading) at rest, with whole runs as moves.

All arrays are flat over cells. ``passable`` marks the cells that may be crossed, ``lane`` the station whose queue a
cell belongs to (-1: none), ``offsets`` the step in cell index per heading, ``runs`` the ticks of a run by its length,
and ``turns`` the ticks of a turn by heading difference. A state is ``4 * cell + heading``.

A run is driven on only while it can still be the fastest to some cell ahead (`Work.losses`, `Work.gains`): that leaves
one or two cells of most runs. States wait in lists, one for each short span of ticks (Dial's buckets).
"""

from __future__ import annotations

from itertools import pairwise, permutations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core import clock
from rmfs_core.jit import helper, is_interpreting, njit
from rmfs_core.world.grid import EAST, NORTH, SOUTH, STEPS, WEST

FAR = clock.UNREACHABLE
far: Any = helper(clock.far)
DETOURS = 4
"""Stops with a turn more than there must be that a way may have before a search with more of them is begun."""
LAST, IDLE = -1, -2
"""Instead of the state that waits behind another in its bucket: none does, and that one does not wait itself."""
MOST_BUCKETS = 4096


class Work(NamedTuple):
    """Memory for one search after the other, with tables of runs made beforehand.

    Parameters
    ----------
    driven
        By state: the length of the run that it was reached by, 0 for a turn.
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
        only while that one speeds up yet, and nothing more once both have driven half the distance that is left.
    onwards
        Whether two runs may be as fast as one instead of both, except for rounding. If not, turns follow runs.
    down, sides, across
        Ticks from a state to each (cell, heading) at least: ``down`` by row, and ``across`` by column and heading, for
        rows before, at and after its own, as ``sides`` says; its last row is for reckoning.
    step, stop
        Ticks that a run takes at least by cell, and besides.
    least
        Ticks of turns at least from one heading to another by way of headings to other rows and columns. Shape
        (3, 3, 4, 4): rows before, at and after one's own, columns, from, to.
    """

    driven: NDArray[np.int16] | NDArray[np.int32]
    links: NDArray[np.int32]
    buckets: NDArray[np.int32]
    shift: int
    losses: NDArray[np.int64]
    gains: NDArray[np.int64]
    onwards: bool
    down: NDArray[np.int64]
    sides: NDArray[np.int64]
    across: NDArray[np.int64]
    step: int
    stop: int
    least: NDArray[np.int64]


def times_on(cells: int, runs: NDArray[np.int64], turns: NDArray[np.int64]) -> Any:
    """Return what type of number holds the ticks of all ways on a grid of so many cells, and of a move more.

    Interpreted, a sum of two small numbers is one that small, so they are large then.
    """
    if is_interpreting():
        return np.int64
    slowest = cells * int(runs[1] + 2 * turns.max())  # no way visits a cell twice with one heading
    return np.int32 if 4 * slowest + int(runs[-1] + turns.max()) < 1 << 31 else np.int64


def work_on(height: int, width: int, runs: NDArray[np.int64], turns: NDArray[np.int64]) -> Work:
    """Return what searches on a grid write on."""
    cells, longest, length = height * width, len(runs) - 1, np.arange(len(runs))
    more = (longest - length) // 2
    gains = runs[length + more] - runs - (runs[-1] - runs[longest - more]) + 4
    move, shift = int(runs[-1] + turns.max()), 0
    while 2 << shift <= runs[1] or 2 * move >> shift > MOST_BUCKETS:
        shift += 1
    buckets = np.full(1 << ((2 * move >> shift) + 2).bit_length(), LAST, np.int32)  # a power of two
    links, losses = np.full(4 * cells, IDLE, np.int32), runs + runs[::-1] - runs[-1] + 4
    onwards = bool(2 * runs[1] - runs[min(2, longest)] < 3)  # the closest call; each is rounded by half a tick
    driven: NDArray[np.int32] = np.empty(4 * cells, np.int16 if longest < 1 << 15 else np.int32)
    down, sides = np.empty(height, np.int64), np.empty(height, np.int64)
    across: NDArray[np.int64] = np.empty((4, 4 * width), times_on(cells, runs, turns))
    step = int(np.diff(runs).min())
    stop = int((runs - step * length)[1:].min())
    return Work(
        driven, links, buckets, shift, losses, gains, onwards, down, sides, across, step, stop, _least(turns)
    )  # fmt: skip


def _least(turns: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the ticks of turns by way of others, as `Work` has them."""
    quick = [min(int(turns[a]) + int(turns[d - a]) for a in range(4)) for d in range(4)]  # one turn or two
    least = np.empty((3, 3, 4, 4), np.int64)
    for row, column, start, end in np.ndindex(least.shape):
        ways = permutations(((NORTH,), (), (SOUTH,))[row] + ((WEST,), (), (EAST,))[column])
        least[row, column, start, end] = min(sum(quick[b - a] for a, b in pairwise((start, *way, end))) for way in ways)
    return least


@njit(cache=True, interpreted=True)
def times_to(goal, times, moves, passable, offsets, runs, turns, work):
    """Write to ``times`` ticks from each (cell, heading) to rest at ``goal``: a search backwards from it."""
    _spread(goal, times, None, 0, FAR, moves, passable, offsets, runs, turns, work)


@njit(cache=True, interpreted=True)
def times_near(goal, times, start, spare, moves, passable, offsets, runs, turns, work):
    """As `times_to` for ways from a state that are at most ``spare`` ticks longer than the fastest; too low elsewhere.

    Returns how long ways may be: that, or `FAR` if there is none. What is no part of such a way gets what would be
    left of it: no more than its time.
    """
    width = offsets[SOUTH]
    _look(start, width, work)
    there = _way(0, start, goal // width, goal % width, EAST, work)
    limit = there + spare + DETOURS * (work.stop + turns[1])
    while True:
        within = _spread(goal, times, start, spare, limit, moves, passable, offsets, runs, turns, work)
        if within <= limit:
            break
        limit = np.int64(FAR)
    if within >= far(times):
        return FAR  # there is no way, or none is so long: all are right
    number = times.dtype.type  # arithmetic in that type is done on several at once
    for row in range(len(work.down)):
        here, left = times[4 * width * row : 4 * width * (row + 1)], number(within - work.down[row])
        np.subtract(left, work.across[work.sides[row]], work.across[3])
        np.minimum(here, work.across[3], here)
        np.maximum(here, number(0), here)
    return within


@helper
def _look(start, width, work):
    """Write to ``work`` ticks that a way takes at least from a state to each (cell, heading).

    That is top speed all the way, a stop for a row to drive along and one for a column, and the turns for them and to
    the heading. No move takes less than these ticks change by, and along a run a way through its end gets no shorter,
    except for one stop.
    """
    row, column = start // 4 // width, start // 4 % width
    for other in range(len(work.down)):
        away = abs(other - row)
        work.down[other] = work.step * away + work.stop * min(away, 1)
        work.sides[other] = 0 if other < row else 1 + (other > row)
    for side in range(3):
        for other in range(width):
            away, aside = abs(other - column), 0 if other < column else 1 + (other > column)
            for heading in range(4):
                turned = work.least[side, aside, start % 4, heading]
                work.across[side, 4 * other + heading] = work.step * away + work.stop * min(away, 1) + turned


@helper
def _spread(goal, times, start, spare, limit, moves, passable, offsets, runs, turns, work):
    """Search backwards from a goal, with a ``start`` only as far as `times_near` says, and by ways of so many ticks.

    Then a state waits by the least that a way through it takes, and one too long for the fastest way so far is none.
    Returns the ticks of the fastest way and those to spare, `FAR` if there is none.
    """
    driven, links, buckets, shift, losses, gains, onwards, _, _, _, _, stop, _ = work
    width = offsets[SOUTH]
    times.fill(far(times))
    waiting = bucket = 0
    within = np.int64(limit)
    for heading in range(4):
        way = _way(0, start, goal // width, goal % width, heading, work)
        waiting += _reach(4 * goal + heading, 0, way, 0, times, driven, links, buckets, shift)
    while waiting:
        while buckets[bucket] < 0:
            bucket, within = (bucket + 1) & (len(buckets) - 1), min(limit, _within(start, spare, times))
        state = buckets[bucket]
        buckets[bucket], links[state] = links[state], IDLE
        waiting -= 1
        time, cell = times[state], state >> 2
        if time and not driven[state]:
            continue  # turned to while it waited
        row, column = cell // width, cell % width
        for difference in range(1 if time and not onwards else 0, 4):
            heading, turned = (state - difference) & 3, time + turns[difference]
            if turned < times[4 * cell + heading]:
                times[4 * cell + heading], driven[4 * cell + heading] = turned, 0
            elif difference:
                continue
            before, length, passes = cell - offsets[heading], 1, True
            while passes and 0 <= before < len(moves) and moves[before] >> heading & 1:
                into, arrival, passes = 4 * before + heading, turned + runs[length], passable[before]
                up, aside = row - length * STEPS[heading][1], column - length * STEPS[heading][0]
                way = _way(arrival, start, up, aside, heading, work)
                if way > within + stop:
                    break  # and so is every longer run, even with a stop less
                if arrival < times[into]:
                    if way <= within:
                        waiting += _arrive(
                            into, arrival, way, length, passes, turns, times, driven, links, buckets, shift
                        )
                elif arrival - times[into] > min(losses[length], gains[driven[into]]):
                    break
                before -= offsets[heading]
                length += 1
    return _within(start, spare, times)


@helper
def _way(ticks, start, row, column, heading, work):
    """Ticks of a way at least: those from (cell, heading) on and, with a start, those from there."""
    if start is None:
        return ticks
    return ticks + work.down[row] + work.across[work.sides[row], 4 * column + heading]


@helper
def _arrive(into, time, way, length, passes, turns, times, driven, links, buckets, shift):
    """Note that a state is reached by a run; if no run passes it need not wait. Returns 1 if it waits from now on."""
    if passes:
        return _reach(into, time, way, length, times, driven, links, buckets, shift)
    times[into], driven[into] = time, length
    for difference in range(1, 4):
        state = 4 * (into >> 2) + ((into - difference) & 3)
        if time + turns[difference] < times[state]:
            times[state], driven[state] = time + turns[difference], 0
    return 0


@helper
def _within(start, spare, times):
    """Ticks of the fastest way found so far from a start, if any, and those to spare."""
    return FAR if start is None or times[start] >= far(times) else np.int64(times[start]) + spare


@njit(cache=True, interpreted=True)
def times_from(start, start_heading, times, lane, moves, passable, offsets, runs, turns, work):
    """Ticks from standing at ``start`` to rest in each cell, whatever the heading there."""
    driven, links, buckets, shift, losses, gains, onwards, _, _, _, _, _, _ = work
    times.fill(far(times))
    waiting, bucket = _reach(4 * start + start_heading, 0, 0, 0, times, driven, links, buckets, shift), 0
    while waiting:
        while buckets[bucket] < 0:
            bucket = (bucket + 1) & (len(buckets) - 1)
        state = buckets[bucket]
        buckets[bucket], links[state] = links[state], IDLE
        waiting -= 1
        time, cell = times[state], state >> 2
        if time and not driven[state]:
            continue
        for difference in range(1 if time and not onwards else 0, 4):
            heading, turned = (state + difference) & 3, time + turns[difference]
            if turned < times[4 * cell + heading]:
                times[4 * cell + heading], driven[4 * cell + heading] = turned, 0
            elif difference:
                continue
            after, length, passes = cell, 0, True
            while passes and moves[after] >> heading & 1:
                after += offsets[heading]
                length += 1
                into, arrival, passes = 4 * after + heading, turned + runs[length], passable[after]
                if lane[after] >= 0 and lane[after] != lane[start]:
                    break
                if arrival < times[into]:
                    waiting += _arrive(
                        into, arrival, arrival, length, passes, turns, times, driven, links, buckets, shift
                    )
                elif arrival - times[into] > min(losses[length], gains[driven[into]]):
                    break
    fastest = np.empty(len(moves), times.dtype)
    for cell in range(len(moves)):
        at = 4 * cell
        fastest[cell] = min(times[at], times[at + 1], times[at + 2], times[at + 3])
    return wide(fastest)


@njit(cache=True, interpreted=True)
def wide(times):
    """Return times in eight bytes each, whatever they have, and `FAR` for what is not reached."""
    table = np.empty(len(times), np.int64)
    for i in range(len(times)):
        table[i] = times[i] if times[i] < far(times) else FAR
    return table


@helper
def _reach(state, time, way, length, times, driven, links, buckets, shift):
    """Note that a state is reached earlier than before, and let it wait by its ``way``; returns 1 if it did not yet."""
    times[state], driven[state] = time, length
    if links[state] != IDLE:
        return 0
    bucket = (way >> shift) & (len(buckets) - 1)
    links[state], buckets[bucket] = buckets[bucket], state
    return 1


@njit(cache=True, interpreted=True)
def descend(cell, heading, goal, times, moves, passable, offsets, runs, turns):
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


@njit(cache=True, interpreted=True)
def straight_run(at, to, width):
    """Heading and number of cells of a straight run; -1 cells where it is none."""
    if at // width == to // width:
        return (0 if to > at else 2), abs(to - at)
    return (1 if to < at else 3), (abs(to - at) // width if at % width == to % width else -1)


@njit(cache=True, interpreted=True)
def wrong_leg(cell, goal, legs, longest, width, moves, from_start, to_goal):
    """Number of the first leg that a robot cannot drive on its way from a cell to a goal; -1 if it can drive all.

    ``longest`` is the longest wait; ``from_start`` and ``to_goal`` say which cells may be crossed.
    """
    at = cell
    for i in range(len(legs)):
        to, wait = legs[i, 0], legs[i, 1]
        if not (0 <= to < len(moves) and 0 <= wait <= longest) or (to == at and wait == 0):
            return i
        towards, length = straight_run(at, to, width)
        if length < 0:
            return i
        step = (to - at) // max(length, 1)
        while at != to:
            if not moves[at] >> towards & 1:
                return i
            at += step
            if not (from_start[at] or to_goal[at] or at == goal):
                return i
    return -1
