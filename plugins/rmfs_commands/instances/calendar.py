"""Dates and times of day in files, and in `instance.start`."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import UTC, datetime

from rmfs_core.clock import TICKS_PER_S, to_ticks
from rmfs_core.errors import InputError
from rmfs_core.timetable import DAY


class Calendar:
    """Reads the times of a file; time 0 is the start, or else midnight by the clock of the earliest time."""

    def __init__(self, start: str | None) -> None:
        self._start = start
        self._first: datetime | None = None
        self._earliest: dict[str, tuple[int, int]] = {}  # by column: tick, and ticks ahead of UTC

    def tick(self, text: str, place: str, column: str) -> int:
        """Return a time in ticks since 1970, in UTC if it has an offset; an `InputError` names the place."""
        try:
            moment = datetime.fromisoformat(text)
        except ValueError:
            expected = "expected a time in ISO 8601, such as 2024-03-01T06:30"
            raise InputError(place, f'{expected}, found "{text}"') from None
        self._first = self._first or moment
        if (moment.tzinfo is None) != (self._first.tzinfo is None):
            raise InputError(place, f'expected an offset from UTC in all times or in none, found "{text}"')
        now, offset = moment.replace(tzinfo=moment.tzinfo or UTC), moment.utcoffset()
        found = round(now.timestamp() * TICKS_PER_S), to_ticks(offset.total_seconds() if offset else 0)
        self._earliest[column] = min(found, self._earliest.get(column, found))
        return found[0]

    def zero(self, columns: Iterable[str] = ()) -> int:
        """Return time 0 in these ticks: the start, or midnight before the earliest in the first column with times."""
        if self._start is not None:
            return self.tick(self._start, "instance.start", "start")
        tick, ahead = next((self._earliest[column] for column in columns if column in self._earliest), (0, 0))
        return tick - (tick + ahead) % DAY

    def time_of_day(self) -> int:
        """Return the ticks from midnight to time 0, by the clock of the start; 0 without a start."""
        return 0 if self._start is None else (self.zero() + self._earliest["start"][1]) % DAY
