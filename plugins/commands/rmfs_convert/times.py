"""Times of order lines: ISO 8601, seconds, or a format that the user names."""

from __future__ import annotations

import re
from datetime import UTC, datetime, timedelta

from rmfs_core.clock import TICKS_PER_S

_NUMBER = re.compile(r"[0-9]{1,12}(\.[0-9]+)?")
_EPOCH = datetime(1970, 1, 1)


class ClockError(ValueError):
    """Times of one table have a zone here and none there, or are dates here and seconds there."""


class Clock:
    """Reads the times of one table.

    Parameters
    ----------
    pattern
        How a time is written, as `datetime.datetime.strptime` has it; None: ISO 8601, or a number of seconds.
    """

    def __init__(self, pattern: str | None = None) -> None:
        self.pattern = pattern
        self._kind: str | None = None

    @property
    def dated(self) -> bool:
        """Whether the times seen so far are dates, not mere numbers of seconds."""
        return self._kind not in (None, "seconds")

    def tick(self, text: str) -> int:
        """Return a time in ticks (1 ms) since 1970, or since 0 where times are numbers of seconds.

        Raises
        ------
        ClockError
            When it is of another kind than the ones before.
        ValueError
            When it is no time.
        """
        if self.pattern is None and _NUMBER.fullmatch(text):
            self._is("seconds")
            return round(float(text) * TICKS_PER_S)
        moment = datetime.strptime(text, self.pattern) if self.pattern else datetime.fromisoformat(text)
        if moment.tzinfo is not None:
            self._is("dates with a zone")
            moment = moment.astimezone(UTC).replace(tzinfo=None)
        else:
            self._is("dates without a zone")
        return (moment - _EPOCH) // timedelta(milliseconds=1)

    def midnight_before(self, tick: int) -> int:
        """Return the midnight at or before a time; 0 where times are numbers of seconds."""
        day = 86_400 * TICKS_PER_S
        return tick // day * day if self.dated else 0

    def iso(self, tick: int) -> str:
        """Return a time as text."""
        if not self.dated:
            return f"{tick / TICKS_PER_S:g} s"
        return (_EPOCH + timedelta(milliseconds=tick)).isoformat(sep=" ")

    def _is(self, kind: str) -> None:
        if self._kind not in (None, kind):
            raise ClockError(f"found {kind} where the rows before have {self._kind}; expected one kind of time")
        self._kind = kind
