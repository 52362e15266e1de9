"""CSV of any encoding, with line ends within quotes, and the errors for files of another kind."""

from __future__ import annotations

import csv
import gzip
from pathlib import Path

import pytest

from rmfs_commands.convert.csv_tables import csv_rows
from rmfs_core.errors import InputError


def rows(folder: Path, content: bytes, *columns: str, separator: str = ",", encoding: str = "utf-8") -> list[object]:
    """Return the rows of a file with this content."""
    file = folder / "t.csv"
    file.write_bytes(content)
    return [tuple(row) for row in csv_rows(file, columns or ("o", "s"), separator, encoding)]


def test_texts_stay_as_they_are(tmp_path: Path) -> None:
    """Names of digits keep their zeros, quoted fields their signs; columns come as asked for, also twice."""
    content = b'o,s,q\r\n007,"x, ""y""",1.0\r\n\r\nB,,\r\n'
    assert rows(tmp_path, content, "q", "o", "s", "o") == [("1.0", "007", 'x, "y"', "007"), ("", "B", "", "B")]


def test_line_ends_within_quotes(tmp_path: Path) -> None:
    """In a file of any size: more than a block of any reader."""
    file = tmp_path / "t.csv"
    with file.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["o", "note", "s"])
        writer.writerows([f"O{i}", f"ring\nleave at {i}" + "." * 60, f"S{i % 7}"] for i in range(40_000))
    found = list(csv_rows(file, ["o", None, "s"]))
    assert len(found) == 40_000
    assert found[-1] == ["O39999", "", "S1"]


@pytest.mark.parametrize(
    ("text", "encoding", "stored"),
    [
        ("o,s\n1,caf\u00e9\n", "utf-16", "utf-16"),
        ("o,s\n1,caf\u00e9\n", "cp1252", "cp1252"),
        ("o,s\n1,caf\u00e9\n", "utf-8", "utf-8-sig"),
        ("sep=,\no,s\n1,caf\u00e9\n", "utf-8", "utf-8"),
    ],
)
def test_encodings(tmp_path: Path, text: str, encoding: str, stored: str) -> None:
    """What a spreadsheet program writes: byte order marks, and a first line with the separator."""
    assert rows(tmp_path, text.encode(stored), encoding=encoding) == [("1", "caf\u00e9")]
    assert rows(tmp_path, gzip.compress(text.encode(stored)), encoding=encoding) == [("1", "caf\u00e9")]


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        # guesses: separators, encodings, both
        (b"o;s\n1;a\n", ', line 1: there is no column "o"; found semicolons: say --separator semicolon; found o;s'),
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
    ],
)
def test_what_is_no_such_table_is_refused(tmp_path: Path, content: bytes, problem: str) -> None:
    """One sentence with file, line or row, and what would be right."""
    with pytest.raises(InputError) as caught:
        rows(tmp_path, content)
    assert str(caught.value) == f"{tmp_path / 't.csv'}{problem}"


def test_another_encoding_than_said(tmp_path: Path) -> None:
    """Text without a byte order mark is no UTF-16."""
    with pytest.raises(InputError, match=r"t.csv: expected UTF-16 text, found other; found UTF-8 text: say --encoding"):
        rows(tmp_path, b"o,s\n1,a\n", encoding="utf-16")


def test_a_device_without_line_ends_is_refused() -> None:
    """It is not read on and on."""
    with pytest.raises(InputError, match=r"^/dev/zero, line 1: found a field of more than 131,072 characters"):
        list(csv_rows(Path("/dev/zero"), ["o"]))
