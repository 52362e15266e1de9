"""How many rows may be left out."""

from __future__ import annotations

from pathlib import Path

import pytest
from attrs import define

from rmfs_commands.convert.shares import check_emptied, check_share, warn_of_share
from rmfs_commands.convert.tally import Tally
from rmfs_core.errors import InputError


@define
class Rows:
    """So many rows were read, and some left out."""

    rows: int
    dropped: Tally

    def left_out(self) -> list[str]:
        """Return the reasons."""
        return [part for _, part in self.dropped.parts()]


def rows(number: int, left: int, chosen: int = 0) -> Rows:
    """Return rows some of which were left out without being asked for, some since an option says so."""
    tally = Tally()
    for row in range(left + chosen):
        tally.note("no SKU" if row < left else "a SKU to leave out", row, "", chosen=row >= left)
    return Rows(number, tally)


def test_more_than_half_is_refused() -> None:
    """Unless it is wanted; what an option leaves out does not count."""
    with pytest.raises(
        InputError, match=r"^a.csv: 6 of 10 rows would be left out: 6 rows with no SKU: row 0.*--force$"
    ):
        check_share(Path("a.csv"), rows(10, 6), force=False)
    check_share(Path("a.csv"), rows(10, 6), force=True)
    check_share(Path("a.csv"), rows(10, 5, chosen=5), force=False)


def test_a_column_that_cannot_be_read_is_refused() -> None:
    """Where most of its fields would be left empty."""
    tally = Tally()
    for row in range(1, 7):
        tally.note("a due time that cannot be read", row, "soon")
    check_emptied(Path("a.csv"), 12, tally, force=False)
    check_emptied(Path("a.csv"), 11, tally, force=True)
    found = (
        r'^a.csv: would be left empty: 6 rows with a due time that cannot be read: row 1 "soon", .*; expected at most'
    )
    with pytest.raises(InputError, match=found):
        check_emptied(Path("a.csv"), 11, tally, force=False)


@pytest.mark.parametrize(
    ("left", "said"), [(1, ""), (2, "Warning: 20 % of the rows of a.csv are left out (2 of 10).\n")]
)
def test_more_than_a_tenth_is_a_warning(capsys: pytest.CaptureFixture[str], left: int, said: str) -> None:
    """On standard error."""
    warn_of_share("a.csv", rows(10, left, chosen=3))
    assert capsys.readouterr().err == said
