"""Rows that are left out of a table, by reason."""

from __future__ import annotations

from collections.abc import Iterator

from attrs import define, field

from rmfs_commands.convert.names import short
from rmfs_core.wording import counted

SHOWN = 3
"""Rows that are named as examples."""


@define
class Dropped:
    """Rows that were left out for one reason.

    Parameters
    ----------
    rows
        How many.
    examples
        Numbers of the first of them and what was found there.
    chosen
        Whether an option asked for it.
    """

    rows: int = 0
    examples: list[tuple[int, str]] = field(factory=list)
    chosen: bool = False

    def note(self, row: int, found: str) -> None:
        """Count a row."""
        self.rows += 1
        if len(self.examples) < SHOWN:
            self.examples.append((row, found))

    def shown(self) -> str:
        """Return the examples for a sentence: ``: row 5 "-1", row 9``, or nothing."""
        texts = [f"row {row}" + (f' "{short(text)}"' if text else "") for row, text in self.examples]
        return f": {', '.join(texts)}" if texts else ""


class Tally:
    """Rows left out, by reason."""

    def __init__(self) -> None:
        self.reasons: dict[str, Dropped] = {}

    def note(self, reason: str, row: int, found: str, chosen: bool = False) -> None:
        """Count a row; ``chosen`` says whether an option asked to leave it out."""
        self.reasons.setdefault(reason, Dropped(chosen=chosen)).note(row, found)

    def add(self, reason: str, rows: int, examples: list[tuple[int, str]], chosen: bool = False) -> None:
        """Count several rows, of which some are named."""
        self.reasons[reason] = Dropped(rows, examples, chosen)

    @property
    def unasked(self) -> int:
        """Rows that no option asked to leave out."""
        return sum(dropped.rows for dropped in self.reasons.values() if not dropped.chosen)

    def parts(self) -> Iterator[tuple[str, str]]:
        """Yield each reason, and a part of a sentence: how many, why, and examples."""
        for reason, dropped in self.reasons.items():
            yield reason, f"{counted(dropped.rows, 'row')} with {reason}{dropped.shown()}"


def why_none(others: Tally, left_out: list[str]) -> str:
    """Return why no row of a table is kept: rows that are not read, and the reasons for those left out."""
    return "; ".join([*(f"{part}, not read" for _, part in others.parts()), *left_out]) or "it has no rows"
