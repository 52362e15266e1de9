"""The search of `rmfs_rules.sipp` in plain Python: what the compiled one is held against, and the one to read.

It arrives at the same tick; where several paths do, it may take another one.
"""

from heapq import heappop, heappush

from rmfs_core.clock import UNREACHABLE
from rmfs_core.decisions import Leg
from rmfs_traffic import FOREVER, Query, Reservations, Roads, TimedPath, timed_path

Window = tuple[int, int]
State = tuple[int, int, int]
"""Cell, heading, and end of the gap."""


def gaps(table: Reservations, cell: int, owner: int) -> list[tuple[int, int]]:
    """Gaps, half-open and ascending, in which nobody but ``owner`` has a cell; the first begins at ``-FOREVER``."""
    found, free_since = [], -FOREVER
    for who, since, until in table.reserved(cell):
        if who != owner:
            if since > free_since:
                found.append((free_since, since))
            free_since = until
    return [*found, (free_since, FOREVER)] if free_since < FOREVER else found


class PlainSearch:
    """One query, of who wants to go where among reservations."""

    def __init__(self, roads: Roads, table: Reservations, query: Query) -> None:
        self.roads = roads
        self.query = query
        tracks = roads.tracks(query.goal, query.loaded)
        self.moves: list[int] = tracks.moves.tolist()
        self.passable: list[bool] = tracks.passable.tolist()
        self.offsets: list[int] = tracks.offsets.tolist()
        self.runs: list[int] = tracks.runs.tolist()
        self.turns: list[int] = tracks.turns.tolist()
        self.enter: list[list[int]] = tracks.enter.tolist()
        self.leave: list[list[int]] = tracks.leave.tolist()
        self.common: list[int] = tracks.common.tolist()
        self.times: list[list[int]] = roads.travel.times_to(query.goal, query.loaded).tolist()
        self.gaps = [gaps(table, cell, query.robot) for cell in range(roads.cells)]
        self.arrival: dict[State, int] = {}
        self.parent: dict[State, tuple[State, int]] = {}
        self.expanded = 0

    def run(self) -> TimedPath | None:
        query = self.query
        here = [gap for gap in self.gaps[query.cell] if gap[0] <= query.start_tick < gap[1]]
        last = self.gaps[query.goal][-1:]
        if not here or not last or last[0][1] < FOREVER or self.times[query.cell][query.heading] >= UNREACHABLE:
            return None
        if query.cell == query.goal and here == last:
            return timed_path(self.roads, query, ())
        braking = min(ticks - self.enter[k][k] for k, ticks in enumerate(self.runs) if k)
        bound = max(last[0][0] + braking, 0)
        start = (query.cell, query.heading, here[0][1])
        self.arrival[start] = query.start_tick
        rest = self.times[query.cell][query.heading]
        queue = [(max(query.start_tick + rest, bound), rest, start, query.start_tick)]
        while queue:
            _, _, state, time = heappop(queue)
            if time > self.arrival[state]:
                continue
            if state[0] == query.goal and state[2] >= FOREVER:
                return timed_path(self.roads, query, self._legs(state))
            if state[0] == query.goal and state in self.parent and not self.passable[query.goal]:
                continue  # a storage location is no way through for a robot with a pod
            self.expanded += 1
            for into, ticks, departure in self._successors(state, time):
                rest = self.times[into[0]][into[1]]
                if rest < UNREACHABLE and ticks < self.arrival.get(into, FOREVER):
                    self.arrival[into] = ticks
                    self.parent[into] = (state, departure)
                    heappush(queue, (max(ticks + rest, bound), rest, into, ticks))
        return None

    def _successors(self, state: State, time: int) -> list[tuple[State, int, int]]:
        found: list[tuple[State, int, int]] = []
        cell, heading, gap_end = state
        for towards in range(4):
            ready = time + self.turns[(towards - heading) % 4]
            offset = self.offsets[towards]
            windows = [(ready, FOREVER)]
            common, length, at = 1, 0, cell
            while self.moves[at] >> towards & 1:
                at += offset
                length += 1
                if not (self.passable[at] or at == self.query.goal):
                    break
                while common < min(self.common[length], length):
                    windows = self._narrow(windows, cell + common * offset, -1, common)
                    common += 1
                if not windows:
                    break
                free = windows
                for i in range(common, length):
                    free = self._narrow(free, cell + i * offset, length, i)
                found += self._arrivals(free, gap_end - self.leave[length][0], length, at, towards)
                if not self.passable[at]:
                    break
        return found

    def _narrow(self, windows: list[Window], cell: int, length: int, i: int) -> list[Window]:
        enter, leave = self.enter[length][i], self.leave[length][i]
        free = []
        for since, until in self.gaps[cell]:
            for low, high in windows:
                begin, end = max(low, since - enter), min(high, until - leave)
                if begin <= end:
                    free.append((begin, end))
        return free

    def _arrivals(
        self, windows: list[Window], leave_by: int, length: int, at: int, towards: int
    ) -> list[tuple[State, int, int]]:
        found = []
        for since, until in self.gaps[at]:
            for low, high in windows:
                departure = max(low, since - self.enter[length][length])
                if departure <= min(high, leave_by, until - self.runs[length]):
                    found.append(((at, towards, until), departure + self.runs[length], departure))
                    break
        return found

    def _legs(self, state: State) -> tuple[Leg, ...]:
        legs = []
        while state in self.parent:
            before, departure = self.parent[state]
            turn = self.turns[(state[1] - before[1]) % 4]
            legs.append(Leg(state[0], departure - turn - self.arrival[before]))
            state = before
        return tuple(reversed(legs))


def search(roads: Roads, table: Reservations, query: Query) -> TimedPath | None:
    """Return what `Sipp.search` returns, some tens of times more slowly."""
    return PlainSearch(roads, table, query).run()
