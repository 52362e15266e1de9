"""Files of recorders: compressed JSON objects, one per line."""

from __future__ import annotations

import gzip
import json
import zlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from rmfs_commands.results.files import AtomicFile, to_json
from rmfs_core.errors import InputError
from rmfs_core.info import RunInfo

MOST_OF_A_LINE = 50_000_000
MOST_OF_A_FILE = 5_000_000_000
"""Signs that are read of a file, which may be a thousand times larger than it is compressed."""


class JsonLinesFile:
    """A gzip file of JSON objects, one a line, that appears under its name when it is committed.

    Equal lines make equal bytes: the gzip header holds neither a file name nor a time. `read_json_lines` reads it.

    Parameters
    ----------
    path
        Where the file shall be.

    Raises
    ------
    InputError
        When the folder cannot be written to, or the name is a folder's.
    """

    def __init__(self, path: str | Path) -> None:
        self._file = AtomicFile(path)
        self._lines = gzip.GzipFile(filename="", mode="wb", fileobj=self._file.stream, compresslevel=6, mtime=0)

    def write(self, line: Mapping[str, Any]) -> None:
        """Append an object."""
        self._lines.write(to_json(line).encode("utf-8", "backslashreplace") + b"\n")

    def commit(self) -> None:
        """Close the file and give it its name."""
        self._lines.close()
        self._file.commit()

    def discard(self) -> None:
        """Delete what was written of a file that was not committed; afterwards without effect."""
        if not self._lines.closed:
            with suppress(OSError):  # what is left may not fit
                self._lines.close()
            self._file.discard()

    def __del__(self) -> None:
        """Leave nothing behind of a file that nobody can commit any more."""
        if hasattr(self, "_lines"):
            self.discard()


def beside_results(run: RunInfo, file: str) -> Path:
    """Return where an observer writes a file next to the results.

    Raises
    ------
    InputError
        When the run keeps no results.
    """
    if run.out is None:
        raise InputError(file, "is written next to the results; expected a run with a folder for them")
    return run.out / file


def read_json_lines(path: str | Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the JSON objects of a gzip file, one a line, each with its line, to be named in messages.

    Raises
    ------
    InputError
        With the file and the line when it cannot be read, is damaged or was cut off.
    """
    number = 0
    try:
        with gzip.open(path, "rt", encoding="utf-8") as stream:
            read = 0
            for number, text in enumerate(iter(partial(stream.readline, MOST_OF_A_LINE + 1), ""), 1):
                place = f"{path}, line {number}"
                read += len(text)
                if len(text) > MOST_OF_A_LINE or read > MOST_OF_A_FILE:
                    most = f"a line of {MOST_OF_A_LINE:,} signs, and {MOST_OF_A_FILE:,} in all"
                    raise InputError(place, f"the file is too large to be read; expected at most {most}")
                try:
                    line = json.loads(text)
                except (ValueError, RecursionError) as error:
                    raise InputError(place, f"this is no valid JSON: {error}") from error
                if not isinstance(line, dict):
                    raise InputError(place, f"expected a JSON object, found {type(line).__name__}")
                yield place, line
    except EOFError as error:
        raise InputError(f"{path}, line {number + 1}", "the file was cut off here") from error
    except (gzip.BadGzipFile, zlib.error, UnicodeDecodeError) as error:
        raise InputError(f"{path}, line {number + 1}", f"the file is damaged or no gzip file: {error}") from error
    except OSError as error:
        raise InputError(str(path), f"cannot be read: {error.strerror or error}") from error
