"""`rmfs convert orders`: from a table of order lines to files that a scenario runs on."""

from __future__ import annotations

import gzip
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet
import pytest

import rmfs_core
from rmfs_commands.cli.main import main

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
    """Write a table."""
    file = folder / "lines.csv"
    file.write_text(text, encoding="utf-8")
    return file


def test_lines_are_brought_together_by_order(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Orders by their earliest time after midnight, each SKU once; rows left out are counted by reason."""
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
    """A .csv.gz and a Parquet file with timestamps and numbers lead to the same orders."""
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
    """With --pods the folder has a scenario; every order of it is completed, whatever the stock asked for."""
    options = [
        "--pods",
        "12",
        "--skus-per-pod",
        "2",
        "--items",
        "1",
        "--placement",
        placement,
        "--start",
        "2024-03-01T06:00",
    ]
    main(["convert", "orders", str(table(tmp_path)), *COLUMNS, "--out", str(tmp_path / "out"), *options])
    result = rmfs_core.run(tmp_path / "out" / "scenario.toml")
    assert result.status == "complete"
    assert result.metrics["picks"] == 7


def test_orders_that_are_due(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What is written is read: a run says which orders were late, and what was left empty is said."""
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


def test_a_span_of_time(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Orders outside --from and --until are left out and counted; time 0 can be chosen."""
    span = ["--from", "2024-03-01T06:06", "--until", "2024-03-01T12:00", "--start", "2024-03-01T06:00"]
    main(["convert", "orders", str(table(tmp_path)), *COLUMNS, "--out", str(tmp_path), *span])
    assert (tmp_path / "orders.csv").read_text(encoding="utf-8").splitlines()[1:] == [
        "A-7,600,tea,3",
        "A-7,600,spoon,1",
    ]
    assert "Left out: 2 orders with a time outside the chosen span." in capsys.readouterr().out


def test_the_least_that_is_needed(tmp_path: Path) -> None:
    """Without time and quantity every row is one item of an order that is there from the start."""
    file = table(tmp_path, "o;s\n1;a\n1;b\n2;a\n")
    main(["convert", "orders", str(file), "--order", "o", "--sku", "s", "--separator", ";", "--out", str(tmp_path)])
    assert (tmp_path / "orders.csv").read_text(
        encoding="utf-8"
    ) == "order,arrival_s,sku,quantity\n1,0,a,1\n1,0,b,1\n2,0,a,1\n"


@pytest.mark.parametrize(
    ("text", "options", "sentence"),
    [
        ("o,s\n1,a\n", ["--sku", "ss"], 'line 1: there is no column "ss" (did you mean `s`?); found o and s'),
        ("o,s\n", [], "has no order line that could be kept: it has no rows"),
        ("o,s\n1,\n", [], "has no order line that could be kept: 1 row with no SKU"),
        ("o,s\n1,a,b\n", [], "row 1: expected 2 fields as in the header, found 3: '1,a,b'"),
        ("", [], 'line 1: there is no column "o"; found nothing'),
        ("o,s,s\n1,a,b\n", [], 'line 1: found the column "s" 2 times; expected each once'),
        ("o\ts\n1\ta\n", [], "found tabs: say --separator tab"),
        ("o,s,t\n1,a,5\n2,a,2024-01-01\n", ["--time", "t"], "row 2, t: found dates without an offset where"),
        ("o,s,t\n1,a,5\n", ["--time", "t", "--start", "9"], "--start: found 9 s, but the first order arrives at 5 s"),
        ("o,s,d\n1,a,5\n", ["--due", "d"], "--due: found no --time; expected the column that the times are in"),
        ("o,s\n1,a\n", ["--priority", "urgency"], 'there is no column "urgency"; found o and s'),
        (
            "o,s,t\n1,a,5\n",
            ["--time", "t", "--from", "noon"],
            '--from: found "noon"; expected a time such as 2024-03-01T06:00, or as --time-format has it',
        ),
        ("o,s,t\n1,a,5\n", ["--time", "t", "--from", "9"], "--from, --until: all orders (1) are outside"),
        (
            "o,s\n1,a\n1,b\n1,c\n",
            ["--pods", "1", "--skus-per-pod", "2"],
            "2 places for 3 SKUs; expected --skus-per-pod 3",
        ),
        (
            "o,s,t\n1,a,5\n",
            ["--time", "t", "--until", "2024-03-01"],
            '--until: found "2024-03-01", but the times of the table are seconds; expected one of that kind, such as',
        ),
        *(
            ("o,s\n1,a\n", [option, "2024-03-01"], f"{option}: found no --time; expected the column")
            for option in ("--from", "--until", "--start")
        ),
        ("o,s,t\n1,a,20240229\n", ["--time", "t"], 't: found numbers such as "20240229" in row 1, which may be dates'),
        ("o,s,q\n1,a,1.000\n", ["--quantity", "q"], 'row 1, q: found "1.000", which may be 1 or 1000; expected'),
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
        ("o,s\n1,a\n", ["--separator", "é"], "--separator: found 'é'; expected one sign of ASCII"),
        ("o,s\n1,a\n", ["--separator", "::"], "--separator: found '::'; expected one sign"),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, options: list[str], sentence: str
) -> None:
    """Exit code 2, no traceback, and nothing is written."""
    columns = ["--order", "o", *(() if "--sku" in options else ("--sku", "s"))]
    with pytest.raises(SystemExit) as stopped:
        main(["convert", "orders", str(table(tmp_path, text)), *columns, *options, "--out", str(tmp_path / "out")])
    assert stopped.value.code == 2
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_files_that_are_there_are_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without --force nothing is replaced."""
    (tmp_path / "orders.csv").write_text("mine", encoding="utf-8")
    with pytest.raises(SystemExit):
        main(["convert", "orders", str(table(tmp_path)), *COLUMNS, "--out", str(tmp_path)])
    assert "--force replaces it" in capsys.readouterr().err
    assert (tmp_path / "orders.csv").read_text(encoding="utf-8") == "mine"


def test_most_rows_are_left_out_only_by_force(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What options ask to leave out does not count; more than a tenth is a warning."""
    file = table(tmp_path, "o,s,q\n" + "1,a,1\n" + "2,a,-1\n" * 2)
    command = ["convert", "orders", str(file), "--order", "o", "--sku", "s", "--quantity", "q", "--out", str(tmp_path)]
    with pytest.raises(SystemExit) as stopped:
        main(command)
    assert stopped.value.code == 2
    assert not (tmp_path / "orders.csv").exists()
    main([*command, "--force"])
    assert "lines.csv are left out (2 of 3).\n" in capsys.readouterr().err
    table(tmp_path, "o,s,q\n" + "1,a,1\n" + "2,b,1\n" * 2)
    main([*command, "--force", "--leave-out-sku", "b"])
    told = capsys.readouterr()
    assert 'Left out: 2 rows with a SKU to leave out: row 2 "b", row 3 "b".' in told.out
    assert told.err == ""


def test_an_order_of_the_opening_hour_is_served_at_once(tmp_path: Path) -> None:
    """06:00+02:00 is 06:00 for stations that open then, with seconds from midnight or from another time 0."""
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
    """German headers, semicolons, decimal commas, another encoding, local times in a zone, postage as a line."""
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
    """The options are those of the order lines: the error says so, and nothing is written."""
    history, out = tmp_path / "history.csv", tmp_path / "out"
    history.write_text("Auftrag;Artikel\nH-1;tea\n", encoding="utf-8")
    options = (*COLUMNS, "--pods", "2", "--out", str(out), "--history")
    with pytest.raises(SystemExit, match="2"):
        main(["convert", "orders", str(table(tmp_path)), *options, str(history)])
    told = capsys.readouterr().err
    assert told.startswith(f'Error: {history}, line 1: there is no column "Order No"; found semicolons')
    assert told.endswith("(--history is read with the columns, the separator and the encoding of the order lines)\n")
    with pytest.raises(SystemExit, match="2"):
        main(["convert", "orders", str(table(tmp_path)), *options, str(tmp_path / "none.csv")])
    assert "none.csv: cannot be read: No such file or directory\n" in capsys.readouterr().err
    assert not out.exists()


def test_priorities_have_the_signs_of_quantities(tmp_path: Path) -> None:
    """What they mean is asked about, so an option has to answer."""
    (tmp_path / "lines.csv").write_text("o,s,p\n1,a,1.000\n", encoding="utf-8")
    columns = ["--order", "o", "--sku", "s", "--priority", "p", "--thousands", "."]
    main(["convert", "orders", str(tmp_path / "lines.csv"), *columns, "--out", str(tmp_path / "out")])
    assert (tmp_path / "out" / "orders.csv").read_text(encoding="utf-8").splitlines()[1] == "1,0,a,1,1000"
