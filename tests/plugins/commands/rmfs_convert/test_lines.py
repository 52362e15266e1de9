"""Order lines: cleaned, brought together by order, and written as orders."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path

import pytest

from rmfs_convert.lines import Columns, OrderLines, Sku
from rmfs_core.errors import InputError

ALL = Columns("order", "sku", "time", "qty")


@pytest.fixture
def lines() -> Iterator[OrderLines]:
    """Return an empty collection of order lines."""
    with OrderLines() as found:
        yield found


def read(lines: OrderLines, folder: Path, *rows: str, columns: Columns = ALL) -> OrderLines:
    """Take in a table of these rows: order, sku, time, quantity."""
    file = folder / "lines.csv"
    file.write_text("".join(f"{row}\n" for row in ("order,sku,time,qty", *rows)), encoding="utf-8")
    lines.read(file, columns)
    return lines


def written(lines: OrderLines, start: int = 0) -> list[str]:
    """Return the rows of the orders written, without the header."""
    stream = io.StringIO()
    lines.write(stream, start)
    return stream.getvalue().splitlines()[1:]


def test_an_order_has_each_sku_once_and_its_earliest_time(lines: OrderLines, tmp_path: Path) -> None:
    """Orders by time, then as they stand in the table; within an order SKUs as they stand there."""
    read(lines, tmp_path, "B,tea,9,1", "A,jam,5,2", "B,tea,7,3", "B,jam,9,1", "C,tea,5,1")
    assert lines.gather() == 5000
    assert written(lines) == ["A,5,jam,2", "C,5,tea,1", "B,7,tea,4", "B,7,jam,1"]
    assert (lines.rows, lines.n_orders, lines.n_lines, lines.joined, lines.several["times"]) == (5, 3, 4, 1, 1)


def test_time_zero_is_chosen_when_writing(lines: OrderLines, tmp_path: Path) -> None:
    """Arrivals are seconds after it, whole where they are whole; totals say how many items and how long."""
    read(lines, tmp_path, "A,tea,10,2", "B,tea,12.5,1")
    lines.gather()
    stream = io.StringIO()
    totals = lines.write(stream, 10_000)
    assert stream.getvalue() == "order,arrival_s,sku,quantity\nA,0,tea,2\nB,2.5,tea,1\n"
    assert (totals["items"], totals["last"]) == (3, 2500)


def test_each_row_left_out_has_its_reason(lines: OrderLines, tmp_path: Path) -> None:
    """The first thing that is wrong with it; some are named, all are counted."""
    wrong = [",tea,1,1", "A,,1,1", "A,tea,1,0", "A,tea,1,-1", "A,tea,1,1.5", "A,tea,1,", "A,tea,noon,1", " , ,x,x"]
    read(lines, tmp_path, "A, tea ,1, 2 ", *wrong)
    quantity = "a quantity that is no whole number from 1 on (returns, weights)"
    assert {reason: (what.rows, what.examples) for reason, what in lines.dropped.items()} == {
        "no order": (2, [(2, ""), (9, "")]),
        "no SKU": (1, [(3, "A")]),
        quantity: (4, [(4, "0"), (5, "-1"), (6, "1.5")]),
        "no time that can be read": (1, [(8, "noon")]),
    }
    lines.gather()
    assert written(lines) == ["A,1,tea,2"]


def test_columns_that_a_table_has_not(lines: OrderLines, tmp_path: Path) -> None:
    """Every line is one item, and every order is there from the start."""
    read(lines, tmp_path, "A,tea,x,x", "A,tea,x,x", columns=Columns("order", "sku"))
    assert lines.gather() == 0
    assert written(lines) == ["A,0,tea,2"]


def test_orders_outside_a_span_are_left_out_whole(lines: OrderLines, tmp_path: Path) -> None:
    """The begin belongs to it, the end does not; what counts is the order's time, its earliest."""
    read(lines, tmp_path, "A,tea,4.999,1", "A,tea,6,1", "B,tea,5,1", "C,tea,7,1", "D,tea,8,1")
    assert lines.gather(begin=5000, end=8000) == 5000
    assert written(lines) == ["B,5,tea,1", "C,7,tea,1"]
    assert lines.dropped["a time outside the chosen span (orders)"].rows == 2


