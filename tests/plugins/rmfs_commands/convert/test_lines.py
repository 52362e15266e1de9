"""Order lines: read or left out, brought together by order, joined with their headers."""

import io
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

import rmfs_core
from calling import refusal, refused
from cases import cases
from rmfs_commands.cli.main import main
from rmfs_commands.convert.cleaning import Choice, Cleaner, Columns, Reader
from rmfs_commands.convert.lines import OrderLines, Sku, Span
from rmfs_commands.convert.quantities import Quantities
from rmfs_commands.convert.tables import Table
from rmfs_commands.convert.time_formats import Moment
from rmfs_commands.convert.times import Clock
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
    stream = io.StringIO()
    lines.write(stream, start)
    return stream.getvalue().splitlines()[1:]


def test_orders_and_their_times(read: Read) -> None:
    lines = read(*(f"{row},," for row in ("B,tea,9,1", "A,jam,5,2", "B,tea,7,3", "B,jam,9,1", "C,tea,5,1")))
    assert lines.gather() == Moment(0)
    assert written(lines) == ["A,5,jam,2", "C,5,tea,1", "B,7,tea,4", "B,7,jam,1"]
    assert (lines.n_orders, lines.n_lines, lines.joined, lines.several["times"]) == (3, 4, 1, 1)
    assert lines.largest(2) == [("B", "tea", 4), ("A", "jam", 2)]
    lines = read("A,tea,10,2,,", "B,tea,12.5,1,,")
    assert lines.gather(Span(start=Moment(10_000))) == Moment(10_000)
    stream = io.StringIO()
    totals, demand = lines.write(stream, 10_000)
    assert stream.getvalue() == "order,arrival_s,sku,quantity\nA,0,tea,2\nB,2.5,tea,1\n"
    assert (totals["items"], demand.last, demand.lines.total()) == (3, 2500, 2)
    lines = read("A,tea,2024-07-01T06:00,1,,")
    start = lines.cleaner.reader.clock.option("--start", "2024-07-01T07:00")
    with pytest.raises(
        InputError, match="--start: found 2024-07-01T07:00:00, but the first order arrives at 2024-07-01T06"
    ):
        lines.gather(Span(start=start))
    columns = Columns("order", "sku", "time", "qty", time_of_day="due")
    lines = read("A,tea,2024-03-01,1,06:10,", "B,tea, 20240301 ,1,061500,", "C,tea,2024-03-01,1,,", columns=columns)
    assert written(lines, lines.gather().tick) == ["C,0,tea,1", "A,22200,tea,1", "B,22500,tea,1"]
    lines = read("A,tea,x,x,,", "A,tea,x,x,,", columns=Columns("order", "sku"))
    assert lines.gather() == Moment(0)
    assert written(lines) == ["A,0,tea,2"]


def test_an_order_is_cancelled_with_the_last_of_its_lines(read: Read) -> None:
    """One of which a line is not stays, and none leaves before it came."""
    columns = Columns("order", "sku", "time", "qty", cancelled="due")
    rows = ("A,tea,10,2,12,", "A,jam,10,2,15.5,", "B,tea,11,1,12,", "B,jam,11,1,,", "C,tea,20,1,19,")
    lines = read(*rows, columns=columns)
    lines.gather()
    assert written(lines) == ["A,10,tea,2,15.5", "A,10,jam,2,15.5", "B,11,tea,1,", "B,11,jam,1,", "C,20,tea,1,20"]


@pytest.mark.parametrize("rows", [(1, 0), (0, 1)])
def test_time_zero_is_midnight_by_the_clock_of_the_first_order(read: Read, rows: tuple[int, int]) -> None:
    both = ("A,tea,2024-07-01T06:00+02:00,1,,", "B,tea,2024-07-01T05:00Z,1,,")
    lines = read(*(both[i] for i in rows))
    zero = lines.gather()
    assert lines.cleaner.reader.clock.iso(zero) == "2024-07-01T00:00:00+02:00"
    assert written(lines, zero.tick) == ["A,21600,tea,1", "B,25200,tea,1"]
    assert lines.offsets == [0, 7_200_000]


