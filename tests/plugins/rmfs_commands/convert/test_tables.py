"""Rows of tables, whatever they are in."""

from __future__ import annotations

import gzip
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet
import pytest

from rmfs_commands.convert import parquet_tables
from rmfs_commands.convert.tables import Table
from rmfs_core.errors import InputError


def test_rows_are_counted_over_batches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From 1; a column that is not asked for is empty."""
    monkeypatch.setattr(parquet_tables, "ROWS_PER_BATCH", 4)
    file = tmp_path / "lines.parquet"
    pyarrow.parquet.write_table(pa.table({"order": [str(i) for i in range(10)]}), file)
    found = list(Table(file).rows(["order", None]))
    assert found == [(i, (str(i - 1), "")) for i in range(1, 11)]


def test_the_kind_of_a_file_is_known_by_what_is_in_it(tmp_path: Path) -> None:
    """A Parquet file and a compressed one of any name."""
    pyarrow.parquet.write_table(pa.table({"o": [b"A1"]}), tmp_path / "one.dat")
    (tmp_path / "two.dat").write_bytes(gzip.compress(b"x;o\n1;A1\n"))
    for name in ("one.dat", "two.dat"):
        assert [(row, *fields) for row, fields in Table(tmp_path / name, ";").rows(["o"])] == [(1, "A1")]


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("none.csv", "cannot be read: No such file or directory"),
        ("none.parquet", "cannot be read: No such file or directory"),
        (".", "cannot be read: Is a directory"),
        ("a\0b", "cannot be read: no file can have that name"),
        ("\udcff.csv", "cannot be read: No such file or directory"),
    ],
)
def test_a_file_that_is_not_there_is_refused(tmp_path: Path, name: str, problem: str) -> None:
    """One sentence with its name."""
    with pytest.raises(InputError) as caught:
        list(Table(tmp_path / name).rows(["o"]))
    assert str(caught.value) == f"{tmp_path / name}: {problem}"


def test_names_that_are_no_text_are_refused(tmp_path: Path) -> None:
    """As a shell hands them over: bytes that are no UTF-8."""
    file = tmp_path / "lines.csv"
    file.write_text("order,sku\n1,a\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"there is no column .*; found order and sku$"):
        list(Table(file).rows(["sk\udcff"]))
