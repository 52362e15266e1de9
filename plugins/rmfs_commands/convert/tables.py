"""Tables of a warehouse, CSV or Parquet, read row by row: memory does not grow with the table."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from attrs import field, frozen

from rmfs_commands.convert.csv_tables import csv_rows
from rmfs_commands.convert.headers import plain
from rmfs_commands.convert.parquet_tables import parquet_rows
from rmfs_commands.convert.tally import Tally
from rmfs_core.errors import InputError
from rmfs_core.wording import did_you_mean

_PARQUET, _PARQUET_SUFFIXES = b"PAR1", (".parquet", ".pq")


Row = tuple[int, Sequence[str]]
"""Number of a row, from 1 (the header and empty lines are none), and its fields."""

Chosen = Mapping[str, frozenset[str]]
"""Values by column: only rows with one of the values of each column are read."""

_MOST_REMEMBERED = 1000
"""Values of a column that are remembered, to say which was meant."""


def check_there(*files: Path | None) -> None:
    """Raise an `InputError` for the first of some files that is not there; None is no file."""
    for file in files:
        try:
            if file is not None:
                file.stat()
        except OSError as error:
            raise InputError(str(file), f"cannot be read: {error.strerror}") from None
        except ValueError:  # of a name that no file can have; reading says so
            continue


@frozen
class Table:
    """A table in a file.

    Parameters
    ----------
    file
        A CSV file (also compressed: ``.csv.gz``), or a Parquet file.
    separator
        Sign between the fields of a CSV file.
    encoding
        How the texts of the file are encoded.
    only
        Which rows are read; None: all.
    option
        The option that says that.

    Attributes
    ----------
    header
        Names of its columns, once its rows are read.
    others
        Rows that are not read, by reason.
    """

    file: Path
    separator: str = ","
    encoding: str = "utf-8"
    only: Chosen | None = None
    option: str = "--only"
    header: list[str] = field(init=False, factory=list, eq=False)
    others: Tally = field(init=False, factory=Tally, eq=False)

    def rows(self, columns: Sequence[str | None], passed: Callable[[str], None] | None = None) -> Iterator[Row]:
        """Yield the rows, with the fields of some columns.

        Parameters
        ----------
        columns
            Names of the columns; a name may come twice. None: the field is empty in every row, as is a field where the
            table has nothing.
        passed
            Told the first of these fields of each row that is not read.

        Raises
        ------
        InputError
            When the file cannot be read, is damaged, or lacks a column; with its row where it is one of the rows. When
            no row has a value of those to be read.
        """
        if self.only is None:
            yield from self._all(columns)
            return
        missing = {column: set(values) for column, values in self.only.items()}
        seen: dict[str, dict[str, None]] = {column: {} for column in self.only}
        for row, fields in self._all((*columns, *self.only)):
            other = None
            for column, text in zip(self.only, map(plain, fields[len(columns) :]), strict=True):
                missing[column].discard(text)
                if len(seen[column]) < _MOST_REMEMBERED:
                    seen[column][text] = None
                if other is None and text not in self.only[column]:
                    other = column, text
            if other is None:
                yield row, fields[: len(columns)]
            elif any(map(str.strip, fields)):
                self.others.note(f"another {other[0]}", row, other[1], chosen=True)
                if passed is not None:
                    passed(fields[0])
        for column, values in missing.items():
            for value in sorted(values):
                meant = did_you_mean(value, seen[column])
                raise InputError(self.option, f'no row of {self.file} has "{value}" in the column "{column}"{meant}')

    def _all(self, columns: Sequence[str | None]) -> Iterator[Row]:
        """Yield all rows."""
        try:
            if self._is_parquet():
                yield from enumerate(parquet_rows(self.file, columns, self.encoding, self.header), 1)
            else:
                yield from enumerate(csv_rows(self.file, columns, self.separator, self.encoding, self.header), 1)
        except OSError as error:
            raise InputError(str(self.file), f"cannot be read: {error.strerror or 'it is damaged'}") from None
        except UnicodeEncodeError:  # a byte that is no text, in what was typed
            raise InputError(str(self.file), "expected names of files, columns and separator in UTF-8") from None
        except ValueError:  # of a name that no file can have
            raise InputError(str(self.file), "cannot be read: no file can have that name") from None

    def _is_parquet(self) -> bool:
        if self.file.suffix.lower() in _PARQUET_SUFFIXES:
            return True
        if not self.file.is_file():  # a pipe can be read only once
            return False
        with self.file.open("rb") as stream:
            return stream.read(len(_PARQUET)) == _PARQUET
