"""A reproduction from start to end, with runs that are made up."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rmfs_commands.experiments import Experiment, ExperimentResult, Watcher
from rmfs_commands.experiments.rows import labels, row_without_result
from rmfs_commands.reproduction import reproducing
from rmfs_commands.reproduction.parts import PARTS, choose_parts
from rmfs_commands.reproduction.reproducing import Reproduction, reproduce

Row = dict[str, Any]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, row: Callable[..., Row]) -> Callable[..., list[dict[str, Any]]]:
    """Return the function that makes all runs up, the first ``failed`` of each part failed, ``stored`` of them stored.

    It returns a list that holds what each experiment was run with.
    """

    def make(failed: int = 0, stored: int = 0) -> list[dict[str, Any]]:
        asked: list[dict[str, Any]] = []

        def run_experiment(experiment: Experiment, **how: Any) -> ExperimentResult:
            asked.append({"experiment": experiment, **how})
            jobs = experiment.jobs()
            rows = [row_without_result(job, "the worker died", "WorkerDiedError") for job in jobs[:failed]]
            rows += [row(run_s=60.0) | labels(job) | {"key": job.key} for job in jobs[failed:]]
            return ExperimentResult(experiment, rows, computed=len(rows) - stored)

        monkeypatch.setattr(reproducing, "run_experiment", run_experiment)
        monkeypatch.setattr("rmfs_commands.reproduction.report.DRAWN_SEEDS", [1])  # what is drawn is not looked at here
        monkeypatch.setattr("rmfs_commands.reproduction.report.draw", lambda tables: {})
        return asked

    return make


def reproduced(out: Path, *only: str, **how: Any) -> Reproduction:
    """Reproduce some parts."""
    return reproduce(choose_parts(only), out, **how)


def test_each_part_is_run_and_told(run: Callable[..., Any], tmp_path: Path) -> None:
    """Runs are kept in one folder for all parts; whoever watches is asked for by the experiment's name."""
    asked, watched = run(), []

    def watch(name: str) -> Watcher:
        watched.append(name)
        return Watcher()

    done = reproduced(tmp_path, "examples", "packing", jobs=3, dask="host", watch=watch, command="rmfs reproduce")
    assert [entry["experiment"].name for entry in asked] == watched
    assert len(watched) == 2
    assert [(entry["store"], entry["jobs"], entry["dask"]) for entry in asked] == [(tmp_path / "runs", 3, "host")] * 2
    assert {"report.md", "runs-examples.parquet", "runs-packing.parquet"} <= set(done.files)
    assert done.report.facts["Command"] == "rmfs reproduce"
    assert done.failed == []


def test_the_facts_say_what_was_computed(run: Callable[..., Any], tmp_path: Path) -> None:
    """How many runs, how many of them stored before, and how long they take by themselves."""
    run(stored=2)
    facts = reproduced(tmp_path, "examples").report.facts
    assert "s for 3 runs; 2 were stored already; the 5 runs' own times add up to 5.0 min" in facts["Time"]
    assert list(facts) == ["Command", "Time", "Machine", "Versions"]
    run()
    assert (
        facts["Time"].replace("for 3 runs; 2 were stored already", "for 5 runs").split(" for ")[1]
        == (reproduced(tmp_path, "examples").report.facts["Time"].split(" for ")[1])
    )


def test_failed_runs_are_kept_apart(run: Callable[..., Any], tmp_path: Path) -> None:
    """They have rows like all others; without a time they add nothing to the sum."""
    run(failed=4)
    done = reproduced(tmp_path, "examples")
    assert len(done.rows) == 5
    assert [row["error"] for row in done.failed] == ["the worker died"] * 4
    assert "own times add up to 60.0 s" in done.report.facts["Time"]


def test_runs_that_parts_share_are_there_once(run: Callable[..., Any], tmp_path: Path) -> None:
    """Packing and prefilter have runs of sequential in common."""
    asked = run()
    done = reproduced(tmp_path, "packing", "prefilter")
    assert len(done.rows) < sum(len(entry["experiment"].jobs()) for entry in asked)
    assert len({row["key"] for row in done.rows}) == len(done.rows)


def test_quick_is_the_first_seed_of_the_smallest_set(run: Callable[..., Any], tmp_path: Path) -> None:
    """Settings are those of the instances that were run."""
    asked = run()
    done = reproduce([part for part in PARTS if part.name == "instances"], tmp_path, quick=True)
    assert {(job.seed, job.axes["instance.orders"]) for job in asked[0]["experiment"].jobs()} == {(1, 50)}
    assert any(grid.rows[0][0] == "Section 4.1" for grid in done.report.grids if grid.title == "Overview")
    run()
    without = reproduced(tmp_path, "examples").report
    assert not any(grid.rows[0][0] == "Section 4.1" for grid in without.grids if grid.title == "Overview")
