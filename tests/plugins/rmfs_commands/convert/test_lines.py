"""Order lines: brought together by order, and written as orders."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from rmfs_commands.convert.cleaning import Choice, Cleaner, Columns, Reader
from rmfs_commands.convert.lines import OrderLines, Sku, Span
from rmfs_commands.convert.tables import Table
from rmfs_commands.convert.time_formats import Moment
from rmfs_core.errors import InputError

ALL = Columns("order", "sku", "time", "qty")
Read = Callable[..., OrderLines]


@pytest.fixture
def read(tmp_path: Path) -> Iterator[Read]:
    """Return what takes in a table of rows: order, sku, time, quantity, due time, priority."""
    with ExitStack() as stack:

        def lines_of(*rows: str, columns: Columns = ALL, choice: Choice | None = None) -> OrderLines:
            file = tmp_path / "lines.csv"
            file.write_text("".join(f"{row}\n" for row in ("order,sku,time,qty,due,prio", *rows)), encoding="utf-8")
            lines = stack.enter_context(OrderLines(Cleaner(columns, Reader(), choice or Choice())))
            lines.read(Table(file))
            return lines

        yield lines_of


def written(lines: OrderLines, start: int = 0) -> list[str]:
    """Return the rows of the orders written, without the header."""
    stream = io.StringIO()
    lines.write(stream, start)
    return stream.getvalue().splitlines()[1:]


def test_an_order_has_each_sku_once_and_its_earliest_time(read: Read) -> None:
    """Orders by time, then as they stand in the table; within an order SKUs as they stand there."""
    lines = read(*(f"{row},," for row in ("B,tea,9,1", "A,jam,5,2", "B,tea,7,3", "B,jam,9,1", "C,tea,5,1")))
    assert lines.gather() == Moment(0)
    assert written(lines) == ["A,5,jam,2", "C,5,tea,1", "B,7,tea,4", "B,7,jam,1"]
    assert (lines.n_orders, lines.n_lines, lines.joined, lines.several["times"]) == (3, 4, 1, 1)
    assert lines.largest(2) == [("B", "tea", 4), ("A", "jam", 2)]


def test_time_zero_is_chosen_when_writing(read: Read) -> None:
    """Arrivals are seconds after it, whole where they are whole; totals say how many items and how long."""
    lines = read("A,tea,10,2,,", "B,tea,12.5,1,,")
    assert lines.gather(Span(start=Moment(10_000))) == Moment(10_000)
    stream = io.StringIO()
    totals = lines.write(stream, 10_000)
    assert stream.getvalue() == "order,arrival_s,sku,quantity\nA,0,tea,2\nB,2.5,tea,1\n"
    assert (totals["items"], totals["last"]) == (3, 2500)


@pytest.mark.parametrize("rows", [(1, 0), (0, 1)])
def test_time_zero_is_midnight_by_the_clock_of_the_first_order(read: Read, rows: tuple[int, int]) -> None:
    """Whatever row it is in, and whatever the clock of the others; 06:00+02:00 is 06:00."""
    both = ("A,tea,2024-07-01T06:00+02:00,1,,", "B,tea,2024-07-01T05:00Z,1,,")
    lines = read(*(both[i] for i in rows))
    zero = lines.gather()
    assert lines.cleaner.reader.clock.iso(zero) == "2024-07-01T00:00:00+02:00"
    assert written(lines, zero.tick) == ["A,21600,tea,1", "B,25200,tea,1"]
    assert lines.offsets == [0, 7_200_000]


def test_an_order_before_time_zero_is_refused(read: Read) -> None:
    """Time 0 would have to be earlier."""
    lines = read("A,tea,2024-07-01T06:00,1,,")
    start = lines.cleaner.reader.clock.option("--start", "2024-07-01T07:00")
    with pytest.raises(
        InputError, match="--start: found 2024-07-01T07:00:00, but the first order arrives at 2024-07-01T06"
    ):
        lines.gather(Span(start=start))


def test_the_time_of_the_day_may_be_in_a_column_of_its_own(read: Read) -> None:
    """Beside the date, as exports of ERP systems have it."""
    columns = Columns("order", "sku", "time", "qty", time_of_day="due")
    lines = read("A,tea,2024-03-01,1,06:10,", "B,tea, 20240301 ,1,061500,", "C,tea,2024-03-01,1,,", columns=columns)
    assert written(lines, lines.gather().tick) == ["C,0,tea,1", "A,22200,tea,1", "B,22500,tea,1"]


def test_columns_that_a_table_has_not(read: Read) -> None:
    """Every line is one item, and every order is there from the start."""
    lines = read("A,tea,x,x,,", "A,tea,x,x,,", columns=Columns("order", "sku"))
    assert lines.gather() == Moment(0)
    assert written(lines) == ["A,0,tea,2"]


def test_orders_outside_a_span_are_left_out_whole(read: Read) -> None:
    """The begin belongs to it, the end does not; what counts is the order's time, its earliest."""
    lines = read(*(f"{row},1,," for row in ("A,tea,4.999", "A,tea,6", "B,tea,5", "C,tea,7", "D,tea,8")))
    lines.gather(Span(Moment(5000), Moment(8000)))
    assert written(lines) == ["B,5,tea,1", "C,7,tea,1"]
    assert lines.left_out == {"a time outside the chosen span": 2}
    assert lines.cleaner.dropped.unasked == 0