def test_a_span_without_orders_is_refused(lines: OrderLines, tmp_path: Path) -> None:
    """The sentence says how many there are outside."""
    read(lines, tmp_path, "A,tea,4,1", "B,tea,9,1")
    with pytest.raises(InputError, match=r"^--from, --until: all 2 orders are outside; expected a span with some"):
        lines.gather(begin=5000, end=8000)


def test_nothing_to_keep_is_refused(lines: OrderLines, tmp_path: Path) -> None:
    """With what was wrong with the rows, by number."""
    with pytest.raises(InputError, match=r"has no order line that could be kept: 2 with no SKU; 1 with no order$"):
        read(lines, tmp_path, "A,,1,1", "B,,1,1", ",tea,1,1")


def test_times_of_two_kinds_are_refused(lines: OrderLines, tmp_path: Path) -> None:
    """With the row where the second kind begins."""
    with pytest.raises(InputError, match=r"lines.csv, row 2: found dates without a zone where the rows before have"):
        read(lines, tmp_path, "A,tea,4,1", "B,tea,2024-03-01,1")


def test_skus_by_their_lines_and_orders_by_arrival(lines: OrderLines, tmp_path: Path) -> None:
    """Most order lines first, then by name; a basket has each SKU of an order once."""
    read(lines, tmp_path, "B,tea,9,1", "B,rye,9,1", "A,jam,5,20", "B,tea,9,3", "C,tea,9,1")
    lines.gather()
    assert lines.skus() == [Sku("tea", 2, 5), Sku("jam", 1, 20), Sku("rye", 1, 1)]
    assert list(lines.baskets(9)) == [["jam"], ["tea", "rye"], ["tea"]]
    assert list(lines.baskets(2)) == [["jam"], ["tea", "rye"]]


def test_several_tables_are_one(lines: OrderLines, tmp_path: Path) -> None:
    """An order may be spread over them."""
    read(lines, tmp_path, "A,tea,4,1")
    read(lines, tmp_path, "A,jam,3,1")
    lines.gather()
    assert lines.rows == 2
    assert written(lines) == ["A,3,tea,1", "A,3,jam,1"]


def test_due_times_and_priorities(lines: OrderLines, tmp_path: Path) -> None:
    """An order has the earliest and the highest of its lines; what cannot be read is left empty, and said."""
    file = tmp_path / "lines.csv"
    rows = ["A,tea,5,60,1", "A,jam,5,30,3", "B,tea,6,,", "C,tea,7,soon,-1", "D,tea,8,2,2.0", "A,rye,5,45,"]
    file.write_text("".join(f"{row}\n" for row in ("o,s,t,due,prio", *rows)), encoding="utf-8")
    lines.read(file, Columns("o", "s", "t", due="due", priority="prio"))
    lines.gather()
    stream = io.StringIO()
    assert lines.write(stream, 5000)["early"] == 1
    assert stream.getvalue().splitlines() == [
        "order,arrival_s,sku,quantity,due_s,priority",
        "A,0,tea,1,25,3",
        "A,0,jam,1,25,3",
        "A,0,rye,1,25,3",
        "B,1,tea,1,,",
        "C,2,tea,1,,",
        "D,3,tea,1,0,2",
    ]
    assert lines.several == {"times": 0, "dues": 1, "priorities": 1}
    assert {reason: what.examples for reason, what in lines.emptied.items()} == {
        "a due time that cannot be read": [(4, "soon")],
        "a priority that is no whole number from 0 on": [(4, "-1")],
    }
    assert not lines.dropped


def test_due_times_are_of_the_kind_of_times(lines: OrderLines, tmp_path: Path) -> None:
    """Seconds beside dates have no time 0 in common."""
    file = tmp_path / "lines.csv"
    file.write_text("o,s,t,due\n1,a,2024-03-01T06:00,500\n", encoding="utf-8")
    with pytest.raises(InputError, match="row 1: found seconds where the rows before have dates without a zone"):
        lines.read(file, Columns("o", "s", "t", due="due"))
