"""The compiled searches behind `travel`: Dijkstra over (cell, heading) at rest, with whole runs as moves.

All arrays are flat over cells. ``passable`` marks the cells that may be crossed, ``lane`` the station whose queue a
cell belongs to (-1: none), ``offsets`` the step in cell index per heading, ``runs`` the ticks of a run by its length,
and ``turns`` the ticks of a turn by heading difference.
"""

from __future__ import annotations

from heapq import heappop, heappush

import numpy as np
from numba import njit

FAR = 1 << 40


@njit(cache=True)
def times_to(goal, moves, passable, offsets, runs, turns):  # type: ignore[no-untyped-def]
    """Ticks from each (cell, heading) to rest at ``goal``: a search backwards from it."""
    cells = len(moves)
    times = np.full((cells, 4), FAR, np.int64)
    queue = [(0, goal * 4 + heading) for heading in range(4)]
    for heading in range(4):
        times[goal, heading] = 0
    while queue:
        time, state = heappop(queue)
        cell, heading = state // 4, state % 4
        if time > times[cell, heading]:
            continue
        for other in range(4):
            turned = time + turns[(heading - other) % 4]
            if turned < times[cell, other]:
                times[cell, other] = turned
                heappush(queue, (turned, cell * 4 + other))
        if not (passable[cell] or cell == goal):
            continue
        before = cell - offsets[heading]
        length = 1
        while 0 <= before < cells and moves[before] >> heading & 1:
            driven = time + runs[length]
            if driven < times[before, heading]:
                times[before, heading] = driven
                heappush(queue, (driven, before * 4 + heading))
            if not passable[before]:
                break
            before -= offsets[heading]
            length += 1
    return times


@njit(cache=True)
def times_from(start, start_heading, lane, moves, passable, offsets, runs, turns):  # type: ignore[no-untyped-def]
    """Ticks from standing at ``start`` to rest in each cell, whatever the heading there."""
    cells = len(moves)
    times = np.full((cells, 4), FAR, np.int64)
    times[start, start_heading] = 0
    queue = [(0, start * 4 + start_heading)]
    while queue:
        time, state = heappop(queue)
        cell, heading = state // 4, state % 4
        if time > times[cell, heading] or not (passable[cell] or cell == start):
            continue
        for other in range(4):
            turned = time + turns[(other - heading) % 4]
            if turned < times[cell, other]:
                times[cell, other] = turned
                heappush(queue, (turned, cell * 4 + other))
        after = cell
        length = 0
        while moves[after] >> heading & 1:
            after += offsets[heading]
            length += 1
            if lane[after] >= 0 and lane[after] != lane[start]:
                break
            driven = time + runs[length]
            if driven < times[after, heading]:
                times[after, heading] = driven
                heappush(queue, (driven, after * 4 + heading))
            if not passable[after]:
                break
    fastest = np.empty(cells, np.int64)
    for cell in range(cells):
        fastest[cell] = times[cell].min()
    return fastest


@njit(cache=True)
def descend(cell, heading, goal, times, moves, passable, offsets, runs, turns):  # type: ignore[no-untyped-def]
    """Ends of the runs of a fastest path, read off the table of ``times_to``."""
    ends = []
    while cell != goal:
        found = False
        for difference in (0, 1, 3, 2):
            towards = (heading + difference) % 4
            left = times[cell, heading] - turns[difference]
            after = cell
            length = 0
            while not found and moves[after] >> towards & 1:
                after += offsets[towards]
                length += 1
                if not (passable[after] or after == goal):
                    break
                if runs[length] + times[after, towards] == left:
                    found = True
            if found:
                cell = after
                heading = towards
                ends.append(cell)
                break
        if not found:
            raise ValueError("the table of times does not belong to this goal")
    return np.array(ends, dtype=np.int64)
