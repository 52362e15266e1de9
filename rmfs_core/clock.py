"""Simulated time: integer ticks of one millisecond.

Integers make sums exact and comparisons of times equal on every machine. At the paper's top speed of 1.5 m/s a
robot moves 1.5 mm in a tick, far below anything the model resolves (a cell is 1 m, the shortest move takes 2 s).
"""

from __future__ import annotations

from datetime import UTC, datetime

from rmfs_core.errors import InputError

TICKS_PER_S = 1000
_DAY = 86_400 * TICKS_PER_S


def to_ticks(seconds: float) -> int:
    """Round ``seconds`` to the nearest tick."""
    return round(seconds * TICKS_PER_S)


def to_seconds(ticks: int) -> float:
    """Seconds of ``ticks``."""
    return ticks / TICKS_PER_S


class Calendar:
    """Reads the times of a file; their offset from UTC is that of the first one, if it has one."""

    def __init__(self, start: str | None) -> None:
        self._start = start
        self._first: datetime | None = None

    def tick(self, text: str, place: str) -> int:
        """Return a time in ticks since 1970, as its own clock shows it; the place is where a wrong one stands."""
        try:
            moment = datetime.fromisoformat(text)
        except ValueError:
            expected = "expected a time in ISO 8601, such as 2024-03-01T06:30"
            raise InputError(place, f'{expected}, found "{text}"') from None
        self._first = self._first or moment
        if (moment.tzinfo is None) != (self._first.tzinfo is None):
            raise InputError(place, f'expected an offset from UTC in all times or in none, found "{text}"')
        if moment.tzinfo is not None:
            moment = moment.astimezone(self._first.tzinfo)
        return round(moment.replace(tzinfo=UTC).timestamp() * TICKS_PER_S)

    def zero(self, earliest: int) -> int:
        """Return time 0 in ticks since 1970: the start, or else midnight before the earliest time."""
        return earliest - earliest % _DAY if self._start is None else self.tick(self._start, "instance.start")
