"""Simulated time: integer ticks of one millisecond.

Integers make sums exact and comparisons of times equal on every machine. At the paper's top speed of 1.5 m/s a
robot moves 1.5 mm in a tick, far below anything the model resolves (a cell is 1 m, the shortest move takes 2 s).
"""

from __future__ import annotations

from typing import Any

TICKS_PER_S = 1000
UNREACHABLE = 1 << 40
"""Instead of the ticks of a way where there is none."""


def far(table: Any) -> int:
    """Return what is in a table of ticks instead of `UNREACHABLE`: of four bytes, that is too large a number."""
    return UNREACHABLE if table.itemsize == 8 else 1 << 30


def to_ticks(seconds: float) -> int:
    """Round ``seconds`` to the nearest tick."""
    return round(seconds * TICKS_PER_S)


def to_seconds(ticks: int) -> float:
    """Seconds of ``ticks``."""
    return ticks / TICKS_PER_S
