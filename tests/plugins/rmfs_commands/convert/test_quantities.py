"""Quantities in the notations of many countries."""

from __future__ import annotations

import pytest

from rmfs_commands.convert.quantities import Quantities
from rmfs_core.errors import InputError


def test_another_decimal_sign_is_guessed_by_what_it_reads() -> None:
    """One text that it makes whole and not 0 is enough; without a sign that was given nothing is left to guess."""
    assert Quantities(".").guessed(["x", "1,00"]) == "; perhaps --decimal ,"
    assert Quantities(",").guessed(["1.00"]) == "; perhaps --decimal ."
    assert Quantities(".").guessed(["1,50", "-1,00", ""]) == ""
    assert Quantities().guessed(["1,00"]) == ""


@pytest.mark.parametrize(
    ("text", "decimal", "thousands", "number"),
    [
        ("12", None, None, 12),
        ("007", None, None, 7),
        ("1.0", None, None, 1),
        ("1,00", None, None, 1),
        ("1.", None, None, 1),
        ("1.5", None, None, None),
        ("2,5", None, None, None),
        ("1.234,00", None, None, 1234),
        ("1,234.00", None, None, 1234),
        ("1.234.567", None, None, 1_234_567),
        ("1 000", None, None, 1000),
        ("1\u202f000,0", None, None, 1000),
        ("1'000", None, None, 1000),
        ("0.500", None, None, None),  # no number of thousands begins with 0
        ("1234,000", None, None, 1234),
        ("12,34", None, None, None),
        # known signs
        ("1.000", ".", None, 1),
        ("1.000", ",", None, 1000),
        ("1,000", ".", None, 1000),
        ("1,000", ".", "'", None),  # a comma is neither
        ("1.000", None, ".", 1000),
        ("1.000", None, ",", 1),
        ("1.000", None, " ", 1),
        # no whole numbers
        ("", None, None, None),
        ("-3", None, None, None),
        ("3-", None, None, None),
        ("(2)", None, None, None),
        ("1e3", None, None, None),
        ("2 pcs", None, None, None),
        ("\u0663", None, None, None),
        ("9" * 16, None, None, None),
    ],
)
def test_a_number_is_read(text: str, decimal: str | None, thousands: str | None, number: int | None) -> None:
    """Where only one reading is possible it is that one; nothing is asked."""
    quantities = Quantities(decimal, thousands)
    assert quantities.whole(text, 1) == number
    quantities.ask("lines.csv", "Menge")


def test_what_can_be_read_in_two_ways_is_asked() -> None:
    """With the first row of it, and a number of the column that can be read in one way only."""
    quantities = Quantities()
    assert [quantities.whole(text, row) for row, text in enumerate(("1", "1.000", "2,5", "12.000"), 1)] == [1] + [
        None
    ] * 3
    with pytest.raises(InputError) as caught:
        quantities.ask("lines.csv", "Menge")
    assert str(caught.value) == (
        'lines.csv, row 2, Menge: found "1.000", which may be 1 or 1000 (row 3 has "2,5"); '
        "expected --decimal . if the point is before fractions, or --decimal , if the comma is"
    )
