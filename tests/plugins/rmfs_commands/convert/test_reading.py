"""Tables of any kind, read row by row: CSV, Parquet, and the columns in them."""

import csv
import gzip
from datetime import UTC, date, datetime, time
from decimal import Decimal
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet
import pytest

from calling import refusal
from cases import cases
from rmfs_commands.convert import parquet_tables
from rmfs_commands.convert.csv_tables import csv_rows
from rmfs_commands.convert.headers import plain, positions
from rmfs_commands.convert.parquet_tables import parquet_rows
from rmfs_commands.convert.tables import Table
from rmfs_core.errors import InputError


def test_rows_are_read_in_batches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parquet_tables, "ROWS_PER_BATCH", 4)
    file = tmp_path / "lines.parquet"
    pyarrow.parquet.write_table(pa.table({"order": [str(i) for i in range(10)]}), file)
    assert list(Table(file).rows(["order", None])) == [(i, (str(i - 1), "")) for i in range(1, 11)]


def test_files_of_other_kinds(tmp_path: Path) -> None:
    pyarrow.parquet.write_table(pa.table({"o": [b"A1"]}), tmp_path / "one.dat")
    (tmp_path / "two.dat").write_bytes(gzip.compress(b"x;o\n1;A1\n"))
    for name in ("one.dat", "two.dat"):
        assert [(row, *fields) for row, fields in Table(tmp_path / name, ";").rows(["o"])] == [(1, "A1")]
    whole = tmp_path / "t.parquet"
    pyarrow.parquet.write_table(pa.table({"a": [1]}), whole)
    for content in (b"", b"o,s\n1,a\n", whole.read_bytes()[:-20]):
        whole.write_bytes(content)
        said = refusal(lambda: list(parquet_rows(whole, ["a"])))
        assert said == f"{whole}: cannot be read: it is no Parquet file, or not all of one"


@cases(
    "name problem",
    ("none.csv", "cannot be read: No such file or directory"),
    ("none.parquet", "cannot be read: No such file or directory"),
    (".", "cannot be read: Is a directory"),
    ("a\0b", "cannot be read: no file can have that name"),
    ("\udcff.csv", "cannot be read: No such file or directory"),
)
def test_a_file_that_is_not_there_is_refused(tmp_path: Path, name: str, problem: str) -> None:
    assert refusal(lambda: list(Table(tmp_path / name).rows(["o"]))) == f"{tmp_path / name}: {problem}"


def test_texts_of_files(tmp_path: Path) -> None:
    file = tmp_path / "lines.csv"
    file.write_text("order,sku\n1,a\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"there is no column .*; found order and sku$"):
        list(Table(file).rows(["sk\udcff"]))
    content = b'o,s,q\r\n007,"x, ""y""",1.0\r\n\r\nB,,\r\n'
    assert rows(tmp_path, content, "q", "o", "s", "o") == [("1.0", "007", 'x, "y"', "007"), ("", "B", "", "B")]
    file = tmp_path / "t.csv"
    with file.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["o", "note", "s"])
        writer.writerows([f"O{i}", f"ring\nleave at {i}" + "." * 60, f"S{i % 7}"] for i in range(40_000))
    found = list(csv_rows(file, ["o", None, "s"]))
    assert len(found) == 40_000
    assert found[-1] == ["O39999", "", "S1"]


def rows(folder: Path, content: bytes, *columns: str, separator: str = ",", encoding: str = "utf-8") -> list[object]:
    file = folder / "t.csv"
    file.write_bytes(content)
    return [tuple(row) for row in csv_rows(file, columns or ("o", "s"), separator, encoding)]


@cases(
    "text encoding stored",
    ("o,s\n1,caf\u00e9\n", "utf-16", "utf-16"),
    ("o,s\n1,caf\u00e9\n", "cp1252", "cp1252"),
    ("o,s\n1,caf\u00e9\n", "utf-8", "utf-8-sig"),
    ("sep=,\no,s\n1,caf\u00e9\n", "utf-8", "utf-8"),
)
def test_encodings(tmp_path: Path, text: str, encoding: str, stored: str) -> None:
    assert rows(tmp_path, text.encode(stored), encoding=encoding) == [("1", "caf\u00e9")]
    assert rows(tmp_path, gzip.compress(text.encode(stored)), encoding=encoding) == [("1", "caf\u00e9")]


