"""All robots' trips planned together: first paths by LaCAM, which are then made shorter one after another.

The first paths are slow, for robots push each other out of their ways. Each robot plans again alone, all others keeping
their paths, in rounds until one takes back less than a hundredth of all delay. Then a robot with a delay and some of
those in its way give up theirs and plan again in another order; what costs less is kept. At last each robot plans again
alone until none arrives earlier. A robot that the first paths bring elsewhere than to its goal plans once more alone at
first, and keeps its path if it finds none.

Nothing depends on seconds: effort is counted in queries.

Source: J. Li, Z. Chen, D. Harabor, P. J. Stuckey, S. Koenig, Anytime multi-agent path finding via large neighborhood
search, IJCAI 2021, https://doi.org/10.24963/ijcai.2021/568. First paths: `rmfs_commands.plan.lacam`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
from attrs import evolve

from rmfs_commands.plan.lacam import first_paths
from rmfs_commands.plan.movingai import Trip
from rmfs_commands.plan.planning import Plan, Planner
from rmfs_core.world import NORTH
from rmfs_traffic import FOREVER, Occupancy, Query, Reservations, Roads, TimedPath, occupancy, timed_path

CONFIGURATIONS = 10_000
"""How many configurations the search for first paths makes at most, besides one for each cell of the longest way."""
HOLD_TICKS = 5_000
"""How long robots of a group keep off the starts of others of it that have no path yet."""
GROUP = 8
"""Robots that plan again together."""
LITTLE = 0.01
"""Share of all delay that each of the first rounds of robots alone takes back at least, except for the last."""
FRUITLESS = 5
"""For each robot, groups in a row without a gain before the search for shorter paths ends."""


def plan_jointly(
    roads: Roads, planner: Planner, trips: Sequence[Trip], effort: int, rng: np.random.Generator
) -> tuple[Plan, ...]:
    """Plan every trip so that all arrive that can; all robots face north at first and set out at tick 0.

    Parameters
    ----------
    roads
        The layout.
    planner
        Finds each path, to its goal.
    trips
        One for each robot.
    effort
        How many queries for each robot, on average, go into shorter paths of groups. Those of robots alone are not
        limited.
    rng
        Draws groups, orders, and moves of first paths that are alike.

    Returns
    -------
    tuple[Plan, ...]
        One for each trip, in the same order.
    """
    search = Search(roads, planner, trips, first_paths(roads, trips, CONFIGURATIONS, rng), rng)
    search.shorten_alone(LITTLE)
    search.shorten(sum(search.queries) + effort * len(trips))
    search.shorten_alone()
    return search.plans()


class Search:
    """Paths that keep clear of each other, one for each robot; those that end at goals become shorter."""

    def __init__(
        self,
        roads: Roads,
        planner: Planner,
        trips: Sequence[Trip],
        paths: Sequence[TimedPath],
        rng: np.random.Generator,
    ) -> None:
        self.roads, self.planner, self.trips, self.rng = roads, planner, trips, rng
        self.table = Reservations(roads.cells)
        self.paths: dict[int, TimedPath] = {}
        self.occupied: dict[int, Occupancy] = {}
        self.queries = [0] * len(trips)
        self.fastest = [roads.travel.ticks(trip.start, NORTH, trip.goal, False) for trip in trips]
        for robot, path in enumerate(paths):
            self._commit(robot, path)
        for robot, trip in enumerate(trips):
            if paths[robot].end != trip.goal and (found := self._ask(robot, FOREVER)) is not None:
                self._commit(robot, found)
        self.arriving = [robot for robot, path in self.paths.items() if path.end == trips[robot].goal]

    # One path

    def _query(self, robot: int) -> Query:
        return Query(robot, self.trips[robot].start, NORTH, 0, self.trips[robot].goal)

    def _ask(self, robot: int, latest: int) -> TimedPath | None:
        """Ask the planner for a path that arrives before a tick; one that ends elsewhere is none."""
        self.queries[robot] += 1
        query = evolve(self._query(robot), latest=latest)
        path = self.planner.search(self.roads, self.table, query)
        return None if path is None or path.end != query.goal else path

    def _commit(self, robot: int, path: TimedPath) -> None:
        occupied = occupancy(self.roads, path)
        self.table.commit(robot, occupied)
        self.paths[robot], self.occupied[robot] = path, occupied

    def _hold(self, robot: int) -> None:
        """Keep the start of a robot without a path on the table for a while, or until another drives there."""
        self.table.release(robot)
        cell = self.trips[robot].start
        until = min([HOLD_TICKS, *(since for _, since, _ in self.table.reserved(cell))])
        if until > 0:
            self.table.add(robot, Occupancy(*(np.array([value], dtype=np.int64) for value in (cell, 0, until))))

    # Shorter paths

    def shorten(self, most: int) -> None:
        """Plan groups of robots again as long as there are queries left and hope."""
        self._alone = {robot: occupancy(self.roads, self._fastest_path(robot)) for robot in self.arriving}
        fruitless = 0
        while sum(self.queries) < most and fruitless < FRUITLESS * len(self.trips):
            delays = np.array([self._cost([robot]) - self.fastest[robot] for robot in self.arriving])
            if not delays.any():
                break
            chosen = int(self.rng.choice(self.arriving, p=delays / delays.sum()))
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
            if begin < until and end > since and owner != robot and owner in self._alone
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
            path = self._ask(robot, self.fastest[robot] + allowed - least)
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

    def shorten_alone(self, least_share: float = 0.0) -> None:
        """Plan each robot again while all others keep their paths, in rounds as long as they take back more delay."""
        least = sum(self.fastest[robot] for robot in self.arriving)
        delay, taken_back = self._cost(self.arriving) - least, math.inf
        while taken_back > least_share * delay:
            for robot in self.arriving:
                if self._cost([robot]) > self.fastest[robot]:
                    self._again([robot])
            taken_back = delay - (self._cost(self.arriving) - least)
            delay -= taken_back

    def plans(self) -> tuple[Plan, ...]:
        """Return what became of each trip."""
        return tuple(
            Plan(trip, self.paths[robot], self.paths[robot].end == trip.goal, self.fastest[robot], self.queries[robot])
            for robot, trip in enumerate(self.trips)
        )
