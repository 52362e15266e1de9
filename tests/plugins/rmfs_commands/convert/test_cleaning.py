"""Rows of order lines, read or left out."""

from __future__ import annotations

import pytest

from rmfs_commands.convert.cleaning import Choice, Cleaner, Columns, Reader
from rmfs_commands.convert.quantities import Quantities
from rmfs_commands.convert.times import Clock
from rmfs_core.errors import InputError

ALL = Columns("order", "sku", "time", "qty", "due", "prio")


def cleaned(
    *rows: tuple[str, ...], columns: Columns = ALL, choice: Choice | None = None, reader: Reader | None = None
) -> tuple[Cleaner, list[tuple[object, ...]]]:
    """Return a cleaner and what it makes of rows: order, sku, time, quantity, due time, priority."""
    cleaner = Cleaner(columns, reader or Reader(), choice or Choice())
    filled = [(*row, *[""] * (7 - len(row))) for row in rows]
    return cleaner, list(cleaner.lines("lines.csv", enumerate(filled, 1)))


def test_a_row_is_an_order_line() -> None:
    """Order, SKU, tick, ticks ahead of UTC, items, due tick, priority, row."""
    _, lines = cleaned((" A ", "tea", "5", "2.0", "60", "3"), ("B", "cafe\u0301", "6", "1"))
    assert lines == [("A", "tea", 5000, 0, 2, 60_000, 3, 1), ("B", "caf\u00e9", 6000, 0, 1, None, None, 2)]


def test_each_row_left_out_has_its_reason() -> None:
    """The first thing that is wrong with it; some are named, all are counted, and their orders are lost lines of."""
    wrong: list[tuple[str, ...]] = [
        ("", "tea", "1", "1"),
        ("A", "", "1", "1"),
        *(("B", "tea", "1", text) for text in ("0", "-1", "1.5", "")),
    ]
    wrong += [("C", "tea", "noon", "1"), ("order", "sku", "time", "qty"), ("", " ", "")]
    wrong += [("D", "tea", "1", "1000001")]
    cleaner, lines = cleaned(*wrong)
    assert lines == []
    assert cleaner.left_out() == [
        "1 row with no order: row 1",
        '1 row with no SKU: row 2 "A"',
        "4 rows with a quantity that is no whole number from 1 on (returns, weights): "
        'row 3 "0", row 4 "-1", row 5 "1.5"',
        '1 row with no time that can be read: row 7 "noon"',
        "1 row with the header again: row 8",
        '1 row with more than 1,000,000 items in a line: row 10 "1000001"',
    ]
    assert (cleaner.rows, cleaner.blank) == (9, 1)
    assert cleaner.lost == [(name, True) for name in "ABBBBCD"]
    assert cleaner.dropped.unasked == 9


def test_what_options_leave_out() -> None:
    """It does not count as left out without being asked for."""
    choice = Choice(("cafe\u0301",), most=8)
    cleaner, lines = cleaned(
        ("A", "caf\u00e9", "1", "1"), ("A", "tea", "1", "9"), ("A", "tea", "1", "8"), choice=choice
    )
    assert len(lines) == 1
    assert cleaner.left_out() == [
        '1 row with a SKU to leave out: row 1 "caf\u00e9"',
        '1 row with more than 8 items in a line: row 2 "9"',
    ]
    assert cleaner.dropped.unasked == 0
    cleaner.check_choice(list)


def test_a_sku_to_leave_out_has_to_be_there() -> None:
    """A slip of the pen would leave nothing out."""
    cleaner, _ = cleaned(("A", "FRACHT", "1", "1"), choice=Choice(("fracht",)))
    missing = r'^--leave-out-sku: no row has the SKU "fracht"'
    with pytest.raises(InputError, match=missing + r" \(did you mean `FRACHT`\?\); expected SKUs of the table$"):
        cleaner.check_choice(lambda: ["FRACHT", "tea"])
    with pytest.raises(InputError, match=f"{missing}; expected SKUs of the table$"):
        cleaner.check_choice(lambda: ["tea"])


