"""`rmfs convert orders`: order lines read or left out, brought together, joined with their headers, and the files."""

import shutil
import tomllib
from collections.abc import Mapping
from pathlib import Path

import pytest

import rmfs_core
from calling import refused
from cases import cases
from rmfs_commands.cli.loads import Demand
from rmfs_commands.cli.main import main
from rmfs_commands.convert import loading
from rmfs_commands.convert.cleaning import Choice, Cleaner, Columns, Reader
from rmfs_commands.convert.lines import OrderLines, Sku
from rmfs_commands.convert.scenarios import scenario_of, size_for
from rmfs_commands.convert.tables import Table

LINES = """\
Order No,Article,Qty,Created
A-7,tea,1,2024-03-01T06:10:00
A-8,"mug, red",2,2024-03-01T06:05:30
A-7,spoon,1,2024-03-01T06:12:00
A-7,tea,2,2024-03-01T06:10:00
A-9,spoon,-1,2024-03-01T07:00:00
A-9,,1,2024-03-01T07:00:00
,tea,1,2024-03-01T07:00:00
A-10,lamp,1.0,yesterday
A-11,lamp,1.0,2024-03-01T23:59:59.5
"""
DATES = "dates without an offset"
ON_ONE_POD = "--pods 1 --skus-per-pod 1 --items 5"
COLUMNS = ("--order", "Order No", "--sku", "Article", "--quantity", "Qty", "--time", "Created")
ORDERS = """\
order,arrival_s,sku,quantity
A-8,21930,"mug, red",2
A-7,22200,tea,3
A-7,22200,spoon,1
A-11,86399.5,lamp,1
"""


def table(folder: Path, text: str = LINES) -> Path:
    file = folder / "lines.csv"
    file.write_text(text, encoding="utf-8")
    return file


def command(folder: Path, text: str, options: str = "", *more: str) -> list[str]:
    """Return the command that converts a table with the orders in column o, the SKUs in s, the times in t if any."""
    times = " --time t" * (",t" in text.partition("\n")[0])
    given = f"--order o --sku s{times} --out {folder / 'out'} {options}".split()
    return ["convert", "orders", str(table(folder, text)), *given, *more]


def converted(folder: Path, *given: str) -> list[str]:
    """Convert a table, as `command` has it; return the rows of orders.csv without its header."""
    main(command(folder, *given))
    return (folder / "out" / "orders.csv").read_text(encoding="utf-8").splitlines()[1:]


def test_lines_are_brought_together_by_order(tmp_path: Path) -> None:
    main(["convert", "orders", str(table(tmp_path)), *COLUMNS, "--out", str(tmp_path / "out")])
    assert (tmp_path / "out" / "orders.csv").read_text(encoding="utf-8") == ORDERS


def test_what_is_written_runs(tmp_path: Path) -> None:
    options = f"--pods 12 --skus-per-pod 2 --items 1 --placement popularity --out {tmp_path / 'out'}".split()
    main(["convert", "orders", str(table(tmp_path)), *COLUMNS, *options, "--start", "2024-03-01T06:00"])
    result = rmfs_core.run(tmp_path / "out" / "scenario.toml")
    assert (result.status, result.metrics["picks"]) == ("complete", 7)


