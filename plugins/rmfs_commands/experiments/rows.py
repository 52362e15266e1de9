"""One run as one row: labels, how it ended, and every figure."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from typing import Any

from rmfs_commands.experiments.experiment import Job

Row = dict[str, Any]


def row_of(job: Job, content: Mapping[str, Any], note: Mapping[str, Any]) -> Row:
    """Return the row of a run.

    Parameters
    ----------
    job
        The run.
    content
        Content of its result.json: ``status``, ``metrics``, ``timing``, ``error`` if it failed.
    note
        Further values: ``error_kind``, and ``run_s``, the seconds of the whole run with its preparation.
    """
    row = {
        **labels(job),
        "status": content["status"],
        "error": content.get("error"),
        "error_kind": note["error_kind"],
    }
    figures = {"run_s": note["run_s"], **dict(_flat(content["timing"])), "key": job.key}
    # What an observer measures under a name that something else has is no less there, and hides nothing.
    taken = row.keys() | figures.keys()
    metrics = {f"metrics.{name}" if name in taken else name: value for name, value in content["metrics"].items()}
    return {sys.intern(name): value for name, value in (row | metrics | figures).items()}  # the same in every row


def _flat(tables: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Yield nested figures under dotted names: ``hook_s.plan_path``."""
    for name, value in tables.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{above}{name}.")
        else:
            yield f"{above}{name}", value


def row_without_result(job: Job, error: str, kind: str) -> Row:
    """Return the row of a run that ended without a result."""
    return {**labels(job), "status": "failed", "error": error, "error_kind": kind, "key": job.key}


def labels(job: Job) -> Row:
    """Return what tells a run apart: instance, axis values, rule set and seed."""
    return {"instance": job.instance, **job.axes, "rule_set": job.rule_set, "seed": job.seed}
