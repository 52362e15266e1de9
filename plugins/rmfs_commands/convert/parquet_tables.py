"""Tables as Parquet: numbers, times and texts of any kind, as texts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rmfs_commands.convert.headers import positions
from rmfs_commands.convert.names import short
from rmfs_core.errors import InputError

if TYPE_CHECKING:
    import pyarrow as pa

ROWS_PER_BATCH = 65_536
_TEXTS = ("string", "large_string", "string_view")
_BYTES = ("binary", "large_binary", "binary_view")


def parquet_rows(
    file: Path, columns: Sequence[str | None], encoding: str = "utf-8", header: list[str] | None = None
) -> Iterator[Sequence[str]]:
    """Yield the fields of each row of a Parquet file as texts; empty where a row has nothing.

    Parameters
    ----------
    file
        The file.
    columns
        Names of the columns: numbers, times, texts, or bytes that are text; None: an empty field.
    encoding
        Of texts that are stored as bytes.
    header
        Takes the names of all columns.

    Raises
    ------
    InputError
        When it is no Parquet file, lacks a column, or a column has several values a row.
    """
    import pyarrow as pa
    from pyarrow import parquet

    try:
        with file.open("rb") as stream, parquet.ParquetFile(stream) as table:
            schema = table.schema_arrow
            given = [*schema.names, None]
            names = [given[index] for index in positions(schema.names, columns, str(file))]
            if header is not None:
                header[:] = schema.names
            readers = {name: _reader(schema.field(name), file, encoding) for name in filter(None, names)}
            row = 1
            for batch in table.iter_batches(ROWS_PER_BATCH, columns=list(readers)):
                texts: dict[str | None, list[str]] = {
                    name: _texts(batch.column(name), reader, f"{file}, row {{}}, {name}", row)
                    for name, reader in readers.items()
                }
                texts[None] = [""] * batch.num_rows
                yield from zip(*(texts[name] for name in names), strict=True)
                row += batch.num_rows
    except OSError as error:
        if error.strerror:
            raise
        raise InputError(str(file), "cannot be read: it is no Parquet file, or not all of one") from None
    except pa.ArrowException:
        raise InputError(str(file), "cannot be read: it is no Parquet file, or not all of one") from None


def _reader(field: pa.Field, file: Path, encoding: str) -> Callable[[Any], str]:
    """Return what makes a text of a value."""
    from pyarrow import types

    kind = field.type.value_type if types.is_dictionary(field.type) else field.type
    if str(kind) in _BYTES or types.is_fixed_size_binary(kind):
        return lambda value: str(value, encoding)
    if any(of(kind) for of in (types.is_timestamp, types.is_date, types.is_time)):
        return lambda value: str(value.isoformat())
    if any(of(kind) for of in (types.is_floating, types.is_decimal)):
        return _number
    if str(kind) in _TEXTS or any(of(kind) for of in (types.is_integer, types.is_boolean, types.is_null)):
        return str
    several = "several values a row" if types.is_nested(kind) else "neither texts nor numbers nor times"
    raise InputError(
        f"{file}, {field.name}", f"holds {several} ({short(str(kind))}); expected one text, number or time"
    )


def _texts(column: pa.Array, reader: Callable[[Any], str], place: str, first_row: int) -> list[str]:
    import pyarrow as pa

    if pa.types.is_timestamp(column.type) and column.type.unit == "ns":
        column = column.cast(pa.timestamp("us", column.type.tz), safe=False)
    found: list[str] = []
    try:
        values = column.to_pylist()
        for value in values:
            found.append("" if value is None else reader(value))  # noqa: PERF401 (how many were read is said)
    except UnicodeDecodeError as error:
        problem = f"expected {error.encoding} text, found the byte 0x{error.object[error.start]:02x}"
    except (ValueError, OverflowError):
        problem = "expected times of the years 1 to 9999, found another"
    else:
        return found
    raise InputError(place.format(first_row + len(found)), problem)


def _number(value: Any) -> str:
    """Return a number as text that is read alike in all countries: never with three digits after the point."""
    if value % 1 == 0:
        return str(int(value))
    text = repr(value) if isinstance(value, float) else f"{value:f}"
    return f"{text}0" if text[-4:-3] == "." else text
