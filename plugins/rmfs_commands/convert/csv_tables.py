"""Tables as CSV: of any encoding, also compressed, with line ends within quotes, records of any size."""

from __future__ import annotations

import codecs
import csv
import gzip
import io
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, cast

from rmfs_commands.convert.headers import plain, positions
from rmfs_commands.instances.csv_files import csv_records
from rmfs_core.errors import InputError
from rmfs_core.wording import listed, shown_short

SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|"}
"""Signs between fields that have a name, and are looked for where a header does not have the columns."""

_ENCODINGS = ("utf-8", "utf-16", "utf-16-le", "cp1252")
"""Encodings and separators to try if a header does not have the columns."""

_HEAD = 65_536
_SAY_ENCODING = "; say how it is encoded, such as --encoding cp1252"
_GZIP = b"\x1f\x8b"
_NOT_CSV = {
    b"PK\x03\x04": "a workbook or a zip archive",
    b"\xd0\xcf\x11\xe0": "a workbook",
    b"BZh": "data compressed by bzip2",
    b"\x28\xb5\x2f\xfd": "data compressed by zstd",
    b"\xfd7zXZ": "data compressed by xz",
    b"SQLite format 3": "a database",
    b"%PDF": "a PDF document",
}


def csv_rows(
    file: Path,
    columns: Sequence[str | None],
    separator: str = ",",
    encoding: str = "utf-8",
    header: list[str] | None = None,
) -> Iterator[Sequence[str]]:
    """Yield the fields of each row of a CSV file; empty lines are no rows.

    Parameters
    ----------
    file
        The file; what is compressed by gzip is known by its first bytes.
    columns
        Names of the columns; None: an empty field.
    separator
        Sign between fields.
    encoding
        Its encoding, as Python names it; a byte order mark of UTF-8 is skipped.
    header
        Takes the names of all columns.

    Raises
    ------
    InputError
        When it is no CSV file of that encoding, or lacks a column; with what the file looks like instead.
    """
    try:
        with _opened(file) as raw:
            head = raw.peek(_HEAD)
            for magic, kind in _NOT_CSV.items():
                if head.startswith(magic):
                    raise InputError(str(file), f"found {kind}; expected a table as CSV, .csv.gz or Parquet")
            hint = partial(_hint, head, [*filter(None, columns)], separator, encoding)
            try:
                with io.TextIOWrapper(raw, encoding=_with_mark(encoding), newline="") as stream:
                    yield from _fields(file, stream, columns, separator, hint, header)
            except UnicodeError:
                found = f"expected {encoding.upper()} text, found {_wrong_byte(file, encoding)}"
                raise InputError(str(file), found + (hint() or _SAY_ENCODING)) from None
    except (EOFError, gzip.BadGzipFile, zlib.error):
        raise InputError(str(file), "cannot be read: its compressed data are damaged or cut off") from None


def _fields(
    file: Path,
    stream: io.TextIOWrapper,
    columns: Sequence[str | None],
    separator: str,
    hint: Callable[[], str],
    seen: list[str] | None,
) -> Iterator[Sequence[str]]:
    records = csv_records(stream, file, separator)
    line, header = next(records, (1, []))
    if header[:1] == ["sep="]:  # by which a spreadsheet program is told the separator
        line, header = next(records, (line, []))
    places = positions(header, columns, f"{file}, line {line}", hint)
    if seen is not None:
        seen[:] = header
    for row, (_, fields) in enumerate(records, 1):
        if len(fields) != len(header):
            expected = f"expected {len(header)} fields as in the header, found {len(fields)}"
            raise InputError(f"{file}, row {row}", f"{expected}: {shown_short(separator.join(fields))}")
        fields.append("")
        yield [fields[place] for place in places]


@contextmanager
def _opened(file: Path) -> Iterator[io.BufferedReader[Any]]:
    with io.BufferedReader(io.FileIO(file), _HEAD) as raw:
        if raw.peek(2).startswith(_GZIP):
            with io.BufferedReader(cast("io.RawIOBase", gzip.GzipFile(fileobj=raw)), _HEAD) as unpacked:
                yield unpacked
        else:
            yield raw


def _with_mark(encoding: str) -> str:
    return "utf-8-sig" if codecs.lookup(encoding).name == "utf-8" else encoding


def _hint(head: bytes, columns: Sequence[str], separator: str, encoding: str) -> str:
    """Return what to say to read a file whose header does not have the columns; empty where nothing helps."""
    wanted = {plain(column) for column in columns}
    for other in dict.fromkeys((encoding, *_ENCODINGS)):
        text = _decoded(head, other)
        for name, sign in {"": separator, **SEPARATORS}.items():
            rows = _first_rows(text, sign)
            if fits := [line for line, fields in rows if wanted <= {plain(field) for field in fields}]:
                found = [f"{other.upper()} text"] * (other != encoding) + [f"{name}s"] * (sign != separator)
                options = [f"--encoding {other}"] * (other != encoding) + [f"--separator {name}"] * (sign != separator)
                said = f"; found {listed(found)}: say {' '.join(options)}" if options else ""
                above = f"; line {fits[0]} has it: leave out the lines above it"
                return said + above * (fits[0] > rows[0][0])
    _, fields = next(iter(_first_rows(_decoded(head, encoding), separator)), (1, [""]))
    others = [name for name, sign in SEPARATORS.items() if len(fields) == 1 and sign in fields[0]]
    return f"; found {others[0]}s: say --separator {others[0]}" if others else ""


def _first_rows(text: str, separator: str) -> list[tuple[int, list[str]]]:
    """Return the first rows that have anything, with their lines: a title may stand above the header."""
    reader = csv.reader(text.splitlines(keepends=True), delimiter=separator)
    try:
        return [(reader.line_num, fields) for fields in islice(reader, 20) if fields]
    except csv.Error:
        return []


def _decoded(head: bytes, encoding: str) -> str:
    try:
        return codecs.getincrementaldecoder(_with_mark(encoding))("strict").decode(head)
    except UnicodeError:
        return ""


def _wrong_byte(file: Path, encoding: str) -> str:
    """Return the first byte of a file that is not of its encoding, and its line."""
    line, decoder = 1, codecs.getincrementaldecoder(_with_mark(encoding))("strict")
    if file.is_file():  # a pipe can be read only once
        with suppress(UnicodeError), _opened(file) as raw:
            for chunk in iter(partial(raw.read, _HEAD), b""):
                try:
                    line += decoder.decode(chunk).count("\n")
                except UnicodeDecodeError as error:
                    line += error.object[: error.start].decode(encoding, "replace").count("\n")
                    return f"the byte 0x{error.object[error.start]:02x} in line {line}"
    return "other"