def test_the_other_decimal_sign_is_offered_where_it_reads_quantities() -> None:
    """Not for what no sign makes whole, and not where no sign was given."""
    part = "1 row with a quantity that is no whole number from 1 on (returns, weights)"
    for given, text, end in ((".", "1,00", "; perhaps --decimal ,"), (".", "1,50", ""), (",", "x", "")):
        cleaner = Cleaner(Columns("o", "s", quantity="q"), Reader(quantities=Quantities(given)), Choice())
        list(cleaner.lines("t.csv", [(1, ("A", "tea", "", text, "", "", ""))]))
        assert cleaner.left_out() == [f'{part}: row 1 "{text}"{end}']


def test_fields_that_cannot_be_read_are_left_empty() -> None:
    """Due times and priorities need not be there."""
    cleaner, lines = cleaned(("A", "tea", "5", "1", "soon", "-1"), ("A", "tea", "5", "1", "9", str(10**10)))
    assert [line[5:7] for line in lines] == [(None, None), (9000, None)]
    assert [part for _, part in cleaner.emptied.parts()] == [
        '1 row with a due time that cannot be read: row 1 "soon"',
        '2 rows with a priority that is no whole number from 0 on: row 1 "-1", row 2 "10000000000"',
    ]
    assert not cleaner.dropped.reasons


def test_a_due_time_that_stands_for_none_is_left_empty() -> None:
    """As 9999-12-31 does; a time of that kind leaves the row out."""
    cleaner, lines = cleaned(("A", "tea", "2024-03-01", "1", "9999-12-31"), ("A", "tea", "1900-01-01", "1", ""))
    assert [line[5] for line in lines] == [None]
    stands = "time that stands for none (before 1971 or after 2099)"
    assert [part for _, part in cleaner.emptied.parts()] == [f'1 row with a due {stands}: row 1 "9999-12-31"']
    assert cleaner.left_out() == [f'1 row with a {stands}: row 2 "1900-01-01"']


@pytest.mark.parametrize(
    ("rows", "problem"),
    [
        (
            [("A", "tea", "4", "1"), ("B", "tea", "2024-03-01", "1")],
            "row 2, time: found dates without an offset where the rows before have seconds",
        ),
        (
            [("A", "tea", "2024-03-01", "1", "500")],
            "row 1, due: found seconds where the rows before have dates without an offset",
        ),
    ],
)
def test_times_of_two_kinds_are_refused(rows: list[tuple[str, ...]], problem: str) -> None:
    """With the row where the second kind begins: they have no time 0 in common."""
    with pytest.raises(InputError) as caught:
        cleaned(*rows)
    assert str(caught.value).startswith(f"lines.csv, {problem}")


@pytest.mark.parametrize(
    ("row", "question"),
    [
        (("A", "tea", "1", "1.000"), 'lines.csv, row 1, qty: found "1.000", which may be 1 or 1000; expected'),
        (
            ("A", "tea", "1", "1", "", "1,000"),
            'lines.csv, row 1, prio: found "1,000", which may be 1000 or 1; expected',
        ),
        (
            ("A", "tea", "20240229", "1"),
            'lines.csv, time: found numbers such as "20240229" in row 1, which may be dates as',
        ),
    ],
)
def test_numbers_that_may_mean_two_things_are_asked_about(row: tuple[str, ...], question: str) -> None:
    """Before anything is made of them."""
    cleaner, _ = cleaned(row)
    with pytest.raises(InputError) as caught:
        cleaner.ask("lines.csv")
    assert str(caught.value).startswith(question)


def test_a_format_is_guessed_where_no_time_can_be_read() -> None:
    """From the rows that are named."""
    cleaner, _ = cleaned(("A", "tea", "13.03.2024", "1"), reader=Reader(Clock()))
    assert cleaner.left_out() == [
        '1 row with no time that can be read: row 1 "13.03.2024"; perhaps --time-format %d.%m.%Y'
    ]


def test_columns_that_a_table_has_not() -> None:
    """Every line is one item, and every order is there from the start."""
    _, lines = cleaned(("A", "tea", "x", "x"), columns=Columns("order", "sku"))
    assert lines == [("A", "tea", 0, 0, 1, None, None, 1)]
