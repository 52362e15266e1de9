"""Finished runs on disk: one folder each, named by the run's key, there whole or not at all.

They are spread over folders named by the first two digits of their keys: a folder with 100,000 others in it is slow.
Each run stays a folder of plain files, which other commands read like what `rmfs run` writes.

The result.json of a stored run has the key inside and the digests of all its files: that of itself is of all the rest
of it. So a run that was changed by hand, or copied from elsewhere, or cut short by a power failure is not taken for
one that was computed; and storing a run need not wait for the disk.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
from contextlib import suppress
from pathlib import Path

from rmfs_commands.experiments.experiment import Job
from rmfs_commands.experiments.keys import KEY_LENGTH
from rmfs_commands.experiments.outcome import Outcome
from rmfs_commands.experiments.rows import Row, row_of
from rmfs_commands.results.files import beside, encoded, hold, opened, output_folder, to_json
from rmfs_commands.results.writing import table_files
from rmfs_core.errors import InputError
from rmfs_core.results import RESULT_FILE

NOTE_FILE = "run.json"
SEAL = "stored"
"""The key of result.json under which stand the run's key and the digests of its files."""
NOT_AS_STORED = "is not as it was stored"


class RunStore:
    """A folder of finished runs.

    Parameters
    ----------
    folder
        Where the runs are; made when it is not there. Runs that earlier versions stored directly in it take their
        places.

    Raises
    ------
    InputError
        When it cannot be written to.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = output_folder(folder)
        for run in [path for path in self.folder.iterdir() if re.fullmatch(f"[0-9a-f]{{{KEY_LENGTH}}}", path.name)]:
            try:
                self._put(run, run.name)
            except OSError:  # another process has moved it, or it was stored anew: nobody reads this one
                if self._place(run.name).is_dir():
                    shutil.rmtree(run, ignore_errors=True)

    def __contains__(self, job: Job) -> bool:
        return self.place(job).is_dir()

    def place(self, job: Job) -> Path:
        """Return the folder of a run, whether it is stored or not."""
        return self._place(job.key)

    def problem(self, job: Job) -> str | None:
        """Say what is wrong with a stored run: its files were changed, or are another run's."""
        try:
            self.row(job)
        except InputError as error:
            return str(error)
        return None

    def save(self, job: Job, outcome: Outcome) -> Row:
        """Store a run that has a result, and return its row.

        It is written under another name and renamed: a kill leaves no half run. A file already there stays, also
        where another process has stored it meanwhile, and its row is returned, unless something is wrong with it.

        Raises
        ------
        InputError
            When it cannot be written.
        """
        if outcome.result is None:
            raise ValueError("a run without a result has nothing to be stored")
        if self.problem(job) is None:
            return self.row(job)
        about = {"run": str(job), "error_kind": outcome.error_kind, "run_s": outcome.run_s}
        note = to_json(about | {"sources": dict(job.sources)}, indent=2) + "\n"
        sealed = to_json(outcome.result.to_dict())
        files = {name: encoded(text) for name, text in (table_files(outcome.result) | {NOTE_FILE: note}).items()}
        digests = {name: _digest(content) for name, content in sorted((files | {RESULT_FILE: encoded(sealed)}).items())}
        content = json.loads(sealed)
        whole = to_json(content | {SEAL: {"key": job.key, "files": digests}}, indent=2) + "\n"
        written = self._write(job, files | {RESULT_FILE: encoded(whole)})
        return row_of(job, content, about) if written else self.row(job)

    def _write(self, job: Job, files: dict[str, bytes]) -> bool:
        """Store the files of a run; return False where another process has stored the same run meanwhile."""
        part = beside(self.folder / job.key)
        try:
            part.mkdir()
            held = opened(part)
            hold(held)
            try:
                for name, content in files.items():
                    (part / name).write_bytes(content)
                if job in self:
                    if self.problem(job) is None:
                        raise FileExistsError
                    with suppress(FileNotFoundError):  # another process has moved it
                        shutil.rmtree(self.place(job).rename(beside(self.folder / job.key)), ignore_errors=True)
                self._put(part, job.key)
            finally:
                os.close(held)
        except BaseException as error:  # Ctrl-C as well
            shutil.rmtree(part, ignore_errors=True)
            if not isinstance(error, OSError):
                raise
            if self.problem(job) is not None:
                raise InputError(str(self.folder), f"cannot be written: {error.strerror or error}") from error
            return False
        return True

    def _put(self, run: Path, key: str) -> None:
        """Move a folder with a run to where it belongs."""
        place = self._place(key)
        place.parent.mkdir(exist_ok=True)
        run.rename(place)

    def _place(self, key: str) -> Path:
        return self.folder / key[:2] / key

    def row(self, job: Job) -> Row:
        """Read a stored run as a row.

        Raises
        ------
        InputError
            When its files are not what was stored.
        """
        folder = self.place(job)
        try:
            content, note = (json.loads((folder / name).read_text("utf-8")) for name in (RESULT_FILE, NOTE_FILE))
            seal = content.pop(SEAL)
            found = {name: _digest((folder / name).read_bytes()) for name in seal["files"]}
            found[RESULT_FILE] = _digest(encoded(to_json(content)))
            changed = [name for name, digest in seal["files"].items() if found[name] != digest]
            problem = f"{changed[0]} was changed" if changed else ""
            if seal["key"] != job.key:
                problem = f"it is the run {seal['key']}"
            row = row_of(job, content, note) if not problem else {}
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise InputError(str(folder), NOT_AS_STORED) from error
        if problem:
            raise InputError(str(folder), f"{NOT_AS_STORED}: {problem}")
        return row


def _digest(content: bytes) -> str:
    return f"sha256:{hashlib.sha256(content).hexdigest()}"
