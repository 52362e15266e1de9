"""Finished runs on disk: one folder each, named by the run's key, there whole or not at all.

The result.json of a stored run has the key inside and the digests of all its files: that of itself is of all the rest
of it. So a run that was changed by hand, or copied from another place, is not taken for one that was computed.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import uuid
from pathlib import Path
from typing import Any

from rmfs_commands.experiments.experiment import Job
from rmfs_commands.experiments.outcome import Outcome
from rmfs_commands.experiments.rows import Row, row_of
from rmfs_core.errors import InputError
from rmfs_core.results import RESULT_FILE
from rmfs_core.results.files import hold, output_folder, to_json, write_text

NOTE_FILE = "run.json"
PART = ".part"
SEAL = "stored"
"""The key of result.json under which stand the run's key and the digests of its files."""
NOT_AS_STORED = "is not as it was stored"


class RunStore:
    """A folder of finished runs.

    Parameters
    ----------
    folder
        Where the runs are; made when it is not there.

    Raises
    ------
    InputError
        When it cannot be written to.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = output_folder(folder)

    def __contains__(self, job: Job) -> bool:
        return (self.folder / job.key).is_dir()

    def problem(self, job: Job) -> str | None:
        """Say what is wrong with a stored run: its files are not those that were stored, or are another run's."""
        try:
            self._read(job)
        except InputError as error:
            return str(error)
        return None

    def save(self, job: Job, outcome: Outcome) -> None:
        """Store a run that has a result. It is written beside its place and renamed: a kill leaves no half run.

        What is there already stays, unless something is wrong with it.
        """
        if outcome.result is None:
            raise ValueError("a run without a result has nothing to be stored")
        beside = self.folder / f".{job.key}.{uuid.uuid4().hex[:12]}{PART}"
        beside.mkdir()
        held = os.open(beside, os.O_RDONLY)
        hold(held)
        try:
            outcome.result.save(beside)
            note = {"run": str(job), "error_kind": outcome.error_kind, "run_s": outcome.run_s}
            write_text(beside / NOTE_FILE, to_json(note | {"sources": dict(job.sources)}, indent=2) + "\n")
            _seal(beside, job.key)
            if job in self and self.problem(job) is not None:
                aside = beside.with_name(f"{beside.name}.old{PART}")
                (self.folder / job.key).rename(aside)
                shutil.rmtree(aside, ignore_errors=True)
            beside.rename(self.folder / job.key)
        except BaseException as error:  # Ctrl-C as well
            shutil.rmtree(beside, ignore_errors=True)
            if not isinstance(error, OSError) or job not in self:  # else another process has stored the same run
                raise
        finally:
            os.close(held)

    def row(self, job: Job) -> Row:
        """Read a stored run as a row.

        Raises
        ------
        InputError
            When its files are not what was stored.
        """
        content, note = self._read(job)
        return row_of(job, content, note)

    def _read(self, job: Job) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return a stored run's result.json and note; raise `InputError` when they are not what was stored."""
        folder = self.folder / job.key
        try:
            content, note = (json.loads((folder / name).read_text("utf-8")) for name in (RESULT_FILE, NOTE_FILE))
            seal = content.pop(SEAL)
            found = {name: _digest((folder / name).read_bytes()) for name in seal["files"]}
            found[RESULT_FILE] = _digest(to_json(content).encode())
            changed = [name for name, digest in seal["files"].items() if found[name] != digest]
            problem = f"{changed[0]} was changed" if changed else ""
            if seal["key"] != job.key:
                problem = f"it is the run {seal['key']}"
            if not problem:
                row_of(job, content, note)
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise InputError(str(folder), NOT_AS_STORED) from error
        if problem:
            raise InputError(str(folder), f"{NOT_AS_STORED}: {problem}")
        return content, note


def _seal(folder: Path, key: str) -> None:
    """Put the key of a run and the digests of its files into its result.json."""
    content = json.loads((folder / RESULT_FILE).read_text("utf-8"))
    files = {file.name: _digest(file.read_bytes()) for file in sorted(folder.iterdir())}
    files[RESULT_FILE] = _digest(to_json(content).encode())
    write_text(folder / RESULT_FILE, to_json(content | {SEAL: {"key": key, "files": files}}, indent=2) + "\n")


def _digest(content: bytes) -> str:
    return f"sha256:{hashlib.sha256(content).hexdigest()}"
