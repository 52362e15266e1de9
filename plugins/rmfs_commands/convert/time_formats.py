"""How times are written: ISO 8601, patterns of days and hours, numbers of seconds or days."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

from attrs import field, frozen

from rmfs_commands.convert.numeric_dates import LOOKS
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.errors import InputError
from rmfs_core.timetable import DAY
from rmfs_core.wording import listed, shown_short

SECONDS, OF_DAY, LOCAL, ABSOLUTE = "seconds", "times of the day", "dates without an offset", "dates with an offset"
"""Kinds of times: from time 0, from midnight, by a clock that is not known, in all the world."""

NUMBERS = ("seconds", "unix", "unix-ms", "spreadsheet")
ISO = "iso"
"""Values of `--time-format` besides a pattern; `ISO` is ISO 8601 or seconds, as without the option."""

_NUMBER = re.compile(r"[0-9]{1,20}(\.[0-9]*)?")
_SAID_NUMBER = re.compile(r"[0-9]{1,20}([.,][0-9]*)?")  # where the user says that it is a number
_ZEROS = re.compile(r"\.0*")
EPOCH, _SPREADSHEET = datetime(1970, 1, 1), datetime(1899, 12, 30)
_DATE, _YEAR, _CLOCK = frozenset("aAbBdjmUwWuV"), frozenset("yYGcx"), frozenset("HIMSfpXzc")
_WIDTHS = {"Y": 4, "y": 2, "m": 2, "d": 2, "H": 2, "M": 2, "S": 2}
_FIRST_YEAR, _LAST_YEAR = 1971, 2099
_COMMON = (
    *(f"{day}{time}" for day in ("%d.%m.%Y", "%d/%m/%Y", "%m/%d/%Y", "%Y/%m/%d", "%d-%m-%Y", "%d.%m.%y", "%m/%d/%y")
      for time in ("", " %H:%M", " %H:%M:%S", " %I:%M %p", " %I:%M:%S %p")),
    *("%Y-%m-%d %H:%M:%S", "%Y-%m-%d %I:%M %p", "%d %b %Y", "%d-%b-%Y", "%d-%b-%y", "%b %d, %Y", "%H:%M", "%H:%M:%S"),
)  # fmt: skip


class UnusableError(ValueError):
    """A time can be read, but is none; the text says why."""


@frozen(order=True)
class Moment:
    """A time.

    Parameters
    ----------
    tick
        Ticks (1 ms): since 1970 in UTC or by a clock that is not known, since midnight, or since 0.
    ahead
        Ticks that the clock it was read from is ahead of UTC; 0 where that is not known.
    whole_day
        Whether it was written as a date without a time of the day, which counts as 00:00.
    """

    tick: int
    ahead: int = 0
    whole_day: bool = field(default=False, eq=False)


def guessed(texts: list[str], others: Sequence[str] | None = ()) -> str:
    """Return which options read times that were not read, as the end of a sentence; nothing where none does.

    Parameters
    ----------
    texts
        The times.
    others
        Formats that other columns need, besides; None: ISO 8601. Empty where there are no other columns.
    """
    patterns = [*_COMMON, *(look.option for look in LOOKS)]
    found = [pattern for pattern in patterns if texts and all(_reads(pattern, text) for text in texts)]
    options = [f'--time-format "{pattern}"' if " " in pattern else f"--time-format {pattern}" for pattern in found]
    if texts and all(_reads(None, text) for text in texts):
        options.insert(0, "without --time-format" if others == () else f"--time-format {ISO}")
    also = "" if others == () else "also " if others else f"--time-format {ISO} and also "
    return f"; perhaps {also}{listed(options[:3], 'or')}" if options else ""


def checked_pattern(text: str) -> str:
    """Return a `--time-format` that can be used; InputError with what is wrong with it else."""
    if text in (*NUMBERS, ISO):
        return text
    place, directives = "--time-format", set(re.findall(r"%(.)", text.replace("%%", "")))
    if "Z" in directives:
        problem = "found %Z: names of zones are not the same everywhere; expected %z (+0200), or --zone Europe/Berlin"
        raise InputError(place, problem)
    if not directives or not _is_pattern(text):
        examples = f"such as %d.%m.%Y %H:%M, or one of {', '.join((*NUMBERS, ISO))}"
        raise InputError(place, f"found {shown_short(text)}; expected a format {examples}")
    if directives & (_DATE | {"z"}) and not directives & _YEAR:
        raise InputError(
            place, f"found {shown_short(text)}, which has no year; expected %Y, or times of the day (%H:%M)"
        )
    return text


def _is_pattern(text: str) -> bool:
    try:
        datetime.strptime("", text)
    except ValueError as error:
        return "does not match" in str(error)
    except (IndexError, KeyError, re.error):  # of a directive that comes twice
        return False
    return True


def _reads(pattern: str | None, text: str) -> bool:
    try:
        kind, _ = reader_of(pattern, None)(text)
    except (ValueError, OverflowError):
        return False
    return kind != SECONDS


Read = Callable[[str], tuple[str, Moment]]
"""Returns the kind of a time, and the time."""


def reader_of(pattern: str | None, zone: ZoneInfo | None) -> Read:
    """Return what reads times of a pattern; a text that is none is a ValueError, one far off an OverflowError.

    Parameters
    ----------
    pattern
        As `datetime.datetime.strptime` has it, or one of `NUMBERS`; `ISO` or None: ISO 8601, or a number of seconds.
    zone
        Time zone of times without an offset, by whose clock all times are shown; None: they stay as they are.
    """
    if pattern in NUMBERS:
        return _numberreader_of(pattern, zone)
    if pattern in (None, ISO):
        seconds = _numberreader_of("seconds", zone)
        dates = date_reader(zone)
        return lambda text: seconds(text) if _NUMBER.fullmatch(text) else dates(text)
    directives = set(re.findall(r"%(.)", pattern))
    of_day, whole_day = not directives & (_DATE | _YEAR), not directives & _CLOCK
    width = _width(pattern)

    def read(text: str) -> tuple[str, Moment]:
        if width is not None and len(text := _whole(text)) != width:
            raise ValueError
        moment = datetime.strptime(text, pattern)
        return (OF_DAY, Moment(_tick(moment) % DAY)) if of_day else _dated(moment, zone, whole_day)

    return read


def date_reader(zone: ZoneInfo | None) -> Read:
    """Return what reads dates in ISO 8601, ``20240301`` among them; a text that is none is a ValueError.

    Parameters
    ----------
    zone
        Time zone of times without an offset, by whose clock all times are shown; None: they stay as they are.
    """
    return lambda text: _dated(datetime.fromisoformat(text), zone, len(text) <= len("2024-03-01"))


def _width(pattern: str) -> int | None:
    """Return how long a text has to be: numbers without a sign between them would be read with fewer digits, too."""
    if not re.search(r"%.%", pattern):
        return None
    directives = re.findall(r"%(.)", pattern)
    if not all(directive in _WIDTHS for directive in directives):
        return None
    return len(re.sub("%.", "", pattern)) + sum(_WIDTHS[directive] for directive in directives)


def _whole(text: str) -> str:
    whole, point, zeros = text.partition(".")
    return whole if _ZEROS.fullmatch(point + zeros) else text


def _numberreader_of(kind: str, zone: ZoneInfo | None) -> Read:
    def read(text: str) -> tuple[str, Moment]:
        if not _SAID_NUMBER.fullmatch(text):
            raise ValueError
        number = float(text.replace(",", "."))
        if kind == "seconds":
            return SECONDS, Moment(round(number * TICKS_PER_S))
        if kind == "spreadsheet":
            return _dated(_SPREADSHEET + timedelta(milliseconds=round(number * DAY)), zone, number.is_integer())
        milliseconds = round(number * TICKS_PER_S) if kind == "unix" else round(number)
        return _dated((EPOCH + timedelta(milliseconds=milliseconds)).replace(tzinfo=UTC), zone)

    return read


def _dated(moment: datetime, zone: ZoneInfo | None, whole_day: bool = False) -> tuple[str, Moment]:
    """Return kind and time of a date, by the clock of the zone if there is one."""
    if not _FIRST_YEAR <= moment.year <= _LAST_YEAR:
        raise UnusableError(f"a time that stands for none (before {_FIRST_YEAR} or after {_LAST_YEAR})")
    if zone is not None:
        local = moment.astimezone(zone) if moment.tzinfo else moment.replace(tzinfo=zone)
        there = local.astimezone(UTC).astimezone(zone)
        if there.replace(tzinfo=None) != local.replace(tzinfo=None):  # the hour that is skipped in spring
            raise UnusableError("a time that the clock skips (--zone)")
        moment = local
    ahead = moment.utcoffset()
    if ahead is None:
        return LOCAL, Moment(_tick(moment), 0, whole_day)
    ticks = ahead // timedelta(milliseconds=1)
    return ABSOLUTE, Moment(_tick(moment.replace(tzinfo=None)) - ticks, ticks, whole_day)


def _tick(moment: datetime) -> int:
    return (moment - EPOCH) // timedelta(milliseconds=1)