def test_a_span_without_orders_is_refused(read: Read) -> None:
    """The sentence says how many there are outside, and when."""
    lines = read("A,tea,4,1,,", "B,tea,9,1,,")
    with pytest.raises(InputError, match=r"\(2\) are outside: from 4 s to 9 s; expected a span with"):
        lines.gather(Span(Moment(5000), Moment(8000)))


def test_nothing_to_keep_is_refused(read: Read) -> None:
    """With what was wrong with the rows, by number."""
    with pytest.raises(
        InputError, match=r'could be kept: 2 rows with no SKU: row 1 "A", row 2 "B"; 1 row with no order: row 3$'
    ):
        read("A,,1,1,,", "B,,1,1,,", ",tea,1,1,,")


def test_an_order_that_loses_a_line_is_shortened(read: Read) -> None:
    """It is counted; one of which nothing is left is another thing."""
    rows = (
        "A,tea,1,1,,",
        "A,jam,1,-1,,",
        "B,tea,1,1,,",
        "C,jam,1,-1,,",
        "C,jam,1,-2,,",
        "D,rye,1,5,,",
        "D,rye,2,5,,",
        "D,jam,1,1,,",
    )
    lines = read(*rows, choice=Choice(most=9))
    lines.gather()
    assert lines.shortened == 2
    assert lines.left_out == {"no row that is kept": 1}
    assert written(lines) == ["A,1,tea,1", "B,1,tea,1", "D,1,jam,1"]
    assert '1 row with more than 9 items in a line: row 6 "10"' in lines.cleaner.left_out()
    lines = read(*rows, choice=Choice(most=9))
    lines.gather(whole=True)
    assert (lines.shortened, written(lines)) == (0, ["B,1,tea,1"])
    assert lines.left_out["a line that is left out (--whole-orders)"] == 2


def test_an_order_without_its_postage_is_whole(read: Read) -> None:
    """Lines of SKUs to leave out shorten no order; one that has no others is left out."""
    rows = ("A,tea,1,1,,", "A,post,1,1,,", "B,post,1,1,,", "C,tea,1,1,,", "C,post,1,1,,", "C,jam,1,0,,")
    lines = read(*rows, choice=Choice(leave_out=("post",)))
    lines.gather()
    assert (lines.shortened, lines.left_out) == (1, {"no row that is kept": 1})
    lines = read(*rows, choice=Choice(leave_out=("post",)))
    lines.gather(whole=True)
    assert written(lines) == ["A,1,tea,1"]


def test_what_a_run_would_refuse_is_left_out(read: Read) -> None:
    """Orders that arrive years later, and SKUs of an order that are too many items in all rows together."""
    lines = read(
        "A,tea,2024-03-01,600000,,", "A,tea,2024-03-01,600000,,", "B,tea,2024-03-02,1,,", "C,tea,2034-04-01,1,,"
    )
    lines.gather()
    assert [row[0] for row in written(lines)] == ["B"]
    late = "more than ten years after time 0 (2024-03-02T00:00:00; --from leaves out what is earlier)"
    assert lines.cleaner.left_out() == [
        '1 row with more than 1,000,000 items in a line: row 1 "1,200,000"',
        f'1 row with a time {late}: row 4 "2034-04-01T00:00:00"',
    ]


def test_skus_by_their_lines_and_orders_by_arrival(read: Read) -> None:
    """Most order lines first, then by name; a basket has each SKU of an order once."""
    lines = read(*(f"{row},," for row in ("B,tea,9,1", "B,rye,9,1", "A,jam,5,20", "B,tea,9,3", "C,tea,9,1")))
    lines.gather()
    assert lines.skus() == [Sku("tea", 2, 5), Sku("jam", 1, 20), Sku("rye", 1, 1)]
    assert list(lines.baskets(9)) == [["jam"], ["tea", "rye"], ["tea"]]
    assert list(lines.baskets(2)) == [["jam"], ["tea", "rye"]]


def test_due_times_and_priorities(read: Read) -> None:
    """An order has the earliest and the highest of its lines; what cannot be read is left empty."""
    rows = ["A,tea,5,1,60,1", "A,jam,5,1,30,3", "B,tea,6,1,,", "C,tea,7,1,soon,-1", "D,tea,8,1,2,2.0", "A,rye,5,1,45,"]
    lines = read(*rows, columns=Columns("order", "sku", "time", due="due", priority="prio"))
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
