"""Tables of order lines, in batches: CSV, compressed CSV, Parquet."""

from __future__ import annotations

import gzip
from datetime import date, datetime
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet
import pytest

from rmfs_convert import tables
from rmfs_convert.tables import batches
from rmfs_core.errors import InputError


def rows(file: Path, *columns: str, separator: str = ",") -> list[tuple[str | None, ...]]:
    """Return the rows of all batches."""
    return [row for batch in batches(file, columns, separator) for row in zip(*batch.columns, strict=True)]


def test_texts_stay_as_they_are(tmp_path: Path) -> None:
    """Names of digits keep their zeros, quoted fields their separators; columns come as asked for, also twice."""
    file = tmp_path / "lines.csv"
    file.write_text('sku,order,qty\n007,A,1.0\n"x, y",B,\n', encoding="utf-8")
    assert rows(file, "order", "sku", "order") == [("A", "007", "A"), ("B", "x, y", "B")]
    assert rows(file, "qty") == [("1.0",), ("",)]


def test_compressed_tables_are_read(tmp_path: Path) -> None:
    """And a separator may be another sign."""
    file = tmp_path / "lines.csv.gz"
    file.write_bytes(gzip.compress(b"order;sku\n1;a,b\n"))
    assert rows(file, "sku", separator=";") == [("a,b",)]


def test_values_of_parquet_are_texts(tmp_path: Path) -> None:
    """Whole numbers without a point, times as ISO 8601, nothing as None."""
    file = tmp_path / "lines.parquet"
    columns = {
        "qty": [2.0, 2.5, None],
        "sku": [7, 8, 9],
        "day": [date(2024, 3, 1), None, date(2024, 3, 2)],
        "time": [datetime(2024, 3, 1, 6, 5), None, None],
    }
    pyarrow.parquet.write_table(pa.table(columns), file)
    assert rows(file, "qty", "sku", "day", "time") == [
        ("2", "7", "2024-03-01", "2024-03-01T06:05:00"),
        ("2.5", "8", None, None),
        (None, "9", "2024-03-02", None),
    ]


def test_rows_are_counted_over_batches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The number of a batch's first row is that of the table, from 1."""
    monkeypatch.setattr(tables, "ROWS_PER_BATCH", 4)
    file = tmp_path / "lines.parquet"
    pyarrow.parquet.write_table(pa.table({"order": [str(i) for i in range(10)]}), file)
    found = list(batches(file, ["order"]))
    assert [batch.first_row for batch in found] == [1, 5, 9]
    assert [value for batch in found for value in batch.columns[0]] == [str(i) for i in range(10)]


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        (
            "lines.csv",
            b"order,skus\n1,a\n",
            'lines.csv, line 1: there is no column "sku" (did you mean `skus`?); found',
        ),
        ("lines.csv", b"order,sku\n1,a,b\n", "lines.csv: is no table that can be read: "),
        ("lines.csv", b"order,sku\n1,\xff\n", "lines.csv: is no table that can be read: "),
        ("lines.csv.gz", b"order,sku\n", "lines.csv.gz: "),
        ("lines.parquet", b"order,sku\n", "lines.parquet: is no table that can be read: "),
        ("lines.csv", None, "lines.csv: cannot be read: "),
    ],
)
def test_what_is_no_such_table_is_refused(tmp_path: Path, name: str, content: bytes | None, problem: str) -> None:
    """One sentence with the file."""
    file = tmp_path / name
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(InputError) as caught:
        rows(file, "order", "sku")
    assert str(caught.value).startswith(f"{tmp_path}/{problem}")
    assert "\n" not in str(caught.value)


def test_names_that_are_no_text_are_refused(tmp_path: Path) -> None:
    """As a shell hands them over: bytes that are no UTF-8."""
    file = tmp_path / "lines.csv"
    file.write_text("order,sku\n1,a\n", encoding="utf-8")
    with pytest.raises(InputError, match="expected names of files, columns and separator in UTF-8"):
        rows(file, "sk\udcff")


def test_parquet_has_no_lines(tmp_path: Path) -> None:
    """A column that is missing there is said without one."""
    file = tmp_path / "lines.parquet"
    pyarrow.parquet.write_table(pa.table({"order": ["1"]}), file)
    with pytest.raises(InputError) as caught:
        rows(file, "sku")
    assert str(caught.value) == f'{file}: there is no column "sku"; found order'
