"""The journal of a session: a line for what it was made from, then one for each batch with its answer."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from rmfs_commands.results.files import to_json
from rmfs_core.errors import InputError

FORMAT, VERSION = "rmfs-session", 1


class Journal:
    """A file with one writer, whose lines are on the disk before their answers are given.

    Parameters
    ----------
    path
        The file; it is made where it is not there. A last line that is not whole, which was never answered, is cut off.
    made_from
        Scenario and versions of the session. A file that another session wrote is refused.
    """

    def __init__(self, path: Path, made_from: Mapping[str, Any]) -> None:
        self.path = path
        try:
            self._file = path.open("a+b")
        except OSError as error:
            raise InputError(str(path), f"cannot be used as the journal: {error.strerror or error}") from error
        try:
            self._lock()
            self._end = self._whole()
            self._check({"format": FORMAT, "version": VERSION, **made_from})
        except BaseException:
            self.close()
            raise

    def _check(self, header: Mapping[str, Any]) -> None:
        """Write the first line, or check that it is this one."""
        if self._end == 0:
            self.append(header)
            return
        found, wanted = next(self._lines()), json.loads(to_json(header))
        if not isinstance(found, dict) or found.get("format") != FORMAT:
            raise InputError(str(self.path), "is no journal of a session; expected one, or a new file")
        if names := [name for name in {**wanted, **found} if found.get(name) != wanted.get(name)]:
            what = f"{', '.join(names)} differ{'s' * (len(names) == 1)}"
            raise InputError(str(self.path), f"is the journal of another session: {what}; expected a new file")

    def _lock(self) -> None:
        try:
            import fcntl
        except ModuleNotFoundError:  # another system than the service runs on
            return
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(str(self.path), "is in use by another session; expected a file of its own") from None

    def _whole(self) -> int:
        """Cut off a last line without its end; return where the file ends."""
        size = end = self._file.seek(0, os.SEEK_END)
        while end:
            self._file.seek(begin := max(end - 65_536, 0))
            at = self._file.read(end - begin).rfind(b"\n")
            if at >= 0:
                end = begin + at + 1
                break
            end = begin
        if end < size:
            self._file.truncate(end)
        return end

    def append(self, line: Mapping[str, Any]) -> None:
        """Write a line, and return when it is on the disk; where that fails, nothing of it stays."""
        content = to_json(line).encode("utf-8", "backslashreplace") + b"\n"
        try:
            self._file.write(content)
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as error:
            self._file.truncate(self._end)
            raise InputError(str(self.path), f"cannot be written to: {error.strerror or error}") from error
        self._end += len(content)

    def batches(self) -> Iterator[tuple[Any, Any]]:
        """Yield each batch with its answer, first to last."""
        lines = self._lines()
        next(lines, None)
        for line in lines:
            yield line["batch"], line["answer"]

    def _lines(self) -> Iterator[Any]:
        with self.path.open("rb") as lines:
            for number, line in enumerate(lines, 1):
                try:
                    yield json.loads(line)
                except ValueError:
                    raise InputError(f"{self.path}, line {number}", "found no JSON; expected a batch") from None

    def close(self) -> None:
        """Let another session use the file."""
        self._file.close()