@cases(
    "content problem",
    # guesses: separators, encodings, both
    (b"o;s\n1;a\n", ', line 1: there is no column "o"; found semicolons: say --separator semicolon; found o;s'),
    (
        b"Export\n\nof,May\no,s,t\n1,a,1\n",
        ', line 1: there is no column "o"; line 4 has it: leave out the lines above it; found Export',
    ),
    (b"o|x\n1|a\n", ', line 1: there is no column "o"; found bars: say --separator bar; found o|x'),
    (b"O\tS\n1\ta\n", ', line 1: there is no column "o"; found tabs: say --separator tab; found O\\tS'),
    (
        "o\ts\n1\tcaf\u00e9\n".encode("utf-16"),
        ": expected UTF-8 text, found the byte 0xff in line 1; found UTF-16 text and tabs: "
        "say --encoding utf-16 --separator tab",
    ),
    (
        "o,s\n1,a\n".encode("utf-16-le"),
        ', line 1: there is no column "o"; found UTF-16-LE text: say --encoding utf-16-le; '
        "found o\\x00 and \\x00s\\x00",
    ),
    (
        b"o,s\n1,a\n2,caf\xe9\n",
        ": expected UTF-8 text, found the byte 0xe9 in line 3; found CP1252 text: say --encoding cp1252",
    ),
    # other files
    (b"PK\x03\x04...", ": found a workbook or a zip archive; expected a table as CSV, .csv.gz or Parquet"),
    (gzip.compress(b"o,s\n1,a\n", mtime=0)[:20], ": cannot be read: its compressed data are damaged or cut off"),
    (b"\x1f\x8b", ": cannot be read: its compressed data are damaged or cut off"),
    (b"", ', line 1: there is no column "o"; found nothing'),
    # rows
    (b"o,s\n1,a\n2,b,c\n", ", row 2: expected 2 fields as in the header, found 3: '2,b,c'"),
    (b'o,s\n"1\n",a\n2\n', ", row 2: expected 2 fields as in the header, found 1: '2'"),
    (
        b'o,s\n1,a\n2,"b\n3,c\n',
        ", line 3: found a quote that is never closed; expected another at the end of the field",
    ),
    (b'o,s\n1,"a"b\n', ", line 2: found a quote within a field in quotes; expected it doubled"),
)
def test_what_is_no_such_table_is_refused(tmp_path: Path, content: bytes, problem: str) -> None:
    assert refusal(lambda: rows(tmp_path, content)) == f"{tmp_path / 't.csv'}{problem}"


def test_another_encoding_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"t.csv: expected UTF-16 text, found other; found UTF-8 text: say --encoding"):
        rows(tmp_path, b"o,s\n1,a\n", encoding="utf-16")
    assert texts(tmp_path, [b"caf\xe9"], "cp1252") == ["caf\u00e9"]
    with pytest.raises(InputError, match=r"t.parquet, row 2, a.b: expected utf-8 text, found the byte 0xe9$"):
        texts(tmp_path, [b"tea", b"caf\xe9"])


def test_a_device_without_line_ends_is_refused() -> None:
    with pytest.raises(InputError, match=r"^/dev/zero, line 1: found a field of more than 131,072 characters"):
        list(csv_rows(Path("/dev/zero"), ["o"]))


def texts(folder: Path, column: Any, encoding: str = "utf-8") -> list[str]:
    file = folder / "t.parquet"
    pyarrow.parquet.write_table(pa.table({"a.b": column}), file)
    return [text for (text,) in parquet_rows(file, ["a.b"], encoding)]


@cases(
    "column expected",
    ([2.0, 2.5, None, 1.234, 1e20], ["2", "2.5", "", "1.2340", "100000000000000000000"]),
    ([7, 8], ["7", "8"]),
    ([Decimal("1.000"), Decimal("1.250")], ["1", "1.2500"]),
    ([b"A1", None], ["A1", ""]),
    (pa.array([b"A1"], pa.large_binary()), ["A1"]),
    (pa.array(["x", "y", "x"]).dictionary_encode(), ["x", "y", "x"]),
    ([date(2024, 3, 1)], ["2024-03-01"]),
    ([time(6, 5)], ["06:05:00"]),
    ([datetime(2024, 3, 1, 6, 5)], ["2024-03-01T06:05:00"]),
    (pa.array([1_709_273_100_000_000_001], pa.timestamp("ns")), ["2024-03-01T06:05:00"]),
    (
        pa.array([datetime(2024, 7, 1, 6, tzinfo=UTC)], pa.timestamp("ms", "Europe/Berlin")),
        ["2024-07-01T08:00:00+02:00"],
    ),
    (pa.array([None, None], pa.null()), ["", ""]),
)
def test_values_are_texts(tmp_path: Path, column: Any, expected: list[str]) -> None:
    assert texts(tmp_path, column) == expected


@cases(
    "column problem",
    ([[1, 2]], "holds several values a row (list"),
    ([{"x": 1}], "holds several values a row (struct"),
    (pa.array([5], pa.duration("s")), "holds neither texts nor numbers nor times (duration[s]); expected one text"),
)
def test_other_columns_are_refused(tmp_path: Path, column: Any, problem: str) -> None:
    assert refusal(lambda: texts(tmp_path, column)).startswith(f"{tmp_path / 't.parquet'}, a.b: {problem}")


def test_names_of_columns(tmp_path: Path) -> None:
    file = tmp_path / "t.parquet"
    pyarrow.parquet.write_table(pa.Table.from_arrays([pa.array([1]), pa.array([2])], ["q", "q"]), file)
    with pytest.raises(InputError, match=r't.parquet: found the column "q" 2 times; expected each once$'):
        list(parquet_rows(file, ["q"]))
    assert positions([" Order ", "Me\u0301nge", "x"], ["M\u00e9nge", "Order", "Order"], "t") == [1, 0, 0]
    assert plain(" e\u0301 ") == "\u00e9"


@cases(
    "header column problem",
    (["Order", "Qty", "Qty"], "Qty", 'found the column "Qty" 2 times; expected each once'),
    (["Order", "Qty"], "Qtty", 'there is no column "Qtty" (did you mean `Qty`?); found Order and Qty'),
    ([], "Qty", 'there is no column "Qty"; found nothing'),
    ([f"c{i}" for i in range(40)], "Qty", 'there is no column "Qty"; found c0, c1, c2, c3, c4 and 35 more'),
)
def test_a_column_that_is_not_there_once_is_refused(header: list[str], column: str, problem: str) -> None:
    assert refusal(lambda: positions(header, [column], "lines.csv, line 1")) == f"lines.csv, line 1: {problem}"
