"""A layout for path planning, as arrays that compiled searches read."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.world.travel import Table, Travel
from rmfs_traffic.passing import PassingTimes

Ints = NDArray[np.int64]


class Tracks(NamedTuple):
    """Arrays of one goal and load for a compiled search.

    Parameters
    ----------
    moves
        Bits of the headings in which each cell may be left (`Layout.moves`).
    passable
        Cells that may be crossed.
    offsets
        Step in cell index per heading.
    runs, turns, enter, leave, common
        See `Travel` and `PassingTimes`.
    times
        Ticks of the fastest way to the goal from each (cell, heading), other robots ignored: int32, or int64 if that is
        too short for all ways. `rmfs_core.clock.far` says how many stand for no way.
    """

    moves: NDArray[np.int8]
    passable: NDArray[np.bool_]
    offsets: Ints
    runs: Ints
    turns: Ints
    enter: Ints
    leave: Ints
    common: Ints
    times: Table


def roads_on(travel: Travel) -> Roads:
    """Return the roads of a run's travel times, the same object whenever it is asked for."""
    return travel.once(Roads)


class Roads:
    """A layout as path planning sees it.

    Parameters
    ----------
    travel
        Exact travel times on the layout; also names the layout and the robots' kinematics.
    """

    def __init__(self, travel: Travel) -> None:
        self.travel = travel
        self.layout = travel.layout
        self.cells = len(travel.layout.kind)
        self.passing = PassingTimes(travel.motion, len(travel.runs) - 1)
        self.offsets = travel.offsets
        self.turns = tuple(map(int, travel.turns))
        passing = self.passing
        self._anywhere = self.offsets, travel.runs, travel.turns, passing.enter, passing.leave, passing.common
        kinematics, passes = np.concatenate([travel.turns, travel.runs]), [self.passing.enter, self.passing.leave]
        self.grid = travel.layout.width, kinematics, np.array(passes)
        """Width, ticks of turns by the difference of headings, then of runs by length, and when runs pass cells."""

    @cached_property
    def work(self) -> Any:
        """The compiled work: imported when needed, for it takes its time."""
        from rmfs_traffic import intervals

        return intervals

    def tracks(self, goal: int, loaded: bool, times: Table | None = None) -> Tracks:
        """Return the arrays of a goal for a compiled search, with the times of `Travel.ways_to` if not with others."""
        if times is None:
            times = self.travel.ways_to(goal, loaded)
        return Tracks(self.layout.moves, self.travel.passable(goal, loaded), *self._anywhere, times)
