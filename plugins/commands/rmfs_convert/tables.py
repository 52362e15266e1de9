"""Tables of a warehouse, CSV or Parquet, read in batches: memory does not grow with the table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from attrs import frozen

from rmfs_convert.csv_tables import csv_columns
from rmfs_convert.parquet_tables import parquet_columns
from rmfs_core.errors import InputError

_PARQUET, _PARQUET_SUFFIXES = b"PAR1", (".parquet", ".pq")


@frozen
class Batch:
    """Some rows of a table.

    Parameters
    ----------
    first_row
        Number of the first of them, from 1; the header and empty lines are none.
    columns
        The values of each column that was asked for, as texts, None where the table has nothing.
    """

    first_row: int
    columns: tuple[Sequence[str | None], ...]


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
    """

    file: Path
    separator: str = ","
    encoding: str = "utf-8"

    def batches(self, columns: Sequence[str]) -> Iterator[Batch]:
        """Yield columns, some rows at a time.

        Parameters
        ----------
        columns
            Names of the columns; a name may come twice.

        Raises
        ------
        InputError
            When the file cannot be read, is damaged, or lacks a column; with its row where it is one of the rows.
        """
        row = 1
        try:
            found: Iterator[tuple[Sequence[str | None], ...]]
            if self._is_parquet():
                found = parquet_columns(self.file, columns, self.encoding)
            else:
                found = csv_columns(self.file, columns, self.separator, self.encoding)
            for batch in found:
                yield Batch(row, batch)
                row += len(batch[0])
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
