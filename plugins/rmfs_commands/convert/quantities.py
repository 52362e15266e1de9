"""Quantities as programs of all countries write them: 1000, 1.000, 1,000.00, 1'000, 1 000,0."""

from __future__ import annotations

import re
from collections.abc import Iterable

from rmfs_core.errors import InputError

_SPACES = " \u00a0\u2009\u202f'\u2019"
"""Signs between thousands that are never decimal signs."""

_MOST_DIGITS = 15


class Quantities:
    """Reads the numbers of one column.

    Where neither sign is given, a number is read as it can be read; one that can be read in two ways is kept as the
    reason of a question.

    Parameters
    ----------
    decimal
        The sign before fractions, ``.`` or ``,``; None: not known.
    thousands
        The sign between thousands; None: not known, any but the decimal sign.
    """

    def __init__(self, decimal: str | None = None, thousands: str | None = None) -> None:
        if thousands in (".", ",") and decimal is None:
            decimal = "," if thousands == "." else "."
        self._decimal = decimal
        signs = [sign for sign in (".", ",") if decimal in (None, sign) and thousands != sign]
        self._patterns = [_pattern(sign, thousands) for sign in signs]
        self._doubt: tuple[int, str, list[str]] | None = None
        self._evidence: tuple[int, str] | None = None

    def whole(self, text: str, row: int) -> int | None:
        """Return a whole number from 0 on; None for any other text, and while it can be read in two ways."""
        if text.isascii() and text.isdigit():
            return int(text) if len(text) <= _MOST_DIGITS else None
        read = [value for pattern in self._patterns if (value := _value(text, pattern)) is not None]
        if len(set(read)) > 1:
            self._doubt = self._doubt or (row, text, [f"{value:.15g}" for value in read])
            return None
        if len(read) == 1 and not self._evidence:
            self._evidence = row, text
        return int(read[0]) if read and read[0].is_integer() else None

    def guessed(self, texts: Iterable[str]) -> str:
        """Return the end of a sentence on texts that were not read: the other decimal sign, if it reads one of them."""
        if self._decimal is None:
            return ""
        other = "," if self._decimal == "." else "."
        reader = Quantities(other)
        return f"; perhaps --decimal {other}" if any(reader.whole(text, 0) for text in texts) else ""

    def ask(self, file: str, column: str) -> None:
        """Raise an `InputError` that asks which sign is which, if a number so far could be read in two ways."""
        if self._doubt is None:
            return
        row, text, ways = self._doubt
        other = f' (row {self._evidence[0]} has "{self._evidence[1]}")' if self._evidence else ""
        raise InputError(
            f"{file}, row {row}, {column}",
            f'found "{text}", which may be {ways[0]} or {ways[1]}{other}; '
            f"expected --decimal . if the point is before fractions, or --decimal , if the comma is",
        )


def _pattern(decimal: str, thousands: str | None) -> re.Pattern[str]:
    """Return what matches numbers: the whole part is the first group, the fraction the last."""
    signs = f"{_SPACES}{'.' if decimal == ',' else ','}" if thousands is None else thousands
    signs = _SPACES if signs in _SPACES else signs
    return re.compile(
        rf"([1-9][0-9]{{0,2}}([{re.escape(signs)}])[0-9]{{3}}(?:\2[0-9]{{3}})*|[0-9]+)(?:\{decimal}([0-9]*))?"
    )


def _value(text: str, pattern: re.Pattern[str]) -> float | None:
    match = pattern.fullmatch(text)
    if match is None:
        return None
    digits = re.sub("[^0-9]", "", match[1])
    return float(f"{digits}.{match[3] or 0}") if len(digits) <= _MOST_DIGITS else None
