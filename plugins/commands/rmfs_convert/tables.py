"""Tables of order lines, CSV or Parquet, read in batches: memory does not grow with the table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from attrs import frozen

from rmfs_core.errors import InputError
from rmfs_core.wording import did_you_mean, listed

if TYPE_CHECKING:
    import pyarrow as pa

ROWS_PER_BATCH = 65_536


@frozen
class Batch:
    """Some rows of a table.

    Parameters
    ----------
    first_row
        Number of the first of them, from 1; the header is none.
    columns
        The values of each column that was asked for, as texts, None where the table has nothing.
    """

    first_row: int
    columns: tuple[Sequence[str | None], ...]


def batches(file: Path, columns: Sequence[str], separator: str = ",") -> Iterator[Batch]:
    """Yield a table's columns, some rows at a time.

    Parameters
    ----------
    file
        A CSV file (also compressed: ``.csv.gz``), or a Parquet file (``.parquet``).
    columns
        Names of the columns.
    separator
        What stands between the fields of a CSV file.

    Raises
    ------
    InputError
        When the file cannot be read, is damaged, or lacks a column.
    """
    with _errors(file), _opened(file, columns, separator) as found:
        row = 1
        for batch in found:
            yield Batch(row, tuple(_texts(batch.column(name)) for name in columns))
            row += batch.num_rows


@contextmanager
def _opened(file: Path, columns: Sequence[str], separator: str) -> Iterator[Iterator[pa.RecordBatch]]:
    import pyarrow as pa
    from pyarrow import csv, parquet

    if file.suffix.lower() in (".parquet", ".pq"):
        with parquet.ParquetFile(file) as table:
            _require(file, columns, table.schema_arrow.names)
            yield table.iter_batches(ROWS_PER_BATCH, columns=list(dict.fromkeys(columns)))
        return
    with csv.open_csv(
        file,
        read_options=csv.ReadOptions(use_threads=False),
        parse_options=csv.ParseOptions(delimiter=separator),
        # Everything is text here: what is a number, a time or a name of digits is for the reader of the columns to say.
        convert_options=csv.ConvertOptions(column_types=dict.fromkeys(columns, pa.string())),
    ) as reader:
        _require(file, columns, reader.schema.names)
        yield iter(reader)


def _require(file: Path, columns: Sequence[str], found: Sequence[str]) -> None:
    for name in columns:
        if name not in found:
            raise InputError(
                f"{file}, line 1" if file.suffix.lower() not in (".parquet", ".pq") else str(file),
                f'there is no column "{name}"{did_you_mean(name, found)}; found {listed(found)}',
            )


def _texts(column: pa.Array) -> list[str | None]:
    import pyarrow as pa

    if pa.types.is_timestamp(column.type) or pa.types.is_date(column.type):
        return [None if value is None else value.isoformat() for value in column.to_pylist()]
    return [value if value is None or isinstance(value, str) else _plain(value) for value in column.to_pylist()]


def _plain(value: Any) -> str:
    return str(int(value)) if isinstance(value, float) and value.is_integer() else str(value)


@contextmanager
def _errors(file: Path) -> Iterator[None]:
    """Say what pyarrow raises in a sentence."""
    import pyarrow as pa

    try:
        yield
    except OSError as error:
        raise InputError(str(file), f"cannot be read: {error.strerror or ' '.join(str(error).split())}") from None
    except pa.ArrowException as error:
        raise InputError(str(file), f"is no table that can be read: {' '.join(str(error).split())}") from None
    except UnicodeEncodeError:  # a byte that is no text, in what was typed
        raise InputError(str(file), "expected names of files, columns and separator in UTF-8") from None
    except UnicodeDecodeError as error:
        raise InputError(str(file), f"expected UTF-8 text, found the byte 0x{error.object[error.start]:02x}") from None
