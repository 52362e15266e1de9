"""Exact driving times and shortest paths on the grid, other robots ignored (stub while the kernel takes shape).

Robots drive straight runs between stops and turn only at a standstill, so the state of the search is (cell, heading).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rmfs_core.decisions import Leg
from rmfs_core.layout import Layout
from rmfs_core.motion import Motion

UNREACHABLE = np.iinfo(np.int64).max // 4


class Travel:
    """Travel times of one layout and one kind of robot; tables are computed on demand and kept."""

    def __init__(self, layout: Layout, motion: Motion) -> None:
        self.layout = layout
        self.motion = motion

    def times_to(self, goal: int, loaded: bool) -> NDArray[np.int64]:
        """Ticks from standing in each cell with each heading to rest at ``goal``. Shape (cells, 4), read-only.

        `UNREACHABLE` where there is no way. A loaded robot crosses no storage cell but its start and ``goal``.
        """
        raise NotImplementedError

    def times_from(self, cell: int, heading: int, loaded: bool) -> NDArray[np.int64]:
        """Ticks from standing in ``cell`` with ``heading`` to rest in each cell, whatever the heading there. Shape (cells,)."""
        raise NotImplementedError

    def ticks(self, cell: int, heading: int, goal: int, loaded: bool) -> int:
        """Ticks from standing in ``cell`` with ``heading`` to rest at ``goal``."""
        return int(self.times_to(goal, loaded)[cell, heading])

    def fastest_path(self, cell: int, heading: int, goal: int, loaded: bool) -> tuple[Leg, ...]:
        """Legs of a fastest path to ``goal``."""
        raise NotImplementedError
