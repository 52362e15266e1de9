"""Writing files whole or not at all: write beside the target, then rename."""

from __future__ import annotations

import csv
import io
import json
import math
import operator
import os
import uuid
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import BinaryIO

from rmfs_core.errors import InputError


class AtomicFile:
    """A file that appears under its name when it is committed, complete, and not before.

    Usable as a context manager: leaving the block commits, an exception discards.

    Parameters
    ----------
    path
        Where the file shall be. What is there stays until the commit.

    Raises
    ------
    InputError
        When the folder cannot be written to, or the name is a folder's.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        if self.path.is_dir():
            raise InputError(str(self.path), "cannot be written: a folder has that name")
        self._beside = self.path.with_name(f".{self.path.name}.{uuid.uuid4().hex[:12]}.part")
        try:
            self.stream: BinaryIO = self._beside.open("xb")
        except OSError as error:
            raise InputError(str(self.path), f"cannot be written: {error.strerror or error}") from error

    def commit(self) -> None:
        """Close the file and give it its name, replacing what had it."""
        self.stream.close()
        try:
            os.replace(self._beside, self.path)  # noqa: PTH105 (the one call whose atomicity everything here rests on)
        except OSError as error:
            self._beside.unlink(missing_ok=True)
            raise InputError(str(self.path), f"cannot be replaced: {error.strerror or error}") from error

    def discard(self) -> None:
        """Close and delete what was written; the file of that name stays as it was."""
        self.stream.close()
        self._beside.unlink(missing_ok=True)

    def __enter__(self) -> BinaryIO:
        return self.stream

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.commit()
        else:
            self.discard()


def write_text(path: str | Path, text: str) -> None:
    """Write a whole UTF-8 file or none; line ends stay as they are in ``text``."""
    with AtomicFile(path) as stream:
        stream.write(text.encode("utf-8"))


def to_json(value: object, indent: int | None = None) -> str:
    """JSON text of plain values: keys in the order given, numpy integers as integers, NaN refused.

    What JSON does not know (a date among a rule's parameters, for example) becomes its text.
    """
    separators = (",", ":") if indent is None else None
    return json.dumps(value, indent=indent, separators=separators, ensure_ascii=False, allow_nan=False, default=_plain)


def json_ready(value: object) -> object:
    """Return nested tables with texts (``"inf"``, ``"nan"``) in place of the numbers that JSON has no word for."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, Mapping):
        return {key: json_ready(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [json_ready(entry) for entry in value]
    return value


def _plain(value: object) -> int | str:
    try:
        return operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        return str(value)


def to_csv(columns: Sequence[str], rows: Iterable[Mapping[str, object]]) -> str:
    """CSV text with a header: None is an empty field, truth values are ``true`` and ``false``."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_field(row[column]) for column in columns] for row in rows)
    return text.getvalue()


def _field(value: object) -> object:
    if isinstance(value, bool):
        return "true" if value else "false"
    return value


def output_folder(path: str | Path) -> Path:
    """Return ``path`` as a folder that exists and can be written to; make it when it is not there.

    Raises
    ------
    InputError
        When it is a file, or cannot be made or written to.
    """
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError) as error:
        raise InputError(str(folder), "found a file in the way; expected a folder, or nothing") from error
    except OSError as error:
        raise InputError(str(folder), f"cannot be made: {error.strerror or error}") from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(str(folder), "cannot be written to; expected a folder you may write to")
    return folder
