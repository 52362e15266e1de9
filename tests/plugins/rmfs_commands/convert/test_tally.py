"""Rows that are left out, by reason."""

from __future__ import annotations

from rmfs_commands.convert.tally import Tally


def test_rows_are_counted_and_the_first_are_named() -> None:
    """Each reason is a part of a sentence; what an option asked for does not count as unasked."""
    tally = Tally()
    for row in range(4, 9):
        tally.note("no SKU", row, "A\n" if row == 4 else "")
    tally.note("a SKU to leave out", 9, "tea", chosen=True)
    assert [part for _, part in tally.parts()] == [
        '5 rows with no SKU: row 4 "A\\n", row 5, row 6',
        '1 row with a SKU to leave out: row 9 "tea"',
    ]
    assert tally.unasked == 5
