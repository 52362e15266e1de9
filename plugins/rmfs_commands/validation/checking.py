"""Validation of what a run left in a folder."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from attrs import frozen

from rmfs_commands.trace.reader import fitting, read_trace, trace_file
from rmfs_commands.validation.case import avoids_collisions
from rmfs_commands.validation.fault import Fault
from rmfs_commands.validation.opening import made_alike
from rmfs_commands.validation.validator import faults_of
from rmfs_core.errors import InputError
from rmfs_core.results import RESULT_FILE


@frozen
class Report:
    """Outcome of a validation.

    Parameters
    ----------
    faults
        In the order of time.
    events
        Number of events in the trace.
    collisions_checked
        Whether robots were checked for collisions.
    metrics_checked
        Whether there were reported metrics to compare.
    start_checked
        Whether layout, orders and locations could be compared with those of the scenario.
    floor
        Of a real day: what its trace says of the floor; None: a simulated run.
    """

    faults: list[Fault]
    events: int
    collisions_checked: bool
    metrics_checked: bool
    start_checked: bool
    floor: Mapping[str, float | None] | None = None


def validate_trace(path: str | Path) -> list[Fault]:
    """Return everything that is wrong with a recorded run, in the order of time.

    Parameters
    ----------
    path
        The folder of a run with ``trace.jsonl.gz``, or a trace file. When ``result.json`` is next to the trace, its
        metrics must be the same as from the trace, and so must the figures of the tables next to it.

    Raises
    ------
    InputError
        When a file is missing, damaged or not what it should be.
    """
    return check_trace(path).faults


def check_trace(path: str | Path, *, collisions: bool | None = None) -> Report:
    """Validate a recorded run as `validate_trace` does, and report what was checked too.

    ``collisions``: whether no two robots may hold a cell at once; None: if the PP rule keeps robots apart.
    """
    file = trace_file(path)
    trace = read_trace(file)
    result = read_result(file.parent / RESULT_FILE)
    tables = None if result is None else file.parent
    with fitting(file, "checked"):
        if collisions is None or trace.floor is not None:
            collisions = trace.floor is None and avoids_collisions(trace)
        faults = faults_of(trace, result, collisions=collisions, tables=tables)
    return Report(faults, len(trace.events), collisions, result is not None, made_alike(trace, result), trace.floor)


def read_result(file: Path) -> Mapping[str, Any] | None:
    """Return the content of result.json; None when there is none."""
    if not file.exists():
        return None
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(str(file), f"cannot be read as JSON: {error}") from error
    if not isinstance(content, Mapping) or not isinstance(content.get("metrics"), Mapping):
        raise InputError(str(file), "expected a result that rmfs has written, with the key `metrics`")
    return content
