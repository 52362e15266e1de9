"""Writing files whole or not at all: write next to the target, then rename."""

from __future__ import annotations

import csv
import io
import json
import math
import operator
import os
import re
import shutil
import uuid
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from rmfs_core.errors import InputError

try:
    import fcntl
except ImportError:  # Windows: nothing can be told to be left over, so nothing is deleted
    fcntl = None  # type: ignore[assignment]


def _problem(path: Path, error: OSError) -> InputError:
    return InputError(str(path), f"cannot be written: {error.strerror or error}")


def beside(path: Path) -> Path:
    """Return the name of a file while it is written; `clean` deletes what a killed process left there."""
    return path.with_name(f".{path.name[:50]}.{uuid.uuid4().hex[:12]}.part")


def hold(opened: int) -> bool:
    """Lock what is written as long as it is open, so that nobody takes it for left over; False when another has it."""
    if fcntl is None:
        return True
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:  # any other: this file system knows no locks
        return not isinstance(error, BlockingIOError)
    return True


def opened(path: Path) -> int:
    """Return a descriptor of a file or a folder, for `hold`; where folders cannot be opened, of nothing."""
    return os.open(path if fcntl else os.devnull, os.O_RDONLY)  # only POSIX opens folders


def clean(folder: Path) -> None:
    """Delete what killed processes have left half written in a folder, and put in place what they had written whole."""
    for part in folder.iterdir():
        if re.fullmatch(rf"\..*\.[0-9a-f]{{12}}\.({'part|' if fcntl else ''}whole)", part.name):
            with suppress(FileNotFoundError):  # another is at it, too
                held = opened(part)
                if hold(held):
                    for file in part.iterdir() if part.suffix == ".whole" else ():
                        _put(file, folder / file.name)
                    shutil.rmtree(part) if part.is_dir() else part.unlink()
                os.close(held)


def _put(file: Path, target: Path) -> None:
    if file.is_dir():
        shutil.copytree(file, target, dirs_exist_ok=True)
    elif not target.is_symlink() and (target.is_file() or not target.exists()):
        file.replace(target)
    else:  # a link, a device or a pipe
        with AtomicFile(target) as stream:
            stream.write(file.read_bytes())


@contextmanager
def staged(folder: Path) -> Iterator[Path]:
    """Yield a hidden folder whose files move to ``folder`` when the block ends well: all of them, or none.

    If the process is killed while they do, the next one that writes there goes on with it.
    """
    try:
        path = beside(folder / "files")
        path.mkdir()
        held = opened(path)
        hold(held)
        try:
            yield path
            path.rename(path.with_suffix(".whole"))
        finally:
            os.close(held)
            clean(folder)
    except OSError as error:
        raise _problem(folder, error) from error


class AtomicFile:
    """A file that appears under its name when it is committed, complete, and not before.

    Usable as a context manager: leaving the block commits, an exception discards. A link is followed, a device or a
    pipe written to as it is.

    Parameters
    ----------
    path
        Where the file shall be. What is there stays until the commit.

    Raises
    ------
    InputError
        When it cannot be written: the name is a folder's, or a disk is full.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._beside: Path | None = None
        try:
            if self.path.is_dir():
                raise InputError(str(self.path), "cannot be written: a folder has that name")
            if self.path.is_file() or not self.path.exists():
                self._beside = beside(self.path.resolve())
            self.stream: BinaryIO = self._beside.open("xb") if self._beside else self.path.open("wb")
            hold(self.stream.fileno())
        except OSError as error:
            raise _problem(self.path, error) from error

    def commit(self) -> None:
        """Close the file and give it its name, replacing what had it."""
        try:
            self.stream.flush()
            if self._beside:
                os.fsync(self.stream.fileno())
                os.replace(self._beside, self.path.resolve())  # noqa: PTH105 (everything here rests on this call)
            self.stream.close()
        except OSError as error:
            self.discard()
            raise _problem(self.path, error) from error

    def discard(self) -> None:
        """Close and delete what was written; the file of that name stays as it was."""
        with suppress(OSError):  # what is left in the buffer may not fit
            self.stream.close()
        if self._beside:
            self._beside.unlink(missing_ok=True)

    def __enter__(self) -> BinaryIO:
        return self.stream

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: object) -> None:
        if kind is None:
            self.commit()
        else:
            self.discard()
            if isinstance(error, OSError) and error.filename is None:
                raise _problem(self.path, error) from error


def write_text(path: str | Path, text: str) -> None:
    """Write a whole UTF-8 file or none; line ends stay as they are in ``text``."""
    with AtomicFile(path) as stream:
        stream.write(encoded(text))


def encoded(text: str) -> bytes:
    """Return a text in UTF-8, of which what is no character is spelled out."""
    return text.encode("utf-8", "backslashreplace")


def to_json(value: object, indent: int | None = None) -> str:
    """JSON text of plain values: keys in the order given, numpy integers as integers, NaN refused.

    What JSON does not know (a date among a rule's parameters, for example) becomes its text.
    """
    separators = (",", ":") if indent is None else None
    return json.dumps(value, indent=indent, separators=separators, ensure_ascii=False, allow_nan=False, default=_plain)


def json_ready(value: object) -> object:
    """Return nested tables with texts (``"inf"``, ``"nan"``) instead of the numbers that JSON has no word for."""
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
    fields = ([row[column] for column in columns] for row in rows)
    writer.writerows([str(one).lower() if isinstance(one, bool) else one for one in row] for row in fields)
    return text.getvalue()


@contextmanager
def removed_if_empty(path: str | Path) -> Iterator[None]:
    """Remove a folder, and those above it, when the block ends, if the block made them and left nothing in them."""
    folder = Path(path).absolute()
    made = [one for one in (folder, *folder.parents) if not os.path.exists(one)]  # noqa: PTH110 (also of a name too long)
    try:
        yield
    finally:
        for one in made:
            with suppress(OSError):
                one.rmdir()


def output_folder(path: str | Path) -> Path:
    """Return ``path`` as a folder that exists and can be written to, without what killed processes have left there.

    Raises
    ------
    InputError
        When it is a file, or cannot be made or written to.
    """
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError) as error:
        raise InputError(str(folder), "found a file; expected a folder, or a new name") from error
    except OSError as error:
        raise InputError(str(folder), f"cannot be made: {error.strerror or error}") from error
    if not os.access(folder, os.R_OK | os.W_OK | os.X_OK):
        raise InputError(str(folder), "cannot be written to; expected a folder you may write to")
    clean(folder)
    return folder
