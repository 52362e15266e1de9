"""Times of a table, of one kind, with the clock that they are read from."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from datetime import timedelta
from functools import lru_cache
from zoneinfo import ZoneInfo

from rmfs_commands.convert.numeric_dates import NumericDates, looks_of
from rmfs_commands.convert.time_formats import (
    ABSOLUTE,
    EPOCH,
    ISO,
    LOCAL,
    OF_DAY,
    SECONDS,
    Moment,
    Read,
    date_reader,
    reader_of,
)
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.errors import InputError
from rmfs_core.timetable import DAY


class ClockError(ValueError):
    """Times of one table have an offset from UTC here and none there, or are dates here and seconds there."""


class Clock:
    """Reads the times of one table.

    Parameters
    ----------
    patterns
        Format of times: as `datetime.datetime.strptime` has it, or one of `NUMBERS`; the first that fits counts.
        None: ISO 8601, or a number of seconds.
    zone
        Time zone of times without an offset, by whose clock all times are shown; None: they stay as they are.

    Attributes
    ----------
    numbers
        Form of the numbers that were read without a pattern.
    """

    def __init__(self, patterns: Sequence[str] | None = None, zone: ZoneInfo | None = None) -> None:
        self.patterns = patterns
        self.numbers = NumericDates()
        self._zone = zone
        self._kind: str | None = None
        read = _first_of([reader_of(one, zone) for one in self.patterns or (None,)])
        self._read = lru_cache(4096)(read)  # lines of an order have the same time

    @property
    def dated(self) -> bool:
        """Whether the times seen so far are dates."""
        return self._kind in (LOCAL, ABSOLUTE)

    @property
    def of_day(self) -> bool:
        """Whether the times seen so far are times of the day."""
        return self._kind == OF_DAY

    def read(self, text: str, row: int = 1) -> Moment:
        """Return a time in a row of the table.

        Raises
        ------
        ClockError
            When it is of another kind than the ones before.
        UnusableError
            When it stands for no time, as 1900-01-01 and 9999-12-31 do, or no clock ever showed it.
        ValueError
            When it is no time.
        """
        kind, moment = self._read(text)
        if kind != self._kind:
            if self._kind is not None:
                looks = looks_of(text)[:1] if kind == SECONDS and "seconds" not in (self.patterns or ()) else ()
                perhaps = [
                    f'; numbers such as "{text}" may be {look.meaning}: --time-format {look.option} --time-format {ISO}'
                    for look in looks
                ]
                problem = f"found {kind} where the rows before have {self._kind}; expected one kind of time"
                raise ClockError("".join((problem, *perhaps)))
            self._kind = kind
        if kind == SECONDS and self.patterns is None:
            self.numbers.note(text, row)
        return moment

    def option(self, option: str, text: str) -> Moment:
        """Return a time that is given by an option: written as in the table, or in ISO 8601.

        One with an offset from UTC keeps it, whatever the zone: time 0 has that clock. ``20240301`` is a date where the
        table has dates.

        Raises
        ------
        InputError
            When it is no time, or of another kind than those of the table.
        """
        readable = False
        for read in (date_reader(None), self._read, reader_of(None, self._zone), date_reader(self._zone)):
            with suppress(ValueError, OverflowError):
                kind, moment = read(text)
                if self._kind in (None, kind):
                    return moment
                readable = True
        if readable:
            raise InputError(option, f'found "{text}", but the times of the table are {self._shown_kind()}')
        raise InputError(
            option, f'found "{text}"; expected a time such as 2024-03-01T06:00, or as --time-format has it'
        )

    def _shown_kind(self) -> str:
        examples = {SECONDS: "21600", OF_DAY: "06:00", LOCAL: "2024-03-01T06:00", ABSOLUTE: "2024-03-01T06:00+01:00"}
        kind, example = self._kind, examples[self._kind or LOCAL]
        if kind == ABSOLUTE and self._zone is not None:  # the offsets are the zone's, not the table's
            kind, example = "dates", examples[LOCAL]
        return f"{kind}; expected one of that kind, such as {example}"

    def midnight_before(self, moment: Moment) -> Moment:
        """Return the midnight at or before a time, by the clock that it was read from; 0 where times are no dates."""
        if not self.dated:
            return Moment(0)
        return Moment(moment.tick - (moment.tick + moment.ahead) % DAY, moment.ahead)

    def iso(self, moment: Moment) -> str:
        """Return a time as text: a date in ISO 8601, a time of the day, or seconds."""
        if self._kind == SECONDS or self._kind is None:
            return f"{moment.tick / TICKS_PER_S:.16g} s"
        shown = EPOCH + timedelta(milliseconds=moment.tick + moment.ahead)
        if self._kind == OF_DAY:
            return shown.time().isoformat()
        return shown.isoformat() + (offset(moment.ahead) if self._kind == ABSOLUTE else "")


def _first_of(readers: Sequence[Read]) -> Read:
    """Return what reads times with the first reader that can."""
    *first, last = readers

    def read(text: str) -> tuple[str, Moment]:
        for one in first:
            with suppress(ValueError, OverflowError):
                return one(text)
        return last(text)

    return read


def offset(ahead: int) -> str:
    """Return an offset from UTC as text: ``+02:00``."""
    minutes, seconds = divmod(abs(ahead) // TICKS_PER_S, 60)
    text = f"{'-' if ahead < 0 else '+'}{minutes // 60:02}:{minutes % 60:02}"
    return f"{text}:{seconds:02}" if seconds else text
