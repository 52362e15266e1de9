"""Queries to a planner, its answers, and the cells that they occupy over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_core.decisions import Leg, Path, Rows, ends_of
from rmfs_traffic.roads import Roads

FOREVER = 1 << 50
"""End, in ticks, of what has no end."""


class Stop(NamedTuple):
    """Where a robot is at rest, and when it may set out from there."""

    cell: int
    heading: int
    start_tick: int


@frozen
class Query:
    """A robot asks for a path.

    Parameters
    ----------
    robot
        Its id, the owner of its reservations; they do not stand in its own way.
    cell, heading
        Where it stands at rest.
    start_tick
        When it may set out.
    goal
        Cell index it has to reach.
    loaded
        Whether it carries a pod.
    latest
        A path is of use only if it arrives before that tick; a rule may give up where none does.
    """

    robot: int
    cell: int
    heading: int
    start_tick: int
    goal: int
    loaded: bool = False
    latest: int = FOREVER


@frozen
class TimedPath:
    """A path with its times.

    Parameters
    ----------
    cell, heading, start_tick
        Where and when it begins, at rest.
    legs
        Legs of the path. A leg waits, turns and runs; the next one follows at once.
    end, end_heading
        Where it ends: not the goal, where a window ended it before.
    end_tick
        When the robot is at rest there.
    """

    cell: int
    heading: int
    start_tick: int
    legs: tuple[Leg, ...]
    end: int
    end_heading: int
    end_tick: int

    @property
    def path(self) -> Path:
        """The decision that the hook `plan_path` returns."""
        return Path(self.legs)


@frozen(eq=False)
class Occupancy:
    """Cells and the half-open intervals of ticks in which they are occupied: arrays of equal length."""

    cells: NDArray[np.int64]
    since: NDArray[np.int64]
    until: NDArray[np.int64]


def timed_path(roads: Roads, query: Query, legs: tuple[Leg, ...]) -> TimedPath:
    """Return a path with its times, from its legs alone: wait, turn, run, and on."""
    return TimedPath(query.cell, query.heading, query.start_tick, legs, *drive(roads, query, legs)[1])


def drive(
    roads: Roads, start: Query | Stop, legs: Sequence[Leg] | Rows, since: int | None = None
) -> tuple[Occupancy, Stop]:
    """Return the cells that legs, or their `ends_of`, occupy, as `occupancy` does, and where and when they end."""
    begin, ends = start.start_tick if since is None else since, legs if isinstance(legs, np.ndarray) else ends_of(legs)
    rows, *end = roads.work.drive(start.cell, start.heading, start.start_tick, begin, ends, *roads.grid)
    if not rows.size:
        run_between(roads, end[0], int(ends[end[1], 0]))
    return Occupancy(*rows), Stop(*end)


def occupancy(roads: Roads, path: TimedPath, since: int | None = None) -> Occupancy:
    """Return the cells that a path occupies, each with its time; the last one without end.

    The first cell is occupied from ``since`` (left out: from the start of the path) to reaching the second one. Where
    a robot stops, the cell is its own from leaving the one before to reaching the one after, turn and wait included.

    Parameters
    ----------
    roads
        The layout.
    path
        The path.
    since
        When the robot came to the path's first cell.
    """
    return drive(roads, Stop(path.cell, path.heading, path.start_tick), path.legs, since)[0]


def run_between(roads: Roads, cell: int, to: int) -> tuple[int, int]:
    """Heading and number of cells of a straight run."""
    heading = roads.travel.heading(cell, to)
    if heading is None:
        raise ValueError(f"{roads.layout.where(cell)} to {roads.layout.where(to)} is no straight run")
    return heading, roads.layout.distance(cell, to)
