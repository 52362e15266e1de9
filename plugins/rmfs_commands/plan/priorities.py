"""Priority search: a robot that prioritised planning leaves without a path gets one, and others yield.

Paths are planned one after another over one reservation table, each from the start of its trip. A robot without a path
holds its start for a while only, so that others may drive over it later. A robot that finds no path takes priority over
those that have failed least often: as few of these as possible leave the table for it, and the robots that its path
hits plan again later. Each time that a robot fails, the others have to keep off its start twice as long: a robot
that never gets away is blocked by a robot in a hurry.

When all have paths, these are made shorter: a robot with a delay and some of those in its way give up theirs and plan
again in another order; what costs less is kept. At last each robot plans again alone, all others keeping their paths,
until none arrives earlier: delays that were drawn (a robot that has failed often may set out later than at once) are
taken back where nobody needs them.

Nothing depends on seconds: effort is counted in queries.

Sources: H. Ma, D. Harabor, P. J. Stuckey, J. Li, S. Koenig, Searching with consistent prioritization for multi-agent
path finding, AAAI 2019, https://doi.org/10.1609/aaai.v33i01.33017643 (conflicts refine the priorities); Y. Nagata, O.
Braeysy, A powerful route minimization heuristic for the vehicle routing problem with time windows, Operations Research
Letters 37(5), 2009, https://doi.org/10.1016/j.orl.2009.04.006 (who cannot be inserted ejects those that failed least
often); J. Li, Z. Chen, D. Harabor, P. J. Stuckey, S. Koenig, Anytime multi-agent path finding via large neighborhood
search, IJCAI 2021, https://doi.org/10.24963/ijcai.2021/568 (shorter paths).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence

import numpy as np
from attrs import evolve

from rmfs_commands.plan.movingai import Trip
from rmfs_commands.plan.planning import Plan, Planner, plan_trips
from rmfs_core.decisions import Leg
from rmfs_core.world import NORTH
from rmfs_traffic import Occupancy, Query, Reservations, Roads, TimedPath, occupancy, timed_path

HOLD_TICKS = 5_000
"""How long others keep off the start of a robot that has no path yet, the first time."""
MOST_HOLD_TICKS = 1_000_000
PATIENCE = 3
LEAST = 500
HURRIES = 3
"""How often a robot fails before it may set out later than at once."""
FEW = 4
"""Robots that leave the table at first for one that finds no path."""
GROUP = 8
"""Robots that plan again together."""
FRUITLESS = 5
"""For each robot, groups in a row without a gain before the search for shorter paths ends."""


def plan_by_priorities(
    roads: Roads, planner: Planner, trips: Sequence[Trip], effort: int, rng: np.random.Generator
) -> tuple[Plan, ...]:
    """Plan every trip so that all arrive, in the order given at first; all face north and set out at tick 0.

    Parameters
    ----------
    roads
        The layout.
    planner
        Finds each path, to its goal.
    trips
        One for each robot.
    effort
        How many queries for each robot, on average, go into shorter paths of groups; until all have one, there may be
        `PATIENCE` times as many, and at least `LEAST` in all. Those of robots alone at the end are not limited.
    rng
        Draws groups and orders.

    Returns
    -------
    tuple[Plan, ...]
        Where some have found no path, those of planning in one order.
    """
    search = Search(roads, planner, trips, rng)
    most = effort * len(trips)
    if search.find(max(PATIENCE * most, LEAST)):
        search.shorten(sum(search.queries) + most)
        search.shorten_alone()
        return search.plans()
    plans = plan_trips(roads, planner, trips)
    return tuple(evolve(plan, queries=plan.queries + n) for plan, n in zip(plans, search.queries, strict=True))


class Search:
    """Paths that keep clear of each other, and who has none yet."""

    def __init__(self, roads: Roads, planner: Planner, trips: Sequence[Trip], rng: np.random.Generator) -> None:
        self.roads, self.planner, self.trips, self.rng = roads, planner, trips, rng
        self.table = Reservations(roads.cells)
        self.paths: dict[int, TimedPath] = {}
        self.occupied: dict[int, Occupancy] = {}
        self.queries = [0] * len(trips)
        self.failures = [0] * len(trips)  # how often a robot found no path
        self.planned_at = [0] * len(trips)
        self.fastest = [roads.travel.ticks(trip.start, NORTH, trip.goal, False) for trip in trips]
        for robot in range(len(trips)):
            self._hold(robot)

    # One path

    def _query(self, robot: int) -> Query:
        return Query(robot, self.trips[robot].start, NORTH, 0, self.trips[robot].goal)

    def _ask(self, robot: int, delay: int = 0) -> TimedPath | None:
        """Ask the planner for a path that sets out after so many ticks; one that ends elsewhere is none."""
        self.queries[robot] += 1
        query = self._query(robot)
        delay = min([delay, *(since for who, since, _ in self.table.reserved(query.cell) if who != robot)])
        path = self.planner.search(self.roads, self.table, evolve(query, start_tick=delay))
        if path is None or path.end != query.goal:
            return None
        if delay == 0 or not path.legs:
            return path
        first, *rest = path.legs
        return timed_path(self.roads, query, (Leg(first.to, first.wait_ticks + delay), *rest))

    def _delay(self, robot: int) -> int:
        """Return when a robot is to set out: some time, half the time, if it has failed often.

        Two that have to make way for each other would else hurry until they face each other.
        """
        if self.failures[robot] < HURRIES or self.rng.random() < 0.5:
            return 0
        return int(self.rng.integers(self._start_held(robot)))

    def _commit(self, robot: int, path: TimedPath) -> None:
        occupied = occupancy(self.roads, path)
        self.table.commit(robot, occupied)
        self.paths[robot], self.occupied[robot] = path, occupied

    def _hold(self, robot: int) -> None:
        """Keep the start of a robot without a path on the table for a while, or until another drives there."""
        self.table.release(robot)
        cell = self.trips[robot].start
        until = min([self._start_held(robot), *(since for _, since, _ in self.table.reserved(cell))])
        if until > 0:
            self.table.add(robot, Occupancy(*(np.array([value], dtype=np.int64) for value in (cell, 0, until))))

    def _start_held(self, robot: int) -> int:
        return min(HOLD_TICKS << min(self.failures[robot], 20), MOST_HOLD_TICKS)

    # All paths

    def find(self, most: int) -> bool:
        """Plan until each robot has a path; return whether that is so before there were too many queries."""
        waiting = deque(range(len(self.trips)))
        turn = 0
        while waiting and sum(self.queries) < most:
            robot = waiting.popleft()
            turn += 1
            self.planned_at[robot] = turn
            path = self._ask(robot, self._delay(robot))
            if path is not None:
                self._commit(robot, path)
                continue
            self.failures[robot] += 1
            self._hold(robot)
            waiting.extend(self._take_priority(robot))
        return len(self.paths) == len(self.trips)

    def _take_priority(self, robot: int) -> list[int]:
        """Give a robot a path that hits only robots that failed seldom; return who has lost theirs, or no path."""
        ranked = sorted(self.paths, key=lambda other: (self.failures[other], self.planned_at[other]))
        path, low, high = None, 0, len(ranked)  # the least number to take off the table is in (low, high]
        off, number, delay = 0, min(FEW, high), self._delay(robot)
        while path is None or high - low > max(1, high // 8):
            off = self._take_off(ranked, off, number)
            found = self._ask(robot, delay)
            if found is not None:
                path, high = found, number
            elif number == high:
                break
            else:
                low = number
            number = min(3 * number, high) if path is None else (low + high) // 2
        off = self._take_off(ranked, off, high)
        if path is None:  # not even alone, with all others at their starts
            for other in range(len(self.trips)):
                self.table.release(other)
            path = self._ask(robot)
        return self._put_back(robot, path, ranked[:off])

    def _take_off(self, ranked: Sequence[int], off: int, number: int) -> int:
        """Take the paths of the first so many off the table, of which ``off`` are off it."""
        for other in ranked[off:number]:
            self._hold(other)
        for other in ranked[number:off]:
            self.table.release(other)
        for other in ranked[number:off]:
            self.table.commit(other, self.occupied[other])
        return number

    def _put_back(self, robot: int, path: TimedPath | None, off: Sequence[int]) -> list[int]:
        """Reserve a path first, and then the paths taken off the table; return who is left without."""
        for other in range(len(self.trips)):
            if other not in self.paths or other in off:
                self.table.release(other)
        if path is not None:
            self._commit(robot, path)
        losers = [] if path is not None else [robot]
        for other in reversed(off):
            if self.table.is_free(other, self.occupied[other]):
                self.table.commit(other, self.occupied[other])
            else:
                losers.append(other)
                del self.paths[other], self.occupied[other]
        for other in range(len(self.trips)):
            if other not in self.paths:
                self._hold(other)
        return losers

    # Shorter paths

    def shorten(self, most: int) -> None:
        """Plan groups of robots again as long as there are queries left and hope."""
        self._alone = [occupancy(self.roads, self._fastest_path(robot)) for robot in range(len(self.trips))]
        fruitless = 0
        while sum(self.queries) < most and fruitless < FRUITLESS * len(self.trips):
            delays = np.array([self._cost([robot]) - self.fastest[robot] for robot in range(len(self.trips))])
            if not delays.any():
                break
            chosen = int(self.rng.choice(len(delays), p=delays / delays.sum()))
            fruitless = 0 if self._again(self._group(chosen)) else fruitless + 1

    def _cost(self, robots: Iterable[int]) -> int:
        return sum(self.paths[robot].end_tick for robot in robots)

    def _fastest_path(self, robot: int) -> TimedPath:
        trip = self.trips[robot]
        legs = self.roads.travel.fastest_path(trip.start, NORTH, trip.goal, False)
        return timed_path(self.roads, self._query(robot), tuple(legs))

    def _group(self, robot: int) -> list[int]:
        """Return a robot and some that it would meet on its fastest path, in random order."""
        alone = self._alone[robot]
        met = {
            owner
            for cell, since, until in zip(alone.cells.tolist(), alone.since.tolist(), alone.until.tolist(), strict=True)
            for owner, begin, end in self.table.reserved(cell)
            if begin < until and end > since and owner != robot
        }
        others = self.rng.permutation(sorted(met)).tolist()[: GROUP - 1]
        return [int(one) for one in self.rng.permutation([robot, *others])]

    def _again(self, group: Sequence[int]) -> bool:
        """Plan a group again in its order; return whether that cost less, and leave all as it was if not."""
        before = {robot: (self.paths[robot], self.occupied[robot]) for robot in group}
        least, allowed = sum(self.fastest[robot] for robot in group), self._cost(group)
        for robot in group:
            self._hold(robot)
        for robot in group:
            path = self._ask(robot)
            if path is None:
                break
            least += path.end_tick - self.fastest[robot]
            if least >= allowed:
                break
            self._commit(robot, path)
        else:
            return True
        for robot in group:
            self.table.release(robot)
        for robot, (path, occupied) in before.items():
            self.table.commit(robot, occupied)
            self.paths[robot], self.occupied[robot] = path, occupied
        return False

    def shorten_alone(self) -> None:
        """Plan each robot again while all others keep their paths, one after another, until none arrives earlier."""
        robot = fruitless = 0
        while fruitless < len(self.trips):
            earlier = self._cost([robot]) > self.fastest[robot] and self._again([robot])
            fruitless = 0 if earlier else fruitless + 1
            robot = (robot + 1) % len(self.trips)

    def plans(self) -> tuple[Plan, ...]:
        """Return what became of each trip, when each robot has a path."""
        return tuple(
            Plan(trip, self.paths[robot], arrived=True, fastest_ticks=self.fastest[robot], queries=self.queries[robot])
            for robot, trip in enumerate(self.trips)
        )
