"""`rmfs convert orders`: from a table of order lines to files that a scenario runs on."""

import gzip
import tomllib
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet
import pytest

import rmfs_core
from calling import refused
from cases import cases
from rmfs_commands.cli.main import main
from rmfs_commands.convert.cleaning import Choice, Cleaner, Columns, Reader
from rmfs_commands.convert.history import Learned
from rmfs_commands.convert.lines import OrderLines, Span
from rmfs_commands.convert.scenarios import scenario_of
from rmfs_commands.convert.tables import Table
from rmfs_commands.convert.times import Clock
from rmfs_commands.convert.writing import Stock, write

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


def test_lines_are_brought_together_by_order(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["convert", "orders", str(table(tmp_path)), *COLUMNS, "--out", str(tmp_path / "out")])
    assert (tmp_path / "out" / "orders.csv").read_text(encoding="utf-8") == ORDERS
    said = capsys.readouterr().out
    assert "Read 9 rows." in said
    assert 'Left out: 1 row with a quantity that is no whole number from 1 on (returns, weights): row 5 "-1".' in said
    assert 'Left out: 1 row with no SKU: row 6 "A-9".' in said
    assert "Left out: 1 row with no order: row 7." in said
    assert 'Left out: 1 row with no time that can be read: row 8 "yesterday".' in said
    assert "SKUs that an order repeats: 1 row; quantities are added up." in said
    assert "Lines with different times: 1 order; the earliest is the order's." in said
    assert "3 orders, 4 lines, 7 items of 4 SKUs; time 0 is 2024-03-01T00:00:00 (`instance.start`)" in said


def test_compressed_and_parquet_tables_give_the_same(tmp_path: Path) -> None:
    packed = tmp_path / "lines.csv.gz"
    packed.write_bytes(gzip.compress(LINES.encode()))
    main(["convert", "orders", str(packed), *COLUMNS, "--out", str(tmp_path / "gz")])
    rows = [("A-8", "mug, red", 2.0, 21_930_000), ("A-7", "tea", 3.0, 22_200_000), ("A-7", "spoon", 1.0, 22_200_000)]
    rows.append(("A-11", "lamp", 1.0, 86_399_500))
    names, skus, quantities, times = zip(*rows, strict=True)
    since = pa.array([1_709_251_200_000 + time for time in times], pa.timestamp("ms"))
    columns = {"Order No": names, "Article": skus, "Qty": quantities, "Created": since}
    pyarrow.parquet.write_table(pa.table(columns), tmp_path / "lines.parquet")
    main(["convert", "orders", str(tmp_path / "lines.parquet"), *COLUMNS, "--out", str(tmp_path / "parquet")])
    for folder in ("gz", "parquet"):
        assert (tmp_path / folder / "orders.csv").read_text(encoding="utf-8") == ORDERS


@pytest.mark.parametrize("placement", ["random", "popularity", "co-purchase"])
def test_what_is_written_runs(tmp_path: Path, placement: str) -> None:
    options = f"--pods 12 --skus-per-pod 2 --items 1 --placement {placement} --start 2024-03-01T06:00".split()
    main(["convert", "orders", str(table(tmp_path)), *COLUMNS, "--out", str(tmp_path / "out"), *options])
    result = rmfs_core.run(tmp_path / "out" / "scenario.toml")
    assert (result.status, result.metrics["picks"]) == ("complete", 7)


