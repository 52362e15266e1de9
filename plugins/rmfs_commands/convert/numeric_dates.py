"""Numbers that may be seconds from the start, and may be dates: 20240229, 240229, 45351.25, 1709251200."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from attrs import frozen

from rmfs_core.wording import listed

_SHARE = 0.9
"""Share of the numbers that has to look like dates for a question: the others may stand for no date."""


@frozen
class Look:
    """A way to write a date as a number, by the digits before the point.

    Parameters
    ----------
    option
        Its name in `--time-format`.
    meaning
        Its meaning, for a sentence.
    digits
        How many digits it has.
    fits
        Whether so many digits can be one.
    """

    option: str
    meaning: str
    digits: int
    fits: Callable[[str], bool]


def _day(digits: str) -> bool:
    return 1 <= int(digits[:2]) <= 12 and 1 <= int(digits[2:4]) <= 31


def _clock(digits: str) -> bool:
    return int(digits[:2]) < 24 and all(int(digits[i : i + 2]) < 60 for i in range(2, len(digits), 2))


def _date(digits: str) -> bool:
    if digits[:4] in ("0000", "9999"):  # 99991231 and 00000000 stand for no date
        return True
    return digits[:2] in ("19", "20") and _day(digits[4:])


LOOKS = (
    Look("spreadsheet", "serial days of a spreadsheet", 5, lambda text: 36_526 <= int(text) < 54_789),
    Look("%y%m%d", "dates as YYMMDD", 6, lambda text: _day(text[2:])),
    Look("%H%M%S", "times of the day as HHMMSS", 6, _clock),
    Look("%Y%m%d", "dates as YYYYMMDD", 8, _date),
    Look("unix", "Unix seconds", 10, lambda text: 946_684_800 <= int(text) < 2_524_608_000),
    Look("%Y%m%d%H%M", "dates as YYYYMMDDHHMM", 12, lambda text: _date(text) and _clock(text[8:])),
    Look("%y%m%d%H%M%S", "dates as YYMMDDHHMMSS", 12, lambda text: _day(text[2:]) and _clock(text[6:])),
    Look("unix-ms", "Unix milliseconds", 13, lambda text: 946_684_800_000 <= int(text) < 2_524_608_000_000),
    Look("%Y%m%d%H%M%S", "dates as YYYYMMDDHHMMSS", 14, lambda text: _date(text) and _clock(text[8:])),
)
"""Ranges of numbers are the years 2000 to 2049."""


def looks_of(text: str) -> list[Look]:
    """Return what a number may be besides seconds."""
    digits = text.partition(".")[0]
    return [look for look in LOOKS if look.digits == len(digits) and look.fits(digits)]


class NumericDates:
    """Counts the numbers of a column that look like dates."""

    def __init__(self) -> None:
        self._numbers = 0
        self._found: Counter[Look] = Counter()
        self._example: dict[Look, tuple[int, str]] = {}
        self._padded = False  # whether a number begins with 0, as numbers of seconds do not

    def note(self, text: str, row: int) -> None:
        """Count a number of a row."""
        self._numbers += 1
        self._padded = self._padded or (text[0] == "0" and text[1:2].isdigit())
        for look in looks_of(text):
            self._found[look] += 1
            self._example.setdefault(look, (row, text))

    def question(self) -> str | None:
        """Return a sentence that asks what the numbers are, if most of them may be dates."""
        frequent = [look for look, number in self._found.items() if number >= _SHARE * self._numbers]
        looks = [look for look in frequent if self._padded or look.option != "%H%M%S"]
        if not looks:
            return None
        ways = listed([f"{look.meaning} (--time-format {look.option})" for look in looks], "or")
        row, text = self._example[looks[0]]
        return f'found numbers such as "{text}" in row {row}, which may be {ways}, or seconds (--time-format seconds)'