def test_orders_outside_a_span_are_left_out_whole(read: Read) -> None:
    lines = read(*(f"{row},1,," for row in ("A,tea,4.999", "A,tea,6", "B,tea,5", "C,tea,7", "D,tea,8")))
    lines.gather(Span(Moment(5000), Moment(8000)))
    assert written(lines) == ["B,5,tea,1", "C,7,tea,1"]
    assert lines.left_out == {"a time outside the chosen span": 2}
    assert lines.cleaner.dropped.unasked == 0
    lines = read("A,tea,4,1,,", "B,tea,9,1,,")
    with pytest.raises(InputError, match=r"\(2\) are outside: from 4 s to 9 s; expected a span with"):
        lines.gather(Span(Moment(5000), Moment(8000)))
    with pytest.raises(
        InputError, match=r'could be kept: 2 rows with no SKU: row 1 "A", row 2 "B"; 1 row with no order: row 3$'
    ):
        read("A,,1,1,,", "B,,1,1,,", ",tea,1,1,,")


def test_an_order_that_loses_a_line_is_shortened(read: Read) -> None:
    kept = ("A,tea,1,1,,", "B,tea,1,1,,", "D,rye,1,5,,", "D,rye,2,5,,", "D,jam,1,1,,")
    rows = (*kept, "A,jam,1,-1,,", "C,jam,1,-1,,", "C,jam,1,-2,,")
    lines = read(*rows, choice=Choice(most=9))
    lines.gather()
    assert lines.shortened == 2
    assert lines.left_out == {"no row that is kept": 1}
    assert written(lines) == ["A,1,tea,1", "B,1,tea,1", "D,1,jam,1"]
    assert '1 row with more than 9 items in a line: row 3 "10"' in lines.cleaner.left_out()
    lines = read(*rows, choice=Choice(most=9))
    lines.gather(whole=True)
    assert (lines.shortened, written(lines)) == (0, ["B,1,tea,1"])
    assert lines.left_out["a line that is left out (--whole-orders)"] == 2


def test_what_is_left_out_of_orders(read: Read) -> None:
    rows = ("A,tea,1,1,,", "A,post,1,1,,", "B,post,1,1,,", "C,tea,1,1,,", "C,post,1,1,,", "C,jam,1,0,,")
    lines = read(*rows, choice=Choice(leave_out=("post",)))
    lines.gather()
    assert (lines.shortened, lines.left_out) == (1, {"no row that is kept": 1})
    lines = read(*rows, choice=Choice(leave_out=("post",)))
    lines.gather(whole=True)
    assert written(lines) == ["A,1,tea,1"]
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
    assert lines.write(stream, 5000)[0]["early"] == 1
    assert stream.getvalue().splitlines() == [
        "order,arrival_s,sku,quantity,due_s,priority",
        "A,0,tea,1,25,3",
        "A,0,jam,1,25,3",
        "A,0,rye,1,25,3",
        "B,1,tea,1,,",
        "C,2,tea,1,,",
        "D,3,tea,1,0,2",
    ]
    assert lines.several == {"times": 0, "dues": 1, "priorities": 1, "routes": 0}


CLEANING_ALL = Columns("order", "sku", "time", "qty", "due", "prio")


def cleaned(
    *rows: tuple[str, ...], columns: Columns = CLEANING_ALL, choice: Choice | None = None, reader: Reader | None = None
) -> tuple[Cleaner, list[tuple[object, ...]]]:
    """Return a cleaner and what it makes of rows: order, sku, time, quantity, due time, priority."""
    cleaner = Cleaner(columns, reader or Reader(), choice or Choice())
    filled = [(*row, *[""] * (9 - len(row))) for row in rows]
    return cleaner, list(cleaner.lines("lines.csv", enumerate(filled, 1)))


def test_a_row_is_an_order_line() -> None:
    _, lines = cleaned((" A ", "tea", "5", "2.0", "60", "3"), ("B", "cafe\u0301", "6", "1"))
    assert lines == [
        ("A", "tea", 5000, 0, 2, 60_000, 3, None, 1, None),
        ("B", "caf\u00e9", 6000, 0, 1, *[None] * 3, 2, None),
    ]


def test_each_row_left_out_has_its_reason() -> None:
    wrong = [("", "tea", "1", "1"), ("A", "", "1", "1"), *(("B", "tea", "1", n) for n in ("0", "-1", "1.5", ""))]
    wrong += [("C", "tea", "noon", "1"), ("order", "sku", "time", "qty"), ("", " ", ""), ("D", "tea", "1", "1000001")]
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


