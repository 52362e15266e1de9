"""Columns found by their names."""

from __future__ import annotations

import pytest

from rmfs_commands.convert.headers import plain, positions
from rmfs_core.errors import InputError


def test_names_are_compared_without_spaces_and_in_one_spelling() -> None:
    """Letter and accent may be one sign or two, in the table and in what is asked for."""
    assert positions([" Order ", "Me\u0301nge", "x"], ["M\u00e9nge", "Order", "Order"], "t") == [1, 0, 0]
    assert plain(" e\u0301 ") == "\u00e9"


@pytest.mark.parametrize(
    ("header", "column", "problem"),
    [
        (["Order", "Qty", "Qty"], "Qty", 'found the column "Qty" 2 times; expected each once'),
        (["Order", "Qty"], "Qtty", 'there is no column "Qtty" (did you mean `Qty`?); found Order and Qty'),
        ([], "Qty", 'there is no column "Qty"; found nothing'),
        ([f"c{i}" for i in range(40)], "Qty", 'there is no column "Qty"; found c0, c1, c2, c3, c4 and 35 more'),
    ],
)
def test_a_column_that_is_not_there_once_is_refused(header: list[str], column: str, problem: str) -> None:
    """One sentence with the place of the header."""
    with pytest.raises(InputError) as caught:
        positions(header, [column], "lines.csv, line 1")
    assert str(caught.value) == f"lines.csv, line 1: {problem}"


def test_a_hint_takes_the_place_of_what_may_be_meant() -> None:
    """It is asked for only when a column is missing."""
    with pytest.raises(InputError, match=r'there is no column "a"; say so; found b$'):
        positions(["b"], ["a"], "t", lambda: "; say so")
    assert positions(["a"], ["a"], "t", lambda: 1 / 0) == [0]  # type: ignore[arg-type, return-value]
