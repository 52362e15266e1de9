"""When a robot passes the cells of a straight run: the closed formulas of motion, rounded outward to ticks.

A robot drives a run of ``k`` cells from rest to rest. It occupies cell ``i`` of it from leaving cell ``i - 1`` (being
on its centre for the last time) to reaching cell ``i + 1`` (being on its centre). Both moments are irrational in
general. They are rounded outward, the first down and the second up to a tick, so that two robots whose intervals of
ticks do not overlap never occupy a cell together: rounding costs at most 2 ms of a cell's time, and never hides an
overlap. What differs from a whole tick by less than a nanosecond counts as whole, so that the last bit of a square root
decides nothing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.motion import Motion

NANOSECOND = 1e-6  # in ticks


class PassingTimes:
    """Passing times of all straight runs of up to ``longest`` cells.

    Parameters
    ----------
    motion
        Kinematics of the robots.
    longest
        Cells of the longest run.

    Attributes
    ----------
    enter, leave
        ``enter[k, i]`` to ``leave[k, i]``: ticks after its departure between which a run of ``k`` cells occupies its
        cell ``i``. Cell 0 is occupied before and cell ``k`` after, too. Shape (longest + 1, longest + 1).
    common
        ``common[k]``: how many cells, from cell 0 on, a run of ``k`` cells passes at the same times as the longest
        run does: all but those near its end, where it brakes. Shape (longest + 1,).
    """

    def __init__(self, motion: Motion, longest: int) -> None:
        self.enter = np.zeros((longest + 1, longest + 1), dtype=np.int64)
        self.leave = np.zeros((longest + 1, longest + 1), dtype=np.int64)
        for cells in range(1, longest + 1):
            ticks = passing_s(motion, cells) * TICKS_PER_S
            self.enter[cells, 1 : cells + 1] = np.floor(ticks[:-1] + NANOSECOND)
            self.leave[cells, :cells] = np.ceil(ticks[1:] - NANOSECOND)
            # The run itself is rounded to the nearest tick: never let go of a cell before its end.
            self.leave[cells, cells - 1] = max(self.leave[cells, cells - 1], motion.run_ticks(cells))
            self.leave[cells, cells] = self.leave[cells, cells - 1]
        self.common = np.array([self._common(cells) for cells in range(longest + 1)], dtype=np.int64)
        for array in (self.enter, self.leave, self.common):
            array.setflags(write=False)

    def _common(self, cells: int) -> int:
        alike = self.enter[cells, :cells] == self.enter[-1, :cells]
        alike &= self.leave[cells, :cells] == self.leave[-1, :cells]
        return cells if alike.all() else int(np.argmin(alike))


def passing_s(motion: Motion, cells: int) -> NDArray[np.float64]:
    """Seconds from the start of a run of ``cells`` cells to passing the centre of each. Shape (cells + 1,).

    With acceleration ``a``, top speed ``v``, ramp ``r = min(v^2 / 2a, D / 2)`` and run time ``T``: sqrt(2d / a) up to
    ``d = r``, T - sqrt(2(D - d) / a) from ``d = D - r`` on, and at top speed in between.
    """
    a, v = motion.acceleration_m_per_s2, motion.top_speed_m_per_s
    metres = np.arange(cells + 1, dtype=np.float64)
    ramp_m = min(v * v / (2 * a), cells / 2)
    speeding_up = np.sqrt(2 * metres / a)
    slowing_down = motion.run_s(cells) - np.sqrt(2 * (cells - metres) / a)
    cruising = v / a + (metres - ramp_m) / v
    passing: NDArray[np.float64] = np.where(
        metres <= ramp_m, speeding_up, np.where(metres >= cells - ramp_m, slowing_down, cruising)
    )
    return passing
