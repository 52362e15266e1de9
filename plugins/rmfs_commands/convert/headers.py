"""Columns of a table, found by their names in its header."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Sequence

from rmfs_commands.convert.names import short
from rmfs_core.errors import InputError
from rmfs_core.wording import did_you_mean, first_few, listed

_MANY = 30
"""Columns of a header that a sentence still lists."""


def plain(name: str) -> str:
    """Return a name without spaces around it, in the one spelling of Unicode that all comparisons use (NFC)."""
    return unicodedata.normalize("NFC", name.strip())


def told(names: Sequence[str]) -> str:
    """Return names of columns for a sentence, of many only the first few."""
    shown = [short(name) for name in names]
    return first_few(shown) if len(shown) > _MANY else listed(shown)


def positions(
    header: Sequence[str], columns: Sequence[str | None], place: str, hint: Callable[[], str] = lambda: ""
) -> list[int]:
    """Return where columns are in a header; for None, the index after its last.

    Parameters
    ----------
    header
        The names in the table.
    columns
        The names that are wanted; a name may come twice.
    place
        Where the header is, for errors.
    hint
        Returns what may be the reason if one is missing: a part of the sentence.

    Raises
    ------
    InputError
        When a column is missing, or the header has it twice.
    """
    names = [plain(name) for name in header]
    for column in filter(None, columns):
        found = names.count(plain(column))
        if found > 1:
            raise InputError(place, f'found the column "{column}" {found} times; expected each once')
        if not found:
            there = [name for name in names if name]
            meant = hint() or did_you_mean(plain(column), there)
            raise InputError(place, f'there is no column "{column}"{meant}; found {told(there)}')
    return [len(names) if column is None else names.index(plain(column)) for column in columns]
