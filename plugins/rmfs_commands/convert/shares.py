"""How many rows of a table may be left out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from rmfs_commands.cli.screen import tell
from rmfs_commands.convert.tally import Tally
from rmfs_core.errors import InputError

if TYPE_CHECKING:
    from rmfs_commands.convert.cleaning import Cleaner

MOST_LEFT_OUT = 0.5
"""Share of the rows that may be left out."""

MANY_LEFT_OUT = 0.1
"""Share of the rows left out from which on there is a warning."""


class Cleaned(Protocol):
    """The rows of a table: how many were read, and which were left out."""

    rows: int
    dropped: Tally

    def left_out(self) -> list[str]:
        """Return the reasons for rows left out, as parts of sentences."""


def check_share(file: Path, cleaned: Cleaned, force: bool) -> None:
    """Refuse a table most of whose rows would be left out, though no option asks for that."""
    left = cleaned.dropped.unasked
    if left > MOST_LEFT_OUT * cleaned.rows and not force:
        found = f"{left:,} of {cleaned.rows:,} rows would be left out: {'; '.join(cleaned.left_out())}"
        raise InputError(str(file), f"{found}; expected at most half, or --force")


def check_emptied(file: Path, cleaner: Cleaner, force: bool) -> None:
    """Refuse a table in most of whose rows a time or a priority would be left empty, since it cannot be read."""
    for reason, part in cleaner.left_empty().items():
        if cleaner.emptied.reasons[reason].rows > MOST_LEFT_OUT * cleaner.rows and not force:
            raise InputError(str(file), f"would be left empty: {part}; expected at most half of the rows, or --force")


def warn_of_share(file: Path | str, cleaned: Cleaned) -> None:
    """Warn of many rows left out, though no option asks for that."""
    left = cleaned.dropped.unasked
    if left > MANY_LEFT_OUT * cleaned.rows:
        share = f"{100 * left / cleaned.rows:.0f} %"
        tell(f"Warning: {share} of the rows of {file} are left out ({left:,} of {cleaned.rows:,}).", err=True)
