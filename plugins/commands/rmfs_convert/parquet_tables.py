"""Tables as Parquet: numbers, times and texts of any kind, as texts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rmfs_convert.headers import positions
from rmfs_core.errors import InputError
from rmfs_core.wording import shown_short

if TYPE_CHECKING:
    import pyarrow as pa

ROWS_PER_BATCH = 65_536
_TEXTS = ("string", "large_string", "string_view")
_BYTES = ("binary", "large_binary", "binary_view")


def parquet_columns(
    file: Path, columns: Sequence[str], encoding: str = "utf-8"
) -> Iterator[tuple[list[str | None], ...]]:
    """Yield the columns of a Parquet file as texts, some rows at a time; None where a row has nothing.

    Parameters
    ----------
    file
        The file.
    columns
        Names of the columns: numbers, times, texts, or bytes that are text.
    encoding
        Of texts that are stored as bytes.

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
            places = positions(schema.names, columns, str(file))
            readers = [_reader(schema.field(place), file, encoding) for place in places]
            names = [schema.names[place] for place in places]
            row = 1
            for batch in table.iter_batches(ROWS_PER_BATCH, columns=list(dict.fromkeys(names))):
                yield tuple(
                    _texts(batch.column(name), reader, f"{file}, row {{}}, {name}", row)
                    for name, reader in zip(names, readers, strict=True)
                )
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
        f"{file}, {field.name}", f"holds {several} ({shown_short(str(kind))[1:-1]}); expected one text, number or time"
    )


def _texts(column: pa.Array, reader: Callable[[Any], str], place: str, first_row: int) -> list[str | None]:
    import pyarrow as pa

    if pa.types.is_timestamp(column.type) and column.type.unit == "ns":
        column = column.cast(pa.timestamp("us", column.type.tz), safe=False)
    found: list[str | None] = []
    try:
        values = column.to_pylist()
        for value in values:
            found.append(None if value is None else reader(value))  # noqa: PERF401 (how many were read is said)
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
