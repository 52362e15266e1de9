"""Safe interval path planning with exact kinematics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from attrs import define, field

from rmfs_core import Path, hookimpl
from rmfs_rules.sipp import compiled
from rmfs_rules.sipp.states import memory_for
from rmfs_traffic import timed_path
from rmfs_traffic.searching import Asked, search_once

if TYPE_CHECKING:
    from rmfs_traffic import Query, Reservations, Roads, TimedPath, Tracks, Traffic

LATER_TICKS = 3_000, 15_000, 60_000
"""How much later than without traffic paths arrive of which the times are looked up first; most are in time."""


@define(eq=False)
class _Memory:
    """Arrays of the compiled search, kept from query to query."""

    arrays: Any = None
    searches: int = 0

    def next(self, table: Reservations) -> int:
        """Allocate arrays for a search of a table and return the search's number."""
        gaps = len(table.arrays.since)  # their numbers are below this
        if self.arrays is None or len(self.arrays[1]) < 4 * gaps:
            self.arrays, self.searches = tuple(memory_for(gaps)), 0
        self.searches += 3  # as many numbers as a search may take
        return self.searches


@define
class Sipp:
    """Drive the path that arrives first among the reservations of the other robots.

    A search over (cell, heading, gap between reservations) at rest. From a state a robot waits, turns, and drives a
    straight run of any length that ends at rest. For a run, the departures at which all its cells are free are a few
    windows; they are narrowed cell by cell, once for all lengths, since runs differ only where they brake. Of each gap
    that a run can end in only the earliest arrival counts: a robot that comes earlier can wait there until any later
    time. Estimates are exact times without traffic, and never earlier than the goal is free for good, because a path
    has to end with a hold of the goal without end. Where even that is far too early, a search from the goal finds out
    when a path can arrive at all (`backwards.py`). Among equal estimates the state nearest to the goal goes first, then
    the one of the lower cell, the earlier gap, the lower heading: the result is the same on every machine, and does not
    depend on what is over.

    The arrival is the earliest that any path made of such moves has, waiting times being free to the tick.

    References
    ----------
    H. Ma, W. Hoenig, T. K. S. Kumar, N. Ayanian, S. Koenig: Lifelong path planning with kinematic constraints for
    multi-agent pickup and delivery. AAAI 2019. https://doi.org/10.1609/aaai.v33i01.33017651
    """

    reserves: ClassVar[str] = "full paths"

    _memory: _Memory = field(init=False, factory=_Memory, repr=False, eq=False)

    def prepare(self, roads: Roads) -> None:
        """Load the compiled search, or compile it."""
        search_once(self.search, roads)

    @hookimpl
    def plan_path(self, traffic: Traffic) -> Path | None:
        """Return the path that arrives first; None when there is none, which the way of driving excludes."""
        roads, table, query = traffic.roads, traffic.table, traffic.query
        latest = query.latest
        for spare in LATER_TICKS:
            times, within = roads.travel.times_near(query.cell, query.heading, query.goal, query.loaded, spare)
            soon = query.start_tick + within
            path = self._path(table, query, min(latest, soon), roads.tracks(query.goal, query.loaded, times))
            if path is not None or soon >= latest:
                return path
        return self._path(table, query, latest, roads.tracks(query.goal, query.loaded))

    def search(self, roads: Roads, table: Reservations, query: Query) -> TimedPath | None:
        """Return the path that arrives first and may stay at the goal forever; None when there is none."""
        path = self._path(table, query, query.latest, roads.tracks(query.goal, query.loaded))
        return None if path is None else timed_path(roads, query, path.legs)

    def _path(self, table: Reservations, query: Query, latest: int, tracks: Tracks) -> Path | None:
        memory, number = self._memory, self._memory.next(table)
        ends: Any = compiled.search(
            Asked.by(query), latest, number, compiled.LITTLE, tuple(tracks), tuple(table.arrays), memory.arrays
        )
        return None if ends is None else Path(ends)
