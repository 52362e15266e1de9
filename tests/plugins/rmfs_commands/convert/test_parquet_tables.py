"""Values of Parquet files as texts, and columns that are refused."""

from __future__ import annotations

from datetime import UTC, date, datetime, time
from decimal import Decimal
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet
import pytest

from rmfs_commands.convert.parquet_tables import parquet_rows
from rmfs_core.errors import InputError


def texts(folder: Path, column: Any, encoding: str = "utf-8") -> list[str]:
    """Return the texts of a column of a file."""
    file = folder / "t.parquet"
    pyarrow.parquet.write_table(pa.table({"a.b": column}), file)
    return [text for (text,) in parquet_rows(file, ["a.b"], encoding)]


@pytest.mark.parametrize(
    ("column", "expected"),
    [
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
    ],
)
def test_values_are_texts(tmp_path: Path, column: Any, expected: list[str]) -> None:
    """Whole numbers without a point, times as ISO 8601 with their offset, bytes as the text they are."""
    assert texts(tmp_path, column) == expected


def test_bytes_are_of_the_encoding(tmp_path: Path) -> None:
    """What cannot be decoded is refused with its row."""
    assert texts(tmp_path, [b"caf\xe9"], "cp1252") == ["caf\u00e9"]
    with pytest.raises(InputError, match=r"t.parquet, row 2, a.b: expected utf-8 text, found the byte 0xe9$"):
        texts(tmp_path, [b"tea", b"caf\xe9"])


@pytest.mark.parametrize(
    ("column", "problem"),
    [
        ([[1, 2]], "holds several values a row (list"),
        ([{"x": 1}], "holds several values a row (struct"),
        (pa.array([5], pa.duration("s")), "holds neither texts nor numbers nor times (duration[s]); expected one text"),
    ],
)
def test_other_columns_are_refused(tmp_path: Path, column: Any, problem: str) -> None:
    """One sentence with the column."""
    with pytest.raises(InputError) as caught:
        texts(tmp_path, column)
    assert str(caught.value).startswith(f"{tmp_path / 't.parquet'}, a.b: {problem}")


def test_what_is_no_parquet_file_is_refused(tmp_path: Path) -> None:
    """Nothing, another file, the beginning of one: in one sentence without words of the library."""
    whole = tmp_path / "t.parquet"
    pyarrow.parquet.write_table(pa.table({"a": [1]}), whole)
    for content in (b"", b"o,s\n1,a\n", whole.read_bytes()[:-20]):
        whole.write_bytes(content)
        with pytest.raises(InputError) as caught:
            list(parquet_rows(whole, ["a"]))
        assert str(caught.value) == f"{whole}: cannot be read: it is no Parquet file, or not all of one"


def test_a_name_that_comes_twice_is_refused(tmp_path: Path) -> None:
    """As in a CSV file."""
    file = tmp_path / "t.parquet"
    pyarrow.parquet.write_table(pa.Table.from_arrays([pa.array([1]), pa.array([2])], ["q", "q"]), file)
    with pytest.raises(InputError, match=r't.parquet: found the column "q" 2 times; expected each once$'):
        list(parquet_rows(file, ["q"]))