def test_orders_that_are_due(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """An order has the earliest due time and the highest priority of its lines."""
    text = "o,s,t,d,p\n1,a,06:00,06:02,1\n1,b,06:00,06:01,2\n1,c,06:00,,\n2,a,06:05,noon,\n3,a,06:06,05:00,-1\n"
    options = "--due d --priority p --time-format %H:%M --pods 12 --skus-per-pod 1 --start 06:00"
    assert converted(tmp_path, text, options) == [
        *("1,0,a,1,60,2", "1,0,b,1,60,2", "1,0,c,1,60,2"),
        *("2,300,a,1,,", "3,360,a,1,0,"),
    ]
    told = capsys.readouterr().out
    assert 'Left empty: 1 row with a due time that cannot be read: row 4 "noon".' in told
    assert 'Lines with different due times: 1 order: row 1 "1"; the earliest is the order\'s.' in told
    assert 'Lines with different priorities: 1 order: row 1 "1"; the highest is the order\'s.' in told
    assert "Due before time 0: 1 order; 0 is written." in told
    orders = rmfs_core.run(tmp_path / "out" / "scenario.toml").orders
    assert [(order["due_s"], order["priority"]) for order in orders] == [(60.0, 2), (None, 0), (0.0, 0)]


@cases(
    "formats days",
    ([], ["2024-03-01", "20240301T0000", "2024-03-02"]),
    (["--time-format", "%d.%m.%Y", "--time-format", "iso"], ["01.03.2024", "2024-03-01T00:00", "02.03.2024"]),
    (["--time-format", "spreadsheet"], ["45352", "45352.00001", "45353"]),
)
def test_dates_without_a_time_of_day(tmp_path, capsys, formats, days) -> None:
    times = [f"2024-03-01T{hour}:00" if "spreadsheet" not in formats else f"45352.{hour}" for hour in (18, 19, 20)]
    rows = [f"{i},a,{time},{day},{day}" for i, (time, day) in enumerate(zip(times, days, strict=True), 7)]
    heads = ["--orders", str(tmp_path / "lines.csv")]
    for more, of in (([], ""), (heads, f" of {heads[1]}")):
        converted(tmp_path, "\n".join(("o,s,t,d,c", *rows)), "--due d --cancelled c --force", *formats, *more)
        told = capsys.readouterr().out
        for what in ("a due time", "a time of cancellation"):
            found = f'2 rows with {what} that is a date alone: row 1 "{days[0]}", row 3 "{days[2]}".\n'
            assert f"Taken as 00:00 of the day{of}: {found}" in told
        assert 'Due before they arrive: 2 orders: row 1 "7", row 2 "8"; they are late' in told
        assert (
            'Cancelled before they arrive: 2 orders: row 1 "7", row 2 "8"; they are cancelled as they arrive.' in told
        )
        assert "a time of arrival" not in told
    converted(tmp_path, "\n".join(("o,s,t", f"1,a,{days[0]}", f"2,a,{days[2]}")), "--force", *formats)
    found = f'2 rows with a time of arrival that is a date alone: row 1 "{days[0]}", row 2 "{days[2]}"; --time-of-day'
    assert f"Taken as 00:00 of the day: {found} names the column" in capsys.readouterr().out
    rows = [f"1,a,{days[0]},", f"2,a,{days[2]},"]
    converted(tmp_path, "\n".join(("o,s,t,clock", *rows)), "--time-of-day clock --force", *formats)
    assert f"Taken as 00:00 of the day: {found.partition(';')[0]}.\n" in capsys.readouterr().out


def test_a_table_whose_first_rows_alone_are_headers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As web shops export them; one table is then that of the headers, too."""
    text = "o,s,t,c\n1,a,06:00,07:00\n1,b,,\n1,c,,\n2,a,06:05,\n2,c,,\n"
    options = ["--cancelled", "c", "--time-format", "%H:%M", "--start", "06:00"]
    table = str(tmp_path / "lines.csv")
    assert refused(capsys, main, command(tmp_path, text, *options)).endswith(
        "row 2, row 3, row 5; where only the first row of an order has it, --orders with this table, too, gives it to "
        "the others; expected at most half, or --force\n"
    )
    (tmp_path / "headers.csv").write_text(text, encoding="utf-8")  # which is another table: each row is a header
    refusal = refused(capsys, main, command(tmp_path, text, *options, "--orders", str(tmp_path / "headers.csv")))
    assert "headers.csv: 3 of 5 rows would be left out: 3 rows with no time that can be read" in refusal
    kept = converted(tmp_path, text, *options, "--orders", table)
    assert kept == ["1,0,a,1,3600", "1,0,b,1,3600", "1,0,c,1,3600", "2,300,a,1,", "2,300,c,1,"]
    assert f"Read 2 headers of {table}, and 3 without any entry.\n" in capsys.readouterr().out


@pytest.mark.parametrize("of_heads", [False, True])
def test_orders_that_go_with_trucks(tmp_path: Path, capsys: pytest.CaptureFixture[str], of_heads: bool) -> None:
    text = "o,s,t,r\n1,a,06:00,south\n1,b,06:00,north\n2,a,06:05,\n3,a,06:06,south\n"
    options = "--route r --time-format %H:%M --pods 12 --skus-per-pod 1 --start 06:00"
    converted(tmp_path, text, options, *["--orders", str(tmp_path / "lines.csv")] * of_heads)
    assert 'with different routes: 1 order: row 1 "1"; the first by name is the order\'s.' in capsys.readouterr().out
    trucks = "instance.departures={times={north=['06:10'], south=['06:20']}, column='route'}"
    orders = rmfs_core.run(tmp_path / "out" / "scenario.toml", overrides=[trucks]).orders
    assert [(order["due_s"], order["route"]) for order in orders] == [(600, "north"), (None, ""), (1200, "south")]


def test_what_stock_cannot_serve_is_left_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By arrival: five a's are there, b never runs out, and nothing holds c. Orders left out take nothing."""
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\np,a,2\nq,a,3\nq,b,\n", encoding="utf-8")
    lines = "o,s,n,t\n3,a,2,9\n3,b,9,9\n1,a,3,1\n2,a,1,2\n2,c,4,2\n4,a,2,10\n5,a,1,11\n"
    options = f"--quantity n --out {tmp_path} --force"
    (tmp_path / "scenario.toml").write_text(scenario_of(2), encoding="utf-8")
    main(command(tmp_path, lines, options))
    assert refused(capsys, main, ["scenario", "check", str(tmp_path / "scenario.toml")]).endswith(
        "(`rmfs convert orders --in-stock` leaves out what stock cannot serve)\n"
    )
    own, other = "lack of stock", "another line of the order"
    for whole, kept, left in (
        ("", ["1,1,a,3", "2,2,a,1", "3,9,b,9", "5,11,a,1"], [f"2,c,4,{own}", f"3,a,2,{own}", f"4,a,2,{own}"]),
        (
            "--whole-orders",
            ["1,1,a,3", "3,9,a,2", "3,9,b,9"],
            [f"2,a,1,{other}", f"2,c,4,{own}", f"4,a,2,{own}", f"5,a,1,{own}"],
        ),
    ):
        capsys.readouterr()
        text = lines + "0,a,5,0\n0,d,x,0\n" * bool(whole)
        main(command(tmp_path, text, f"{options} {whole}", "--in-stock", str(tmp_path / "pods.csv")))
        assert (tmp_path / "orders.csv").read_text(encoding="utf-8").splitlines()[1:] == kept
        written = (tmp_path / "left-out.csv").read_text(encoding="utf-8")
        assert written.splitlines() == ["order,sku,quantity,reason", *left]
        told = capsys.readouterr().out
        assert f"Left out: {'2 orders' if whole else '1 order'} with no line that stock can serve.\n" in told
    assert "Left out for lack of stock: 3 lines of 3 orders, 7 items of 2 SKUs; " in told
    assert rmfs_core.run(tmp_path / "scenario.toml").status == "complete"


def test_several_formats_of_times(tmp_path: Path) -> None:
    formats = "--time-format iso --time-format %d.%m.%Y --time-format %m/%d/%Y"
    text = "o,s,t\n1,a,01.03.2024\n2,a,2024-03-01 06:00\n3,a,03/01/2024\n"
    assert converted(tmp_path, text, formats) == ["1,0,a,1", "3,0,a,1", "2,21600,a,1"]


def test_priorities_have_the_signs_of_quantities(tmp_path: Path) -> None:
    assert converted(tmp_path, "o,s,p\n1,a,1.000\n", "--priority p --thousands .") == ["1,0,a,1,1000"]


def test_orders_outside_a_span_are_left_out_whole(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = "o,s,t\nA,tea,4.999\nA,tea,6\nB,tea,5\nC,tea,7\nD,tea,8\n"
    assert converted(tmp_path, text, "--from 5 --until 8 --start 3") == ["B,2,tea,1", "C,4,tea,1"]
    told = capsys.readouterr()
    assert "Left out: 2 orders with a time outside the chosen span.\n" in told.out
    assert told.err == ""


@pytest.mark.parametrize("zone", ["", "--zone America/New_York"])
def test_opening_hours(tmp_path: Path, capsys: pytest.CaptureFixture[str], zone: str) -> None:
    """Nights are named by the local clock where orders come on two days; --open writes them, and the load counts."""
    rows = [f"{day}{hour},a,2024-03-0{day}T{hour:02}:00,{cancelled}" for day in (1, 2) for hour in range(6, 22)
            for cancelled in (f"2024-03-0{day}T23:00" if hour == 8 else "",)]  # fmt: skip
    given = (tmp_path, "\n".join(("o,s,t,c", *rows)), f"--cancelled c --pods 9 --skus-per-pod 1 --force {zone}")
    converted(*given)
    told = capsys.readouterr().out
    night = "though little is ordered from 22:00 to 06:00: --open 06:00-22:00 says when they are."
    assert f"Stations are open all day, {night}" in told
    assert "2 of the orders may be cancelled; " in told
    converted(*given, "--open", "06:00-14:00", "--open", "14:30-22:00")
    told = capsys.readouterr().out
    assert "little is ordered" not in told
    assert "in 31.0 h of 1" in told
    scenario = tomllib.loads((tmp_path / "out" / "scenario.toml").read_text(encoding="utf-8"))
    assert scenario["stations"]["open"] == [["06:00", "14:00"], ["14:30", "22:00"]]
    found = "--open: found '6-22'; expected two times of the day, such as 06:00-22:00"
    assert found in refused(capsys, main, command(*given, "--open", "6-22"))


@cases(
    "text options sentence",
    ("o,s\n1,a\n", "--sku ss", 'line 1: there is no column "ss" (did you mean `s`?); found o and s'),
    ("o,s\n", "", "has no order line that could be kept: it has no rows"),
    (
        "o,s\nA,\nB,\n,tea\n",
        "",
        'that could be kept: 2 rows with no SKU: row 1 "A", row 2 "B"; 1 row with no order: row 3\n',
    ),
    ("o,s,t\n1,a,5\n", "--start 9", "--start: found 9 s, but the first order arrives at 5 s"),
    (
        "o,s,t\n1,a,2024-07-01T06:00\n",
        "--start 2024-07-01T07:00",
        "--start: found 2024-07-01T07:00:00, but the first order arrives at 2024-07-01T06",
    ),
    ("o,s,d\n1,a,5\n", "--due d", "--due: found no --time; expected the column that the times are in"),
    (
        "o,s,t\n1,a,4\n2,a,9\n",
        "--from 5 --until 8",
        "--from, --until: all orders (2) are outside: from 4 s to 9 s; expected a span with",
    ),
    ("o,s\n1,a\n1,b\n1,c\n", "--pods 1 --skus-per-pod 2", "found 3 SKUs, and 1 pod for 2; expected --skus-per-pod 3"),
    *(
        ("o,s\n1,a\n", f"{option} 2024-03-01", f"{option}: found no --time; expected the column")
        for option in ("--from", "--until", "--start")
    ),
    (
        "o,s,t\n1,a,1709251200000000\n",
        "",
        "has no order in time: 1 row with a time more than ten years after time 0 (0 s; --from leaves out what is "
        'earlier): row 1 "1709251200000000 s"; expected another --start or --time-format',
    ),
    ("o,s\n1,a\n", "--history y.csv", "--history: found no --pods; expected both"),
    ("o,s\n1,a\n", "--order-key a", "--order-key: found no --orders; expected the table"),
    ("o,s\n1,a\n", "--only-orders s=a", "--only-orders: found no --orders; expected the table"),
    ("o,s\n1,a\n", "--only s", "--only: found 's'; expected a column and a value, such as status=open\n"),
    ("o,s\n1,a\n", "--only x=a", 'there is no column "x"; found o and s\n'),
    ("o,s\n1,ab\n", "--only s=AB", 'lines.csv has "AB" in the column "s" (did you mean `ab`?)\n'),
    ("o,s\n1,a\n2,b\n", "--only s=a --only o=2", 'be kept: 1 row with another o: row 1 "1", not read; 1 row with'),
    ("o,s\n1,a\n", "--decimal , --thousands ,", '--decimal, --thousands: found "," for both; expected two signs\n'),
    (
        "o,s\n1,FRACHT\n2,tea\n",
        "--leave-out-sku fracht",
        '--leave-out-sku: no row has the SKU "fracht" (did you mean `FRACHT`?); expected SKUs of the table\n',
    ),
    (
        "o,s,t,q\n,tea,1,1\nA,,1,1\nB,tea,1,0\nB,tea,1,-1\nB,tea,1,1.5\nB,tea,1,\n"
        "C,tea,noon,1\no,s,t,q\n, ,,\nD,a,1,1000001\n",
        "--quantity q",
        'that could be kept: 1 row with no order: row 1; 1 row with no SKU: row 2 "A"; '
        "4 rows with a quantity that is no whole number from 1 on (returns, weights): "
        'row 3 "0", row 4 "-1", row 5 "1.5"; 1 row with no time that can be read: row 7 "noon"; '
        '1 row with the header again: row 8; 1 row with more than 1,000,000 items in a line: row 10 "1000001"\n',
    ),
    *(
        (f'o,s,q\n1,a,"{text}"\n', f"--quantity q --decimal {sign}", f'(returns, weights): row 1 "{text}"{guess}\n')
        for sign, text, guess in ((".", "1,00", "; perhaps --decimal ,"), (".", "1,50", ""), (",", "x", ""))
    ),
    *(
        (
            f"o,s,t\n1,a,{first}\n2,a,{then}\n",
            "",
            f"lines.csv, row 2, t: found {found} where the rows before have {had}; ",
        )
        for first, then, found, had in (
            ("5", "2024-03-01", DATES, "seconds"),
            ("2024-03-01", "5", "seconds", DATES),
            ("2024-03-01T00:00Z", "2024-03-01", DATES, "dates with an offset"),
        )
    ),
    (
        "o,s,t,d\n1,a,2024-03-01,500\n",
        "--due d",
        f"lines.csv, row 1, d: found seconds where the rows before have {DATES}; expected one kind of time\n",
    ),
    (
        "o,s,t,d\n1,a,2024-03-01T06:00,20240302\n",
        "--due d",
        'numbers such as "20240302" may be dates as YYYYMMDD: --time-format %Y%m%d --time-format iso\n',
    ),
    ("o,s,q\n1,a,1.000\n", "--quantity q", 'lines.csv, row 1, q: found "1.000", which may be 1 or 1000; expected'),
    ('o,s,p\n1,a,"1,000"\n', "--priority p", 'lines.csv, row 1, p: found "1,000", which may be 1000 or 1; expected'),
    ("o,s,t\n1,a,20240229\n", "", 'lines.csv, t: found numbers such as "20240229" in row 1, which may be dates as'),
    (
        "o,s,t\n1,a,13.03.2024\n2,a,14.03.2024\n3,a,2024-03-15\n",
        "",
        "2 of 3 rows would be left out: 2 rows with no time that can be read: "
        'row 1 "13.03.2024", row 2 "14.03.2024"; '
        "perhaps --time-format %d.%m.%Y; expected at most half, or --force",
    ),
)
def test_what_is_wrong_is_said_in_a_sentence(tmp_path, capsys, text, options, sentence) -> None:
    assert sentence in refused(capsys, main, command(tmp_path, text, options))
    assert not (tmp_path / "out").exists()


@cases(
    "options content",
    *((f"--separator {tab}", b"o\ts\n1\tcaf\xc3\xa9\n") for tab in ("tab", "\\t")),
    ("--separator semicolon --encoding UTF8", b"o;s\n1;caf\xc3\xa9\n"),
    ("--separator | --encoding latin-1", b"o|s\n1|caf\xe9\n"),
)
def test_separators_and_encodings_have_names(tmp_path: Path, options: str, content: bytes) -> None:
    given = command(tmp_path, "", options)
    (tmp_path / "lines.csv").write_bytes(content)
    main(given)
    assert (tmp_path / "out" / "orders.csv").read_text("utf-8").splitlines()[1:] == ["1,0,caf\u00e9,1"]


@cases(
    "option text problem",
    *(
        ("--separator", text, f"found {text!r}; expected one sign of ASCII, such as ;, or one of comma, semicolon")
        for text in ("\u00e9", "::", "", '"', "\n", "a")
    ),
    *(
        ("--encoding", text, f"found {text!r}; expected utf-8, utf-16, cp1252 or the like")
        for text in ("foo", "rot13", "", "a\0b")
    ),
    ("--zone", "Europe/Berln", "there is no time zone 'Europe/Berln' (did you mean `Europe/Berlin`"),
    ("--zone", "America", "there is no time zone 'America'"),
    ("--time-format", "%H:%M %Z", "found %Z: names of zones are not the same everywhere"),
)
def test_an_option_that_is_wrong_is_refused(tmp_path, capsys, option, text, problem) -> None:
    told = refused(capsys, main, command(tmp_path, "o,s\n1,a\n", "", option, text))
    assert told.startswith(f"Error: {option}: {problem}")


def test_files_that_are_there_are_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "orders.csv").write_text("mine", encoding="utf-8")
    options = [*COLUMNS, "--out", str(tmp_path)]
    assert "--force replaces it" in refused(capsys, main, ["convert", "orders", str(table(tmp_path)), *options])
    told = refused(capsys, main, ["convert", "orders", str(tmp_path / "missing.csv"), *options])
    assert "missing.csv: cannot be read: No such file or directory" in told
    assert (tmp_path / "orders.csv").read_text(encoding="utf-8") == "mine"


def test_rows_are_loaded_in_batches_and_a_question_is_asked_at_once(tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.setattr(loading, "ROWS_PER_BATCH", 2)
    text = "o,s,q\nA,tea,1\nB,tea,0\nC,jam,2\nD,,1\nE,rye,3\n"
    assert converted(tmp_path, text, "--quantity q") == ["A,0,tea,1", "C,0,jam,2", "E,0,rye,3"]
    text = "o,s,q\nA,tea,1\nB,tea,1.000\nC,jam,2\nD,jam\n"
    told = refused(capsys, main, command(tmp_path, text, "--quantity q --force"))
    assert 'row 2, q: found "1.000", which may be 1 or 1000' in told


def test_rows_that_are_left_out_are_warned_of_from_a_tenth_on(tmp_path, capsys) -> None:
    """Rows that an option leaves out do not count."""
    for left in (1, 2):
        text = "o,s,q\n" + "1,a,1\n" * (9 - left) + "1,a,-1\n" * left + "1,b,1\n"
        converted(tmp_path, text, "--quantity q --leave-out-sku b --force")
        share = f"Warning: 20 % of the rows of {tmp_path}/lines.csv are left out (2 of 10).\n"
        assert capsys.readouterr().err == share * (left == 2)


def test_most_rows_are_left_out_only_by_force(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Half of them, or of the due times, is not most."""
    for half, kept in (
        ("o,s,t,d\n1,a,tomorrow,\n2,a,7,\n", ["2,7,a,1,"]),
        ("o,s,t,d\n1,a,5,9\n2,a,5,x\n", ["1,5,a,1,9", "2,5,a,1,"]),
    ):
        assert converted(tmp_path, half, "--due d") == kept
        shutil.rmtree(tmp_path / "out")
    text = "o,s,q\n" + "1,a,1\n" + "2,a,-1\n" * 2
    refused(capsys, main, command(tmp_path, text, "--quantity q"))
    assert not (tmp_path / "out").exists()
    assert converted(tmp_path, text, "--quantity q --force") == ["1,0,a,1"]
    assert "lines.csv are left out (2 of 3).\n" in capsys.readouterr().err
    rows = "o,s\n1,a\n2,caf\u00e9\n2,caf\u00e9\n"
    assert converted(tmp_path, rows, "--force --leave-out-sku cafe\u0301") == ["1,0,a,1"]
    told = capsys.readouterr()
    assert 'Left out: 2 rows with a SKU to leave out: row 2 "caf\u00e9", row 3 "caf\u00e9".' in told.out
    assert told.err == ""


def test_an_export_of_an_erp_system(tmp_path: Path) -> None:
    file = tmp_path / "Auftr\u00e4ge.csv"
    rows = [
        "Auftrag;Artikel;Menge;Erfa\u00dft;L\u00e4nge",
        '4711;"Schraube 3,5\r\nverzinkt";1.000,000;26.10.2024 23:30;1',
        "4711;B;2,000;26.10.2024 23:30;1",
        "4712;VERSAND;1,000;27.10.2024 06:00;1",
        "4712;B;3,000;27.10.2024 06:00;1",
    ]
    file.write_bytes("\r\n".join(rows).encode("cp1252"))
    columns = ["--order", "Auftrag", "--sku", "Artikel", "--quantity", "Menge", "--time", "Erfa\u00dft"]
    kind = ["--separator", ";", "--encoding", "cp1252", "--decimal", ",", "--time-format", "%d.%m.%Y %H:%M"]
    options = ["--zone", "Europe/Berlin", "--leave-out-sku", "VERSAND", "--pods", "2", "--out", str(tmp_path)]
    main(["convert", "orders", str(file), *columns, *kind, *options])
    assert (tmp_path / "orders.csv").read_text(encoding="utf-8").splitlines()[1:] == [
        '4711,84600,"Schraube 3,5 verzinkt",1000',
        "4711,84600,B,2",
        "4712,111600,B,3",  # 25 hours of that day
    ]
    assert 'start = "2024-10-26T00:00:00+02:00"' in (tmp_path / "scenario.toml").read_text(encoding="utf-8")


def test_a_history_of_another_layout_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    history, out = tmp_path / "history.csv", tmp_path / "out"
    history.write_text("Auftrag;Artikel\nH-1;tea\n", encoding="utf-8")
    options = (*COLUMNS, "--pods", "2", "--out", str(out), "--history")
    told = refused(capsys, main, ["convert", "orders", str(table(tmp_path)), *options, str(history)])
    assert told.startswith(f'Error: {history}, line 1: there is no column "Order No"; found semicolons')
    assert told.endswith("(--history is read with the columns, the separator and the encoding of the order lines)\n")
    assert not out.exists()


@cases(
    "time options start",
    ("2024-07-01T06:00+02:00", "", "2024-07-01T00:00:00+02:00"),
    ("2024-07-01T06:00+02:00", "--start 2024-07-01T05:30+02:00", "2024-07-01T05:30:00+02:00"),
    ("2024-07-01T06:00", "--start 2024-07-01T05:30", "2024-07-01T05:30:00"),
    ("21600", "", None),
    ("06:00", "--time-format %H:%M", None),
    ("06:00", "--time-format %H:%M --start 05:30", "2000-01-01T05:30:00"),
)
def test_time_zero_is_written_where_it_is_known(tmp_path, time, options, start) -> None:
    arrival_s = 1800 if "--start" in options else 21_600
    assert converted(tmp_path, f"o,s,t\n1,a,{time}\n", f"{ON_ONE_POD} {options}") == [f"1,{arrival_s},a,1"]
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"orders.csv", "pods.csv", "scenario.toml"}
    scenario = tomllib.loads((tmp_path / "out" / "scenario.toml").read_text(encoding="utf-8"))
    assert scenario["instance"].get("start") == start


@cases(
    "text sentences",
    ("o,s,q,s2,q2,\n1,a,1,b,2,\n", ["Columns that are not read: s2 and q2."]),
    (
        'o,s,q\n1,"[""tea"", ""mug""]",1\n',
        [r"""SKUs that look like lists: 1 row: row 1 "["tea", "mug"]"; each is taken"""],
    ),
    ("o,s,q\n1,tea;mug;mug,1\n2,tea | cup,x\n", ['lists: 2 rows: row 1 "tea;mug;mug", row 2 "tea | cup"; each is']),
    ('o,s,q\n1,"mug, red",1\n2,tea,1\n3,[x,1\n4,a|,1\n', []),
)
def test_what_is_no_line_of_its_own(tmp_path, capsys, text, sentences) -> None:
    converted(tmp_path, text, "--quantity q --force")
    told = capsys.readouterr().out
    assert [one for one in sentences if one not in told] == []
    assert ("SKUs that" in told, "Columns that" in told) == ("lists" in str(sentences), "Columns" in str(sentences))


def test_what_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = ["1,cafe\u0301,2024-07-01T06:00+02:00", "1,caf\u00e9,2024-07-01T06:00Z", ",,", "2,tea,noon"]
    converted(tmp_path, "\n".join(("o,s,t", *rows, "1,,2024-07-01T06:00Z")), ON_ONE_POD)
    told = capsys.readouterr()
    assert told.out.splitlines() == [
        "Read 4 rows, and 1 without any entry.",
        'Left out: 1 row with no time that can be read: row 4 "noon".',
        'Left out: 1 row with no SKU: row 5 "1".',
        "Left out: 1 order with no row that is kept.",
        "Shortened: 1 order lost a line (--whole-orders leaves them out).",
        "Names with accents apart from their letters (NFD): 1; they are spelled as one sign (NFC).",
        "SKUs that an order repeats: 1 row; quantities are added up.",
        'Lines with different times: 1 order: row 1 "1", up to 2.0 h apart; the earliest is the order\'s.',
        "Times with offsets from UTC of +00:00 and +02:00: hours of the day are by the clock of time 0 (--start).",
        "Largest lines: 2 of caf\u00e9 (order 1).",
        f"Wrote {tmp_path}/out/orders.csv: 1 order, 1 line, 2 items of 1 SKU; "
        "time 0 is 2024-07-01T00:00:00+02:00 (`instance.start`), the last order arrives 6.0 hours later.",
        f"Wrote {tmp_path}/out/pods.csv: 1 pod with 1 place.",
        f"Wrote {tmp_path}/out/scenario.toml; run it with: rmfs run {tmp_path}/out/scenario.toml",
        "Guessed 1 station and 4 robots that pick within 8 hours what arrives at once; robots are 4 for each station.",
        "Load of pickers: 26 s (2 items of 13 s), 26 s for each of 1.",
        told.out.splitlines()[-1],
    ]
    assert told.err == f"Warning: 50 % of the rows of {tmp_path}/lines.csv are left out (2 of 4).\n"


@cases(
    "items stations",
    ({6: 300, 16: 300}, 4),  # 80 % over all the time would be one station, but the peak hour wants three and more
    (dict.fromkeys(range(6, 18), 100), 1),
    ({6: 10**9, 16: 1}, 60),
)
def test_stations_and_robots_are_guessed_from_the_load(items: Mapping[int, int], stations: int) -> None:
    demand = Demand()
    for hour, number in items.items():
        demand.add(3_600_000 * hour, number, number, 1)
    size, found = size_for(100, demand)
    assert abs(size.stations - stations) <= 2
    assert sum(size.sides) == size.stations
    assert max(size.sides) <= (size.rows - 1) // 2
    assert 4 * size.stations <= size.robots <= size.locations // 2 or size.robots == size.locations // 2
    assert set(size.capped) == ({"stations", "robots"} if stations == 60 else set())
    assert all(wanted > getattr(size, what) for what, wanted in size.capped.items())
    if size.stations < 60:
        assert found[0].percent <= 80
        assert found[0].peak_percent <= 100


def test_orders_come_by_time_and_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = "o,s,t,q\nB,tea,9,1\nA,jam,5,2\nB,tea,7.5,3\nB,jam,9,1\nC,tea,5,1\n"
    rows = converted(tmp_path, text, "--quantity q --start 5")
    assert rows == ["A,0,jam,2", "C,0,tea,1", "B,2.5,tea,4", "B,2.5,jam,1"]
    assert "Largest lines: 4 of tea (order B), 2 of jam (order A)" in capsys.readouterr().out


def test_the_time_of_the_day_has_a_column_of_its_own(tmp_path: Path) -> None:
    text = "o,s,t,d\nA,tea,2024-03-01,06:10\nB,tea, 20240301 ,061500\nC,tea,2024-03-01,\n"
    assert converted(tmp_path, text, "--time-of-day d") == ["C,0,tea,1", "A,22200,tea,1", "B,22500,tea,1"]


def test_an_order_is_cancelled_with_the_last_of_its_lines(tmp_path: Path) -> None:
    """One of which a line is not stays, and none leaves before it came."""
    text = "o,s,t,c\nA,tea,10,12\nA,jam,10,15.5\nB,tea,11,12\nB,jam,11,\nC,tea,20,19\n"
    rows = converted(tmp_path, text, "--cancelled c")
    assert rows == ["A,10,tea,1,15.5", "A,10,jam,1,15.5", "B,11,tea,1,", "B,11,jam,1,", "C,20,tea,1,20"]


def test_an_order_that_loses_a_line_is_shortened(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kept = "A,tea,1,1\nB,tea,1,1\nD,rye,1,5\nD,rye,2,5\nD,jam,1,1\n"
    text = f"o,s,t,q\n{kept}A,jam,1,-1\nC,jam,1,-1\nC,jam,1,-2\n"
    options = "--quantity q --most-quantity 9"
    assert converted(tmp_path, text, options) == ["A,1,tea,1", "B,1,tea,1", "D,1,jam,1"]
    told = capsys.readouterr().out
    assert "Shortened: 2 orders lost a line" in told
    assert "Left out: 1 order with no row that is kept.\n" in told
    assert 'Left out: 1 row with more than 9 items in a line: row 3 "10".' in told
    assert converted(tmp_path, text, f"{options} --force --whole-orders") == ["B,1,tea,1"]
    told = capsys.readouterr().out
    assert "Shortened" not in told
    assert "Left out: 2 orders with a line that is left out (--whole-orders).\n" in told


def test_only_some_rows_are_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = "o,s,state,site\n1,tea,open,A\n1,mug,gone,A\n2,tea,new,B\n3,mug,new,A\n,,,\n4,jam,,A\n"
    assert converted(tmp_path, text, "--only state=open --only state=new --only site=A") == ["1,0,tea,1", "3,0,mug,1"]
    told = capsys.readouterr().out
    assert "Read 2 rows.\n" in told
    assert 'Not read: 2 rows with another state: row 2 "gone", row 6.\n' in told
    assert 'Not read: 1 row with another site: row 3 "B".\n' in told
    assert converted(tmp_path, text, "--only state= --whole-orders --force") == ["4,0,jam,1"]
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
    headers = tmp_path / "headers.csv"
    headers.write_text("o,t,state\n1,5,held\n2,6,free\n3,7,held\n4,8,held\n", encoding="utf-8")
    options = f"--orders {headers} --time t --only-orders state=free"
    assert converted(tmp_path / "a", text, options) == ["2,6,tea,1"]
    assert f'Not read of {headers}: 3 rows with another state: row 1 "held"' in capsys.readouterr().out
    told = refused(capsys, main, command(tmp_path / "b", text + "x,a,,\n" * 9, options))
    assert "9 of 14 rows would be left out: 4 rows with a header that is not read: row 1" in told


def test_what_is_left_out_of_orders(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = "o,s,q\nA,tea,1\nA,post,1\nB,post,1\nC,tea,1\nC,post,1\nC,jam,0\n"
    options = "--quantity q --leave-out-sku post"
    assert converted(tmp_path, text, options) == ["A,0,tea,1", "C,0,tea,1"]
    told = capsys.readouterr().out
    assert "Shortened: 1 order lost a line" in told
    assert "Left out: 1 order with no row that is kept.\n" in told
    assert converted(tmp_path, text, f"{options} --force --whole-orders") == ["A,0,tea,1"]
    rows = "A,tea,2024-03-01,600000\nA,tea,2024-03-01,600000\nB,tea,2024-03-02,1\nC,tea,2034-04-01,1\n"
    assert converted(tmp_path, f"o,s,t,q\n{rows}", "--quantity q --force") == ["B,0,tea,1"]
    told = capsys.readouterr().out
    assert 'Left out: 1 row with more than 1,000,000 items in a line: row 1 "1,200,000".' in told
    late = "more than ten years after time 0 (2024-03-02T00:00:00; --from leaves out what is earlier)"
    assert f'Left out: 1 row with a time {late}: row 4 "2034-04-01T00:00:00".' in told
    assert "Left out: 2 orders with no row that is kept.\n" in told


def test_what_cannot_be_read_is_left_empty(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = "o,s,t,d,p\nA,tea,5,soon,-1\nA,tea,5,9,10000000000\n"
    assert converted(tmp_path, text, "--due d --priority p --force") == ["A,5,tea,2,9,"]
    told = capsys.readouterr().out
    assert 'Left empty: 1 row with a due time that cannot be read: row 1 "soon".\n' in told
    part = "Left empty: 2 rows with a priority that is no whole number from 0 on"
    assert f'{part}: row 1 "-1", row 2 "10000000000".\n' in told
    assert "Left out" not in told
    converted(tmp_path, "o,s,t,d\nA,tea,2024-03-01,13.03.2024\n", "--due d --force")
    told = capsys.readouterr().out
    assert 'row 1 "13.03.2024"; perhaps --time-format iso and also --time-format %d.%m.%Y.\n' in told
    text = "o,s,t,d\nA,tea,2024-03-01,9999-12-31\nA,tea,1900-01-01,\n"
    assert converted(tmp_path, text, "--due d --force") == ["A,0,tea,1,"]
    told, stands = capsys.readouterr().out, "time that stands for none (before 1971 or after 2099)"
    assert f'Left empty: 1 row with a due {stands}: row 1 "9999-12-31".\n' in told
    assert f'Left out: 1 row with a {stands}: row 2 "1900-01-01".\n' in told


def test_skus_by_their_lines_and_orders_by_arrival(tmp_path: Path) -> None:
    file = table(tmp_path, "o,s,t,q\nB,tea,9,1\nB,rye,9,1\nA,jam,5,20\nB,tea,9,3\nC,tea,9,1\n")
    with OrderLines(Cleaner(Columns("o", "s", "t", "q"), Reader(), Choice())) as lines:
        lines.read(Table(file))
        lines.gather()
        assert lines.skus() == [Sku("tea", 2, 5), Sku("jam", 1, 20), Sku("rye", 1, 1)]
        assert list(lines.baskets(9)) == [["jam"], ["tea", "rye"], ["tea"]]
        assert list(lines.baskets(2)) == [["jam"], ["tea", "rye"]]


HEADS = """\
Document;Created;Promised;Urgency
7;01.03.2024 06:10;01.03.2024 08:00;1
8;01.03.2024 06:05;;
8;01.03.2024 06:20;01.03.2024 09:00;2
9;01.03.2024 07:00;;
10;yesterday;;
;01.03.2024 07:00;;
"""
SOME_LINES = """\
Order;Article;Qty
7;tea;1,000
8;mug;2,000
7;spoon;1,000
10;tea;1,000
11;tea;1,000
"""
ALL_COLUMNS = ("--order", "Order", "--sku", "Article", "--quantity", "Qty", "--decimal", ",", "--separator", ";")
OF_HEADS = ("--order-key", "Document", "--time", "Created", "--due", "Promised", "--priority", "Urgency")
FORMAT = ("--time-format", "%d.%m.%Y %H:%M")


def convert(folder: Path, *options: str, heads: str = HEADS, lines: str = SOME_LINES) -> None:
    (folder / "heads.csv").write_text(heads, encoding="utf-8")
    (folder / "lines.csv").write_text(lines, encoding="utf-8")
    tables = [str(folder / "lines.csv"), "--orders", str(folder / "heads.csv")]
    main(["convert", "orders", *tables, *ALL_COLUMNS, *FORMAT, "--out", str(folder / "out"), *options])


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
    assert (
        'Headers with different times: 1 order: row 2 "8", up to 15 min apart; the earliest is the order\'s.\n' in told
    )


def test_an_order_is_left_out_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    convert(tmp_path, *OF_HEADS, lines=SOME_LINES + "11;mug;-1,000\n12;mug;-1,000\n7;mug;1,000\n")
    told = capsys.readouterr().out
    assert f"Left out: 2 rows with no header in {tmp_path / 'heads.csv'} that is kept: row 4" in told
    assert "Left out: 3 orders with no row that is kept.\n" in told


@cases(
    "changed options sentence",
    (
        {"lines": SOME_LINES.replace("\n", "\n0")[:-1]},
        OF_HEADS,
        'no order of {lines} has a header: found orders "07" and "08" there, and "7", "8" and "9" here',
    ),
    ({"heads": "Document;Created\n"}, OF_HEADS[:4], "heads.csv: has no header of an order that could be kept"),
    ({}, OF_HEADS[2:], 'heads.csv, line 1: there is no column "Order"'),
    ({}, (*OF_HEADS[:2], "--time", "Made"), 'heads.csv, line 1: there is no column "Made"'),
    (
        {"lines": SOME_LINES + "12;tea;1,000\n13;tea;1,000\n"},
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
