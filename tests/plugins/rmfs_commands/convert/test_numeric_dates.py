"""Numbers that may be dates."""

from __future__ import annotations

import pytest

from rmfs_commands.convert.numeric_dates import NumericDates, looks_of


@pytest.mark.parametrize(
    ("text", "options"),
    [
        ("20240229", ["%Y%m%d"]),
        ("20240229.0", ["%Y%m%d"]),
        ("99991231", ["%Y%m%d"]),
        ("00000000", ["%Y%m%d"]),
        ("240229", ["%y%m%d"]),
        ("061012", ["%y%m%d", "%H%M%S"]),
        ("45351.25", ["spreadsheet"]),
        ("1709251200", ["unix"]),
        ("1709251200000", ["unix-ms"]),
        ("20240229061000", ["%Y%m%d%H%M%S"]),
        ("202402290610", ["%Y%m%d%H%M"]),
        ("240229061000", ["%y%m%d%H%M%S"]),
        # seconds
        ("0", []),
        ("36525", []),
        ("54789", []),
        ("241329", []),
        ("20241329", []),
        ("17092512", []),
        ("315619200", []),
    ],
)
def test_what_a_number_may_be(text: str, options: list[str]) -> None:
    """By its digits before the point."""
    assert [look.option for look in looks_of(text)] == options


@pytest.mark.parametrize(
    ("texts", "question"),
    [
        (
            ["20240229"] * 9 + ["0"],
            'found numbers such as "20240229" in row 1, which may be dates as YYYYMMDD (--time-format %Y%m%d), '
            "or seconds (--time-format seconds)",
        ),
        (
            ["061012", "101112"],
            'found numbers such as "061012" in row 1, which may be dates as YYMMDD (--time-format %y%m%d) or '
            "times of the day as HHMMSS (--time-format %H%M%S), or seconds (--time-format seconds)",
        ),
        (["20240229"] * 8 + ["0"], None),  # fewer than nine of ten
        (["151617", "235959"], None),  # times of the day begin with 0 somewhere
        ([], None),
    ],
)
def test_most_of_a_column_has_to_look_like_dates(texts: list[str], question: str | None) -> None:
    """Then it is asked what it is."""
    numbers = NumericDates()
    for row, text in enumerate(texts, 1):
        numbers.note(text, row)
    assert numbers.question() == question