def test_skus_to_leave_out_and_signs_are_looked_at() -> None:
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
    cleaner, _ = cleaned(("A", "FRACHT", "1", "1"), choice=Choice(("fracht",)))
    missing = r'^--leave-out-sku: no row has the SKU "fracht"'
    with pytest.raises(InputError, match=missing + r" \(did you mean `FRACHT`\?\); expected SKUs of the table$"):
        cleaner.check_choice(lambda: ["FRACHT", "tea"])
    with pytest.raises(InputError, match=f"{missing}; expected SKUs of the table$"):
        cleaner.check_choice(lambda: ["tea"])
    part = "1 row with a quantity that is no whole number from 1 on (returns, weights)"
    for given, text, end in ((".", "1,00", "; perhaps --decimal ,"), (".", "1,50", ""), (",", "x", "")):
        cleaner = Cleaner(Columns("o", "s", quantity="q"), Reader(quantities=Quantities(given)), Choice())
        list(cleaner.lines("t.csv", [(1, ("A", "tea", "", text, *[""] * 5))]))
        assert cleaner.left_out() == [f'{part}: row 1 "{text}"{end}']


def test_what_cannot_be_read_is_left_empty() -> None:
    cleaner, lines = cleaned(("A", "tea", "5", "1", "soon", "-1"), ("A", "tea", "5", "1", "9", str(10**10)))
    assert [line[5:7] for line in lines] == [(None, None), (9000, None)]
    assert [part for _, part in cleaner.emptied.parts()] == [
        '1 row with a due time that cannot be read: row 1 "soon"',
        '2 rows with a priority that is no whole number from 0 on: row 1 "-1", row 2 "10000000000"',
    ]
    assert not cleaner.dropped.reasons
    cleaner, lines = cleaned(("A", "tea", "2024-03-01", "1", "9999-12-31"), ("A", "tea", "1900-01-01", "1", ""))
    assert [line[5] for line in lines] == [None]
    stands = "time that stands for none (before 1971 or after 2099)"
    assert [part for _, part in cleaner.emptied.parts()] == [f'1 row with a due {stands}: row 1 "9999-12-31"']
    assert cleaner.left_out() == [f'1 row with a {stands}: row 2 "1900-01-01"']


@cases(
    "rows problem",
    (
        [("A", "tea", "4", "1"), ("B", "tea", "2024-03-01", "1")],
        "row 2, time: found dates without an offset where the rows before have seconds",
    ),
    (
        [("A", "tea", "2024-03-01", "1", "500")],
        "row 1, due: found seconds where the rows before have dates without an offset",
    ),
)
def test_times_of_two_kinds_are_refused(rows: list[tuple[str, ...]], problem: str) -> None:
    """With the row where the second kind begins: they have no time 0 in common."""
    assert refusal(lambda: cleaned(*rows)).startswith(f"lines.csv, {problem}")


@cases(
    "row question",
    (("A", "tea", "1", "1.000"), 'lines.csv, row 1, qty: found "1.000", which may be 1 or 1000; expected'),
    (("A", "tea", "1", "1", "", "1,000"), 'lines.csv, row 1, prio: found "1,000", which may be 1000 or 1; expected'),
    (
        ("A", "tea", "20240229", "1"),
        'lines.csv, time: found numbers such as "20240229" in row 1, which may be dates as',
    ),
)
def test_numbers_that_may_mean_two_things_are_asked_about(row: tuple[str, ...], question: str) -> None:
    cleaner, _ = cleaned(row)
    assert refusal(lambda: cleaner.ask("lines.csv")).startswith(question)


def test_a_format_is_guessed_where_no_time_can_be_read() -> None:
    cleaner, _ = cleaned(("A", "tea", "13.03.2024", "1"), reader=Reader(Clock()))
    assert cleaner.left_out() == [
        '1 row with no time that can be read: row 1 "13.03.2024"; perhaps --time-format %d.%m.%Y'
    ]


HEADS = """\
Document;Created;Promised;Urgency
7;01.03.2024 06:10;01.03.2024 08:00;1
8;01.03.2024 06:05;;
8;01.03.2024 06:20;01.03.2024 09:00;2
9;01.03.2024 07:00;;
10;yesterday;;
;01.03.2024 07:00;;
"""
LINES = """\
Order;Article;Qty
7;tea;1,000
8;mug;2,000
7;spoon;1,000
10;tea;1,000
11;tea;1,000
"""
COLUMNS = ("--order", "Order", "--sku", "Article", "--quantity", "Qty", "--decimal", ",", "--separator", ";")
OF_HEADS = ("--order-key", "Document", "--time", "Created", "--due", "Promised", "--priority", "Urgency")
FORMAT = ("--time-format", "%d.%m.%Y %H:%M")


