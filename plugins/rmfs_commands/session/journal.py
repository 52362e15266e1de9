"""The journal of a session: a line for what it was made from, then one for each batch with its answer."""

from __future__ import annotations

import json
import os
import tempfile
import weakref
from array import array
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from rmfs_commands.results.files import to_json
from rmfs_core.errors import InputError

FORMAT, VERSION = "rmfs-session", 1
NO_JOURNAL = "is no journal of a session; expected one"


def header_of(path: Path) -> Mapping[str, Any]:
    """Return the first line of a journal: what its session was made from.

    Raises
    ------
    InputError
        Where the file cannot be read, or is no journal.
    """
    try:
        with path.open("rb") as lines:
            found = json.loads(lines.readline())
    except OSError as error:
        raise _unusable(path, error) from error
    except ValueError:
        raise InputError(str(path), NO_JOURNAL) from None
    dead_s = found.get("dead_s") if isinstance(found, dict) else ""
    if not isinstance(dead_s, float | int | None) or found.get("format") != FORMAT:
        raise InputError(str(path), NO_JOURNAL)
    return found  # type: ignore[no-any-return]


def _unusable(name: Path | str, error: OSError) -> InputError:
    """Return the error of a journal that cannot be opened."""
    if Path(name).is_dir():
        return InputError(str(name), "found a folder; expected the file of a journal, such as NAME.jsonl")
    return InputError(str(name), f"cannot be used as the journal: {error.strerror or error}")


class Journal:
    """A file with one writer, whose lines are on the disk before their answers are given.

    Parameters
    ----------
    path
        The file; it is made where it is not there. A last line that is not whole, which was never answered, is cut off.
        None: one that is gone with the process.
    made_from
        Scenario and versions of the session. A file that another session wrote is refused.
    read_only
        Whether the file stays as it is, and another session may be writing it: whole lines are read.
    """

    def __init__(self, path: Path | None, made_from: Mapping[str, Any], *, read_only: bool = False) -> None:
        self.path, self.name, self._read_only = path, str(path or "memory"), read_only
        mode = "rb" if read_only else "a+b"
        try:
            self._file: Any = tempfile.TemporaryFile() if path is None else path.open(mode)  # noqa: SIM115
        except OSError as error:
            raise _unusable(self.name, error) from error
        weakref.finalize(self, self._file.close)
        try:
            self._lock()
            self._begins = self._whole()
            self._check({"format": FORMAT, "version": VERSION, **made_from})
        except BaseException:
            self.close()
            raise

    def _check(self, header: Mapping[str, Any]) -> None:
        """Write the first line, or check that it is this one."""
        if len(self._begins) == 1 and not self._read_only:
            self.append(header)
            return
        found, wanted = next(self._lines(0), None), json.loads(to_json(header))
        if not isinstance(found, dict) or found.get("format") != FORMAT:
            raise InputError(self.name, f"{NO_JOURNAL}, or a new file")
        if names := [name for name in {**wanted, **found} if found.get(name) != wanted.get(name)]:
            what = f"{', '.join(names)} differ{'s' * (len(names) == 1)}"
            expected = "the scenario that it was made from, under this version" if self._read_only else "a new file"
            raise InputError(self.name, f"is the journal of another session: {what}; expected {expected}")

    def _lock(self) -> None:
        if self._read_only:
            return
        try:
            import fcntl
        except ModuleNotFoundError:  # another system than the service runs on
            return
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(self.name, "is in use by another session; expected a file of its own") from None

    def _whole(self) -> array[int]:
        """Cut off a last line without its end; return where lines begin, and where the last one ends."""
        begins = array("Q", [0])
        self._file.seek(0)
        for line in self._file:
            if line.endswith(b"\n"):
                begins.append(begins[-1] + len(line))
            elif not self._read_only:
                self._file.truncate(begins[-1])
        return begins

    def append(self, line: Mapping[str, Any]) -> None:
        """Write a line, and return when it is on the disk; where that fails, nothing of it stays."""
        content = to_json(line).encode("utf-8", "backslashreplace") + b"\n"
        try:
            self._file.seek(0, os.SEEK_END)
            self._file.write(content)
            self._file.flush()
            if self.path is not None:
                os.fsync(self._file.fileno())
        except OSError as error:
            self._file.truncate(self._begins[-1])
            raise InputError(self.name, f"cannot be written to: {error.strerror or error}") from error
        self._begins.append(self._begins[-1] + len(content))

    def batches(self, seq: int = 0) -> Iterator[tuple[Any, Any]]:
        """Yield each batch with its answer, first to last, after that of a number."""
        for number, line in enumerate(self._lines(seq + 1), seq + 2):
            if not isinstance(line, dict) or not line.keys() >= {"batch", "answer"}:
                raise InputError(f"{self.name}, line {number}", "expected a batch and its answer")
            yield line["batch"], line["answer"]

    def _lines(self, first: int) -> Iterator[Any]:
        for number in range(first, len(self._begins) - 1):
            self._file.seek(self._begins[number])
            try:
                yield json.loads(self._file.readline())
            except (ValueError, RecursionError):
                raise InputError(f"{self.name}, line {number + 1}", "found no JSON; expected a batch") from None

    def close(self) -> None:
        """Let another session use the file."""
        self._file.close()
