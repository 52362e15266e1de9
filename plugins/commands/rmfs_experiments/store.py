"""Finished runs on disk: one folder each, named by the run's key, there whole or not at all."""

from __future__ import annotations

import json
import shutil
import uuid
from pathlib import Path

from rmfs_core.errors import InputError
from rmfs_core.results import RESULT_FILE
from rmfs_core.results.files import output_folder, to_json, write_text
from rmfs_experiments.experiment import Job
from rmfs_experiments.outcome import Outcome
from rmfs_experiments.rows import Row, row_of

NOTE_FILE = "run.json"


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

    def save(self, job: Job, outcome: Outcome) -> None:
        """Store a run that has a result. It is written beside its place and renamed: a kill leaves no half run."""
        if outcome.result is None:
            raise ValueError("a run without a result has nothing to be stored")
        beside = self.folder / f".{job.key}.{uuid.uuid4().hex[:12]}.part"
        try:
            outcome.result.save(beside)
            note = {"run": str(job), "error_kind": outcome.error_kind, "run_s": outcome.run_s}
            write_text(beside / NOTE_FILE, to_json(note, indent=2) + "\n")
            beside.rename(self.folder / job.key)
        except BaseException as error:  # Ctrl-C as well
            shutil.rmtree(beside, ignore_errors=True)
            if not isinstance(error, OSError) or job not in self:  # else another process has stored the same run
                raise

    def row(self, job: Job) -> Row:
        """Read a stored run as a row.

        Raises
        ------
        InputError
            When its files are not what was stored.
        """
        folder = self.folder / job.key
        try:
            content, note = (json.loads((folder / name).read_text("utf-8")) for name in (RESULT_FILE, NOTE_FILE))
            return row_of(job, content, note)
        except (OSError, ValueError, KeyError, TypeError) as error:
            problem = "is not as it was stored; delete the folder, and the run is computed again"
            raise InputError(str(folder), problem) from error
