"""A run as one row of a table."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from rmfs_commands.experiments import Experiment, Job
from rmfs_commands.experiments.rows import labels, row_of, row_without_result

NOTE = {"error_kind": None, "run_s": 2.5}


@pytest.fixture
def job(experiment: Callable[..., Experiment]) -> Job:
    """Return a run of the tiny scenario."""
    return experiment().jobs()[0]


def content(metrics: Mapping[str, Any], timing: Mapping[str, Any], **others: Any) -> dict[str, Any]:
    """Return what a result.json holds."""
    return {"status": "complete", "metrics": metrics, "timing": timing, **others}


def test_labels_tell_a_run_apart(job: Job) -> None:
    """Instance, axes (the scenario is one), rule set and seed."""
    assert labels(job) == {"instance": "tiny", "scenario": "tiny", "rule_set": "pod-match", "seed": 1}


def test_figures_are_flat(job: Job) -> None:
    """Nested ones have dotted names."""
    timing = {"wall_s": 2.0, "hook_s": {"plan_path": 0.5}}
    row = row_of(job, content({"picks": 7}, timing), NOTE)
    figures = {"picks", "run_s", "wall_s", "hook_s.plan_path"}
    assert row.keys() == {*labels(job), "status", "error", "error_kind", *figures, "key"}
    assert (row["picks"], row["wall_s"], row["hook_s.plan_path"], row["run_s"]) == (7, 2.0, 0.5, 2.5)
    assert (row["status"], row["error"], row["key"]) == ("complete", None, job.key)


def test_a_metric_hides_nothing(job: Job) -> None:
    """One that is called like a label or a time gets a name of its own."""
    row = row_of(job, content({"seed": -5.5, "wall_s": 9.0, "own": 1}, {"wall_s": 2.0}), NOTE)
    assert (row["seed"], row["metrics.seed"]) == (1, -5.5)
    assert (row["wall_s"], row["metrics.wall_s"]) == (2.0, 9.0)
    assert row["own"] == 1


def test_a_failed_run_has_its_error(job: Job) -> None:
    """With the kind that was noted beside its result."""
    failed = content({}, {}, error="no idea") | {"status": "failed"}
    row = row_of(job, failed, {"error_kind": "RuleError", "run_s": 1.0})
    assert (row["status"], row["error"], row["error_kind"]) == ("failed", "no idea", "RuleError")


def test_a_run_without_a_result_has_labels_and_error_alone(job: Job) -> None:
    """No figure of it is made up."""
    row = row_without_result(job, "it died", "WorkerDiedError")
    assert row == labels(job) | {
        "status": "failed",
        "error": "it died",
        "error_kind": "WorkerDiedError",
        "key": job.key,
    }
