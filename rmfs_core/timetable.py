"""Timetables, numbers that depend on the time of day, the same every day; and what day and time it is."""

from __future__ import annotations

import re
from collections.abc import Iterable
from datetime import UTC, datetime

from attrs import frozen

from rmfs_core.clock import TICKS_PER_S, to_ticks
from rmfs_core.errors import InputError
from rmfs_core.wording import shown_short

DAY = 86_400 * TICKS_PER_S
Span = tuple[str | int, ...]
"""From when until when (``"HH:MM"``), and perhaps how many."""


def read_spans(spans: Iterable[Span], most: int | None = None) -> tuple[tuple[int, int, int], ...]:
    """Return begin and end of spans in ticks of the day, and their number; raise ValueError for the first wrong one.

    ``most`` is the largest number that counts, and that of a span without; None: spans have none, and count as 1.
    """
    read = []
    for span in spans:
        begin, end = map(_tick, span[:2]) if 2 <= len(span) <= (2 if most is None else 3) else (None, None)
        number = span[2] if len(span) == 3 else 1 if most is None else most
        counts = isinstance(number, int) and number >= 0
        if begin is None or end is None or begin == end or not counts:
            times = 'two times of the day that differ, such as ["06:00", "22:00"]'
            more = "" if most is None else ", and perhaps a whole number >= 0"
            raise ValueError(f"expected spans of {times}{more}; found {shown_short(list(span))}")
        read.append((begin, end, min(int(number), most or 1)))
    return tuple(read)


def _tick(time: str | int) -> int | None:
    if not isinstance(time, str) or not re.fullmatch(r"([01]\d|2[0-3]):[0-5]\d|24:00", time, re.ASCII):
        return None
    return (int(time[:2]) * 3600 + int(time[3:]) * 60) * TICKS_PER_S


@frozen
class Timetable:
    """The largest number of the spans of the day that hold, which may go past midnight; 0 outside of all.

    ``spans`` is as `read_spans` has it, ``zero`` the tick of the day at which a run starts.
    """

    spans: tuple[tuple[int, int, int], ...]
    zero: int = 0

    def at(self, tick: int) -> int:
        """Return the number at a tick of the run."""
        now = (tick + self.zero) % DAY
        return max((n for begin, end, n in self.spans if (now - begin) % DAY < ((end - begin) % DAY or DAY)), default=0)

    def next_change(self, tick: int) -> int | None:
        """Return the first tick of the run, later than another, at which the number changes; None: it never does."""
        times = (time - tick - self.zero for span in self.spans for time in span[:2])
        later = sorted(tick + (time % DAY or DAY) for time in times)
        return next((time for time in later if self.at(time) != self.at(tick)), None)


ALWAYS = Timetable(((0, 0, 1),))


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
