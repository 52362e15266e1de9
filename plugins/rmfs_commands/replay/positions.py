"""Where the robots of a recorded run are at any time: `rmfs_core.motion.Motion` over the legs of the trace."""

from __future__ import annotations

from itertools import accumulate

import numpy as np
from attrs import frozen

from rmfs_commands.replay.columns import Legs
from rmfs_commands.replay.reading import Replay
from rmfs_core.clock import to_seconds
from rmfs_core.motion import Motion
from rmfs_core.world.grid import STEPS


@frozen
class Place:
    """Where a robot is: column, row, and heading in quarters of a turn, with fractions.

    ``moving``: whether it drives or turns. ``leg``: which leg it is on, or has done last; -1 before its first.
    """

    column: float
    row: float
    heading: float
    moving: bool
    leg: int


class Way:
    """The legs of one robot, to be asked for any time.

    Parameters
    ----------
    legs
        As they were packed.
    width
        Columns of the layout.
    motion
        How robots move.
    """

    def __init__(self, legs: Legs, width: int, motion: Motion) -> None:
        self._legs, self._width, self._motion = legs, width, motion
        taken = np.array([legs.wait, legs.turn, legs.run], dtype=np.int64).sum(axis=0)
        gaps = np.array(legs.gap, dtype=np.int64)
        self._starts = np.cumsum(gaps + taken) - taken
        steps = [across + down * width for across, down in STEPS]
        ends = accumulate(
            (
                jump + steps[towards] * metres
                for jump, towards, metres in zip(legs.jump, legs.towards, legs.metres, strict=True)
            ),
            initial=legs.cell,
        )
        self._origins = [end + jump for end, jump in zip(ends, legs.jump, strict=False)]

    def at(self, tick: int) -> Place:
        """Return where the robot is."""
        legs = self._legs
        i = int(np.searchsorted(self._starts, tick, side="right")) - 1
        if i < 0:
            return Place(legs.cell % self._width, legs.cell // self._width, legs.heading, False, -1)
        row, column = divmod(self._origins[i], self._width)
        before, towards = legs.towards[i - 1] if i else legs.heading, legs.towards[i]
        since = tick - int(self._starts[i]) - legs.wait[i]
        if since < 0:
            return Place(column, row, before, False, i)
        if since < legs.turn[i]:
            quarters = (towards - before + 2) % 4 - 2
            return Place(column, row, before + quarters * since / legs.turn[i], True, i)
        since -= legs.turn[i]
        metres: float = legs.metres[i]
        moving = since < legs.run[i]
        if moving or legs.whole[i] != metres:
            metres = self._motion.position_m(legs.whole[i], to_seconds(min(since, legs.run[i])))
        across, down = STEPS[towards]
        return Place(column + across * metres, row + down * metres, towards, moving, i)


def ways(replay: Replay) -> list[Way]:
    """Return the way of each robot of a run."""
    start = replay.start
    return [Way(legs, start.layout.width, start.motion) for legs in replay.columns.legs]