def test_orders_that_are_due(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = table(tmp_path, "o,s,t,d,p\n1,a,06:00,06:01,2\n1,b,06:00,06:02,\n2,a,06:05,noon,\n3,a,06:06,05:00,\n")
    options = ["--order", "o", "--sku", "s", "--time", "t", "--due", "d", "--priority", "p", "--time-format", "%H:%M"]
    options += ["--pods", "12", "--skus-per-pod", "1", "--start", "06:00", "--out", str(tmp_path)]
    main(["convert", "orders", str(file), *options])
    told = capsys.readouterr().out
    assert 'Left empty: 1 row with a due time that cannot be read: row 3 "noon".' in told
    assert "Lines with different due times: 1 order; the earliest is the order's." in told
    assert "Due before time 0: 1 order; 0 is written." in told
    orders = rmfs_core.run(tmp_path / "scenario.toml").orders
    assert [(order["due_s"], order["priority"]) for order in orders] == [(60.0, 2), (None, 0), (0.0, 0)]


@pytest.mark.parametrize("of_heads", [False, True])
def test_orders_that_go_with_trucks(tmp_path: Path, capsys: pytest.CaptureFixture[str], of_heads: bool) -> None:
    file = table(tmp_path, "o,s,t,r\n1,a,06:00,south\n1,b,06:00,north\n2,a,06:05,\n3,a,06:06,south\n")
    options = ["--order", "o", "--sku", "s", "--time", "t", "--route", "r", "--time-format", "%H:%M"]
    options += ["--orders", str(file)] * of_heads
    options += ["--pods", "12", "--skus-per-pod", "1", "--start", "06:00", "--out", str(tmp_path)]
    main(["convert", "orders", str(file), *options])
    assert "with different routes: 1 order; the first by name is the order's." in capsys.readouterr().out
    trucks = "instance.departures={times={north=['06:10'], south=['06:20']}, column='route'}"
    orders = rmfs_core.run(tmp_path / "scenario.toml", overrides=[trucks]).orders
    assert [(order["due_s"], order["route"]) for order in orders] == [(600, "north"), (None, ""), (1200, "south")]


def test_what_stock_cannot_serve_is_left_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By arrival: five a's are there, b never runs out, and nothing holds c. Orders left out take nothing."""
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\np,a,2\nq,a,3\nq,b,\n", encoding="utf-8")
    file = table(tmp_path, "o,s,n,t\n3,a,2,9\n3,b,9,9\n1,a,3,1\n2,a,1,2\n2,c,4,2\n4,a,2,10\n5,a,1,11\n")
    options = f"--order o --sku s --quantity n --time t --out {tmp_path}".split()
    (tmp_path / "scenario.toml").write_text(scenario_of(2), encoding="utf-8")
    main(["convert", "orders", str(file), *options])
    assert refused(capsys, main, ["scenario", "check", str(tmp_path / "scenario.toml")]).endswith(
        "(`rmfs convert orders --in-stock` leaves out what stock cannot serve)\n"
    )
    own, other = "lack of stock", "another line of the order"
    for whole, kept, left in (
        ([], ["1,1,a,3", "2,2,a,1", "3,9,b,9", "5,11,a,1"], [f"2,c,4,{own}", f"3,a,2,{own}", f"4,a,2,{own}"]),
        (
            ["--whole-orders"],
            ["1,1,a,3", "3,9,a,2", "3,9,b,9"],
            [f"2,a,1,{other}", f"2,c,4,{own}", f"4,a,2,{own}", f"5,a,1,{own}"],
        ),
    ):
        capsys.readouterr()
        main(["convert", "orders", str(file), *options, "--force", "--in-stock", str(tmp_path / "pods.csv"), *whole])
        assert (tmp_path / "orders.csv").read_text(encoding="utf-8").splitlines()[1:] == kept
        written = (tmp_path / "left-out.csv").read_text(encoding="utf-8")
        assert written.splitlines() == ["order,sku,quantity,reason", *left]
    assert "Left out for lack of stock: 3 lines of 3 orders, 7 items of 2 SKUs; " in capsys.readouterr().out
    assert rmfs_core.run(tmp_path / "scenario.toml").status == "complete"


def test_several_formats_of_times(tmp_path: Path) -> None:
    file = table(tmp_path, "o,s,t\n1,a,01.03.2024\n2,a,2024-03-01 06:00\n3,a,03/01/2024\n")
    formats = [text for pattern in ("%Y-%m-%d %H:%M", "%d.%m.%Y", "%m/%d/%Y") for text in ("--time-format", pattern)]
    main(["convert", "orders", str(file), *f"--order o --sku s --time t --out {tmp_path}".split(), *formats])
    written = (tmp_path / "orders.csv").read_text(encoding="utf-8")
    assert written.splitlines()[1:] == ["1,0,a,1", "3,0,a,1", "2,21600,a,1"]


@pytest.mark.parametrize("zone", ["", "--zone America/New_York"])
def test_opening_hours(tmp_path: Path, capsys: pytest.CaptureFixture[str], zone: str) -> None:
    """Nights are named by the local clock where orders come on two days; --open writes them, and the load counts."""
    rows = [f"{day}{hour},a,2024-03-0{day}T{hour:02}:00,{cancelled}" for day in (1, 2) for hour in range(6, 22)
            for cancelled in (f"2024-03-0{day}T23:00" if hour == 8 else "",)]  # fmt: skip
    file = table(tmp_path, "\n".join(("o,s,t,c", *rows)))
    options = f"--order o --sku s --time t --cancelled c --pods 9 --skus-per-pod 1 --out {tmp_path} {zone}".split()
    main(["convert", "orders", str(file), *options])
    told = capsys.readouterr().out
    night = "though little is ordered from 22:00 to 06:00: --open 06:00-22:00 says when they are."
    assert f"Stations are open all day, {night}" in told
    assert "2 of the orders may be cancelled; " in told
    main(["convert", "orders", str(file), *options, "--force", "--open", "06:00-14:00", "--open", "14:30-22:00"])
    told = capsys.readouterr().out
    assert "little is ordered" not in told
    assert "in 31.0 h of 1" in told
    scenario = tomllib.loads((tmp_path / "scenario.toml").read_text(encoding="utf-8"))
    assert scenario["stations"]["open"] == [["06:00", "14:00"], ["14:30", "22:00"]]
    found = "--open: found '6-22'; expected two times of the day, such as 06:00-22:00"
    assert found in refused(capsys, main, ["convert", "orders", str(file), *options, "--force", "--open", "6-22"])


def test_a_span_of_time(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    span = ["--from", "2024-03-01T06:06", "--until", "2024-03-01T12:00", "--start", "2024-03-01T06:00"]
    main(["convert", "orders", str(table(tmp_path)), *COLUMNS, "--out", str(tmp_path), *span])
    written = (tmp_path / "orders.csv").read_text(encoding="utf-8")
    assert written.splitlines()[1:] == ["A-7,600,tea,3", "A-7,600,spoon,1"]
    assert "Left out: 2 orders with a time outside the chosen span." in capsys.readouterr().out


@cases(
    "text options written",
    ("o;s\n1;a\n1;b\n2;a\n", ["--separator", ";"], "order,arrival_s,sku,quantity\n1,0,a,1\n1,0,b,1\n2,0,a,1\n"),
    (
        "o,s,p\n1,a,1.000\n",
        ["--priority", "p", "--thousands", "."],  # priorities have the signs of quantities
        "order,arrival_s,sku,quantity,priority\n1,0,a,1,1000\n",
    ),
)
def test_the_least_that_is_needed(tmp_path: Path, text: str, options: list[str], written: str) -> None:
    main(
        [
            "convert",
            "orders",
            str(table(tmp_path, text)),
            "--order",
            "o",
            "--sku",
            "s",
            *options,
            "--out",
            str(tmp_path),
        ]
    )
    assert (tmp_path / "orders.csv").read_text(encoding="utf-8") == written


@cases(
    "text options sentence",
    ("o,s\n1,a\n", ["--sku", "ss"], 'line 1: there is no column "ss" (did you mean `s`?); found o and s'),
    ("o,s\n", [], "has no order line that could be kept: it has no rows"),
    ("o,s\n1,\n", [], "has no order line that could be kept: 1 row with no SKU"),
    ("o,s,t\n1,a,5\n", ["--time", "t", "--start", "9"], "--start: found 9 s, but the first order arrives at 5 s"),
    ("o,s,d\n1,a,5\n", ["--due", "d"], "--due: found no --time; expected the column that the times are in"),
    ("o,s,t\n1,a,5\n", ["--time", "t", "--from", "9"], "--from, --until: all orders (1) are outside"),
    ("o,s\n1,a\n1,b\n1,c\n", ["--pods", "1", "--skus-per-pod", "2"], "2 places for 3 SKUs; expected --skus-per-pod 3"),
    *(
        ("o,s\n1,a\n", [option, "2024-03-01"], f"{option}: found no --time; expected the column")
        for option in ("--from", "--until", "--start")
    ),
    (
        "o,s,t\n1,a,1709251200000000\n",
        ["--time", "t"],
        "has no order in time: 1 row with a time more than ten years after time 0 (0 s; --from leaves out what is "
        'earlier): row 1 "1709251200000000 s"; expected another --start or --time-format',
    ),
    ("o,s\n1,a\n", ["--leave-out-sku", "b"], '--leave-out-sku: no row has the SKU "b"'),
    (
        "o,s,t\n1,a,13.03.2024\n2,a,14.03.2024\n3,a,2024-03-15\n",
        ["--time", "t"],
        "2 of 3 rows would be left out: 2 rows with no time that can be read: "
        'row 1 "13.03.2024", row 2 "14.03.2024"; '
        "perhaps --time-format %d.%m.%Y; expected at most half, or --force",
    ),
)
def test_what_is_wrong_is_said_in_a_sentence(tmp_path, capsys, text, options, sentence) -> None:
    columns = ["--order", "o", *(() if "--sku" in options else ("--sku", "s"))]
    command = ["convert", "orders", str(table(tmp_path, text)), *columns, *options, "--out", str(tmp_path / "out")]
    assert sentence in refused(capsys, main, command)
    assert not (tmp_path / "out").exists()


def test_files_that_are_there_are_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "orders.csv").write_text("mine", encoding="utf-8")
    command = ["convert", "orders", str(table(tmp_path)), *COLUMNS, "--out", str(tmp_path)]
    assert "--force replaces it" in refused(capsys, main, command)
    command[2] = str(tmp_path / "missing.csv")
    assert "missing.csv: cannot be read: No such file or directory" in refused(capsys, main, command)
    assert (tmp_path / "orders.csv").read_text(encoding="utf-8") == "mine"


def test_most_rows_are_left_out_only_by_force(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = table(tmp_path, "o,s,q\n" + "1,a,1\n" + "2,a,-1\n" * 2)
    command = ["convert", "orders", str(file), "--order", "o", "--sku", "s", "--quantity", "q", "--out", str(tmp_path)]
    refused(capsys, main, command)
    assert not (tmp_path / "orders.csv").exists()
    main([*command, "--force"])
    assert "lines.csv are left out (2 of 3).\n" in capsys.readouterr().err
    table(tmp_path, "o,s,q\n" + "1,a,1\n" + "2,b,1\n" * 2)
    main([*command, "--force", "--leave-out-sku", "b"])
    told = capsys.readouterr()
    assert 'Left out: 2 rows with a SKU to leave out: row 2 "b", row 3 "b".' in told.out
    assert told.err == ""


def test_an_order_of_the_opening_hour_is_served_at_once(tmp_path: Path) -> None:
    file = table(tmp_path, "order,sku,qty,ts\n1,A,1,2024-07-01T06:00:00+02:00\n2,B,2,2024-07-01T21:59:00+02:00\n")
    columns = ["--order", "order", "--sku", "sku", "--quantity", "qty", "--time", "ts", "--pods", "3"]
    for number, start in enumerate(([], ["--start", "2024-07-01T05:00+02:00"])):
        folder = tmp_path / str(number)
        main(["convert", "orders", str(file), *columns, "--skus-per-pod", "2", "--out", str(folder), *start])
        overrides = ['stations.open=[["06:00", "22:00"]]', "layout.stations_east=1"]
        first, last = rmfs_core.run(folder / "scenario.toml", overrides=overrides).orders
        assert first["arrival_s"] == (3600 if start else 21_600)
        assert first["turnover_s"] < 120
        assert last["turnover_s"] < 120


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


def test_names_with_commas_and_quotes_are_quoted(tmp_path: Path) -> None:
    converted(tmp_path, '1,"a, ""b""",5')
    assert (tmp_path / "out" / "pods.csv").read_text(encoding="utf-8") == 'pod,sku,quantity\nP1,"a, ""b""",5\n'
    assert '1,5,"a, ""b""",1\n' in (tmp_path / "out" / "orders.csv").read_text(encoding="utf-8")


def converted(folder: Path, *rows: str, pattern: str | None = None, start: str | None = None) -> list[str]:
    """Write what rows are (order, SKU, time) and return the names of the files."""
    file = folder / "lines.csv"
    file.write_text("o,s,t\n" + "".join(f"{row}\n" for row in rows), encoding="utf-8")
    reader = Reader(Clock(pattern and [pattern]))
    with OrderLines(Cleaner(Columns("o", "s", "t"), reader, Choice())) as lines:
        lines.read(Table(file))
        zero = lines.gather(Span(start=None if start is None else reader.clock.option("--start", start)))
        skus = lines.skus()
        stock = Stock(skus, [[*range(len(skus))]], 5, Learned("random", None))
        (folder / "out").mkdir()
        write(lines, folder / "out", zero, stock)
    return sorted(path.name for path in (folder / "out").iterdir())


@cases(
    "time pattern given start",
    ("2024-07-01T06:00+02:00", None, None, "2024-07-01T00:00:00+02:00"),
    ("2024-07-01T06:00", None, "2024-07-01T05:30", "2024-07-01T05:30:00"),
    ("21600", None, None, None),
    ("06:00", "%H:%M", None, None),
    ("06:00", "%H:%M", "05:30", "2000-01-01T05:30:00"),
)
def test_time_zero_is_written_where_it_is_known(tmp_path, time, pattern, given, start) -> None:
    names = converted(tmp_path, f"1,a,{time}", pattern=pattern, start=given)
    assert names == ["orders.csv", "pods.csv", "scenario.toml"]
    scenario = tomllib.loads((tmp_path / "out" / "scenario.toml").read_text(encoding="utf-8"))
    assert scenario["instance"].get("start") == start
    arrival = 1800 if given else 21_600
    assert (tmp_path / "out" / "orders.csv").read_text(encoding="utf-8").splitlines()[1] == f"1,{arrival},a,1"


def test_what_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [
        "1,cafe\u0301,2024-07-01T06:00+02:00",
        "1,caf\u00e9,2024-07-01T06:00Z",
        ",,",
        "2,tea,noon",
        "1,,2024-07-01T06:00Z",
    ]
    converted(tmp_path, *rows)
    told = capsys.readouterr()
    assert told.out.splitlines() == [
        "Read 4 rows, and 1 without any entry.",
        'Left out: 1 row with no time that can be read: row 4 "noon".',
        'Left out: 1 row with no SKU: row 5 "1".',
        "Left out: 1 order with no row that is kept.",
        "Shortened: 1 order lost a line (--whole-orders leaves them out).",
        "Names with accents apart from their letters (NFD): 1; they are spelled as one sign (NFC).",
        "SKUs that an order repeats: 1 row; quantities are added up.",
        "Lines with different times: 1 order; the earliest is the order's.",
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


@pytest.mark.parametrize("pods", [1, 100, 5000])
def test_a_scenario_has_room_for_the_pods(pods: int) -> None:
    scenario = tomllib.loads(scenario_of(pods))
    assert 8 * scenario["layout"]["block_rows"] * scenario["layout"]["block_columns"] > pods
    assert "start" not in scenario["instance"]