def convert(folder: Path, *options: str, heads: str = HEADS, lines: str = LINES) -> None:
    (folder / "heads.csv").write_text(heads, encoding="utf-8")
    (folder / "lines.csv").write_text(lines, encoding="utf-8")
    tables = [str(folder / "lines.csv"), "--orders", str(folder / "heads.csv")]
    main(["convert", "orders", *tables, *COLUMNS, *FORMAT, "--out", str(folder / "out"), *options])


def test_lines_have_what_their_headers_say(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    convert(tmp_path, *OF_HEADS)
    assert (tmp_path / "out" / "orders.csv").read_text(encoding="utf-8").splitlines() == [
        "order,arrival_s,sku,quantity,due_s,priority",
        "8,21900,mug,2,32400,2",
        "7,22200,tea,1,28800,1",
        "7,22200,spoon,1,28800,1",
    ]
    told = capsys.readouterr().out
    file = tmp_path / "heads.csv"
    assert f"Read 6 headers of {file}.\n" in told
    assert f'Left out of {file}: 1 row with no time that can be read: row 5 "yesterday".\n' in told
    assert f"Left out of {file}: 1 row with no order: row 6.\n" in told
    assert f'Left out of {file}: 1 order without lines: "9".\n' in told
    assert f'Left out: 2 rows with no header in {file} that is kept: row 4 "10", row 5 "11".\n' in told
    assert "Left out: 2 orders with no row that is kept.\n" in told
    assert "Headers with different times: 1 order; the earliest is the order's.\n" in told


def test_an_order_is_left_out_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    convert(tmp_path, *OF_HEADS, lines=LINES + "11;mug;-1,000\n12;mug;-1,000\n7;mug;1,000\n")
    told = capsys.readouterr().out
    assert f"Left out: 2 rows with no header in {tmp_path / 'heads.csv'} that is kept: row 4" in told
    assert "Left out: 3 orders with no row that is kept.\n" in told


def test_orders_of_two_tables_run(tmp_path: Path) -> None:
    convert(tmp_path, *OF_HEADS[2:], "--pods", "12", "--skus-per-pod", "1", heads=HEADS.replace("Document", "Order"))
    result = rmfs_core.run(tmp_path / "out" / "scenario.toml")
    assert [order["arrival_s"] for order in result.orders] == [21_900.0, 22_200.0]
    assert result.status == "complete"


@cases(
    "changed options sentence",
    (
        {"lines": LINES.replace("\n", "\n0")[:-1]},
        OF_HEADS,
        'no order of {lines} has a header: found orders "07" and "08" there, and "7", "8" and "9" here',
    ),
    ({"heads": "Document;Created\n"}, OF_HEADS[:4], "heads.csv: has no header of an order that could be kept"),
    ({}, OF_HEADS[2:], 'heads.csv, line 1: there is no column "Order"'),
    ({}, (*OF_HEADS[:2], "--time", "Made"), 'heads.csv, line 1: there is no column "Made"'),
    (
        {"lines": LINES + "12;tea;1,000\n13;tea;1,000\n"},
        OF_HEADS,
        "lines.csv: 4 of 7 rows would be left out: 4 rows with no header in ",
    ),
    (
        {"heads": "Document;Created;Promised;Urgency\n7;01.03.2024 06:10;2.3.;1\n8;01.03.2024 06:05;2.3.;2\n"},
        OF_HEADS,
        "heads.csv: would be left empty: 2 rows with a due time that cannot be read: row 1 ",
    ),
    (
        {"heads": HEADS + "11;today;;\n12;today;;\n13;today;;\n"},
        OF_HEADS,
        "heads.csv: 5 of 9 rows would be left out: 4 rows with no time that can be read: ",
    ),
    (
        {"heads": "Document;Created\n7;20240301\n8;20240302\n"},
        (*OF_HEADS[:4], "--time-format", "seconds", "--due", "x"),
        'there is no column "x"',
    ),
)
def test_what_does_not_fit_together_is_refused(tmp_path, capsys, changed, options, sentence) -> None:
    told = refused(capsys, convert, tmp_path, *options, **changed)
    assert sentence.format(lines=tmp_path / "lines.csv") in told
    assert not list((tmp_path / "out").glob("*"))
