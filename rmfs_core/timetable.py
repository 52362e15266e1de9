"""Timetables: numbers that depend on the time of day, the same every day."""

from __future__ import annotations

import re
from collections.abc import Iterable

from attrs import frozen

from rmfs_core.clock import TICKS_PER_S
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
