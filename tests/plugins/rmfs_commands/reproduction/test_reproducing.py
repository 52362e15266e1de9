"""`rmfs reproduce` from its parts to its files, and what it ran on."""

import os
import platform
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from pyarrow import parquet

from cases import cases
from rmfs_commands.cli.main import main, rmfs
from rmfs_commands.experiments import Experiment, ExperimentResult, Watcher
from rmfs_commands.experiments.rows import labels, row_without_result
from rmfs_commands.reproduction import machine as module
from rmfs_commands.reproduction import reproducing
from rmfs_commands.reproduction.extensions import PREFILTER, prefiltered
from rmfs_commands.reproduction.instance_sets import METHODS, SIX_ORDERS
from rmfs_commands.reproduction.machine import machine, processor, versions
from rmfs_commands.reproduction.parts import PARTS, choose_parts, experiment_of
from rmfs_commands.reproduction.reproducing import Reproduction, reproduce
from rmfs_core.scenario import load_scenario

RUNS = {"examples": 5, "instances": 1200, "packing": 240, "prefilter": 880, "large": 320}


def test_runs_of_parts(jobs) -> None:
    assert {part: len(found) for part, found in jobs.items()} == RUNS
    assert {part: len({job.key for job in found}) for part, found in jobs.items()} == RUNS
    names = {part.name: [rule_set.name for rule_set in experiment_of(part).rule_sets] for part in PARTS}
    assert names["large"] == list(METHODS)
    assert sorted(names["instances"]) == sorted([*METHODS, SIX_ORDERS])
    assert names["packing"] == ["sequential", "split-among-stations", "packing-10"]
    assert names["prefilter"] == ["sequential", "split-among-stations", *map(prefiltered, PREFILTER)]
    keys = {part: {job.key for job in found} for part, found in jobs.items()}
    assert len(keys["packing"] & keys["instances"]) == 160
    assert len(keys["prefilter"] & keys["instances"]) == 160
    parts = choose_parts(quick=True)
    jobs = {part.name: experiment_of(part, quick=True).jobs() for part in parts}
    assert {name: len(found) for name, found in jobs.items()} == {"examples": 5, "instances": 40}
    assert {job.scenario.instance.orders for job in jobs["instances"]} == {50}
    assert [part.name for part in choose_parts(("large", "packing"))] == ["packing", "large"]
    assert choose_parts() == list(PARTS)


def test_rules_are_those_of_the_shipped_scenarios(jobs) -> None:
    for base, part, instance in (
        ("paper-250", "instances", "orders=250, skus=100, pods=100, skus_per_pod=3"),
        ("paper-2000", "large", "skus=100, pods=100, skus_per_pod=3"),
    ):
        ours = {job.rule_set: job.scenario for job in jobs[part] if job.instance == instance and job.seed == 1}
        for method in METHODS:
            name = base if method == "sequential" else f"{base}-{method}"
            assert ours[method] == load_scenario(name)


def test_the_machine_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    found = machine()
    assert list(found) == ["processor", "cores", "system", "python"]
    assert all(found.values())
    assert platform.python_version() in found["python"]
    assert platform.system() in found["system"]
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 5, 7}, raising=False)
    assert machine()["cores"] == "3"
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.setattr(os, "cpu_count", lambda: 12)
    assert machine()["cores"] == "12"
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert machine()["cores"] == "1"


@cases(
    "text platforms expected",
    ("processor : 0\nmodel name\t: Some CPU @ 2 GHz\nmodel name\t: Another\n", "x", "Some CPU @ 2 GHz"),
    ("processor : 0\n", "arm", "arm"),
    (None, "arm", "arm"),
    (None, "", "unknown"),
)
def test_the_processor_is_called_as_the_system_calls_it(text, platforms, expected, monkeypatch) -> None:
    def read(path: Path, encoding: str) -> str:
        if text is None:
            raise FileNotFoundError(path)
        return text

    monkeypatch.setattr(Path, "read_text", read)
    monkeypatch.setattr(platform, "processor", lambda: platforms)
    assert processor() == expected


def test_versions_of_what_figures_depend_on(monkeypatch: pytest.MonkeyPatch) -> None:
    found = versions()
    assert found["numpy"] == version("numpy")
    assert found["rmfs"] == version("rmfs")

    def without_mip(name: str) -> str:
        if name == "mip":
            raise PackageNotFoundError(name)
        return "1.0"

    monkeypatch.setattr(module, "version", without_mip)
    assert versions() == dict.fromkeys(found, "1.0") | {"mip": "not installed"}


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
    return reproduce(choose_parts(only), out, **how)


def test_each_part_is_run_and_told(run: Callable[..., Any], tmp_path: Path) -> None:
    """Runs are kept in one folder for all parts; whoever watches is asked for by the experiment's name."""
    asked, watched = run(), []

    def watch(name: str) -> Watcher:
        watched.append(name)
        return Watcher()

    done = reproduced(tmp_path, "examples", "packing", jobs=3, dask="host", watch=watch, command="rmfs reproduce")
    assert ([entry["experiment"].name for entry in asked], len(watched)) == (watched, 2)
    assert [(entry["store"], entry["jobs"], entry["dask"]) for entry in asked] == [(tmp_path / "runs", 3, "host")] * 2
    assert {"report.md", "runs-examples.parquet", "runs-packing.parquet"} <= set(done.files)
    assert done.report.facts["Command"] == "rmfs reproduce"
    assert done.failed == []


def test_the_facts_say_what_was_computed(run: Callable[..., Any], tmp_path: Path) -> None:
    run(stored=2)
    facts = reproduced(tmp_path, "examples").report.facts
    assert "s for 3 runs; 2 were stored already; the 5 runs' own times add up to 5.0 min" in facts["Time"]
    assert list(facts) == ["Command", "Time", "Machine", "Versions"]
    run()
    assert " for 5 runs; the 5 runs' own times" in reproduced(tmp_path, "examples").report.facts["Time"]


def test_runs_of_reproductions(run: Callable[..., Any], tmp_path: Path) -> None:
    run(failed=4)
    done = reproduced(tmp_path, "examples")
    assert (len(done.rows), [row["error"] for row in done.failed]) == (5, ["the worker died"] * 4)
    assert "own times add up to 60.0 s" in done.report.facts["Time"]
    asked = run()
    done = reproduced(tmp_path, "packing", "prefilter")
    assert len(done.rows) < sum(len(entry["experiment"].jobs()) for entry in asked)
    assert len({row["key"] for row in done.rows}) == len(done.rows)


def test_quick_is_the_first_seed_of_the_smallest_set(run: Callable[..., Any], tmp_path: Path) -> None:
    asked = run()
    done = reproduce([part for part in PARTS if part.name == "instances"], tmp_path, quick=True)
    assert {(job.seed, job.axes["instance.orders"]) for job in asked[0]["experiment"].jobs()} == {(1, 50)}
    assert any(grid.rows[0][0] == "Section 4.1" for grid in done.report.grids if grid.title == "Overview")
    run()
    without = reproduced(tmp_path, "examples").report
    assert not any(grid.rows[0][0] == "Section 4.1" for grid in without.grids if grid.title == "Overview")


def called(*arguments: str):
    return CliRunner().invoke(rmfs, ["reproduce", *arguments])


def lines_of(report: Path, start: str) -> list[list[str]]:
    lines = report.read_text(encoding="utf-8").splitlines()
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line.startswith(f"| {start}")]


@pytest.mark.slow
def test_the_examples(tmp_path: Path) -> None:
    done = called("--only", "examples", "--jobs", "1", "--out", str(tmp_path))
    assert done.exit_code == 0, done.output
    report = tmp_path / "report.md"
    assert [line[1:4] for line in lines_of(report, "example-2-sequential")] == [
        ["6.0", "6.0", "in range"],
        ["2.0", "2.0", "in range"],
    ]
    assert all(line[3] == "in range" for line in lines_of(report, "example-"))
    assert (tmp_path / "report.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert parquet.read_table(tmp_path / "runs-examples.parquet").num_rows == 5
    first = report.read_text(encoding="utf-8")
    assert "for 5 runs" in first
    assert called("--only", "examples", "--jobs", "1", "--out", str(tmp_path)).exit_code == 0
    second = report.read_text(encoding="utf-8")
    assert "5 were stored already" in second
    assert second[second.index("## Overview") :] == first[first.index("## Overview") :]


@pytest.mark.slow
def test_quick(tmp_path: Path) -> None:
    done = called("--quick", "--out", str(tmp_path))
    assert done.exit_code == 0, done.output
    assert parquet.read_table(tmp_path / "runs-instances.parquet").num_rows == 40
    report = tmp_path / "report.md"
    assert [line[4] for line in lines_of(report, "50 orders, integrated")[:2]] == ["8", "8"]
    assert "45 different runs, of which 0 failed; solves that a time limit stopped: 0." in report.read_text(
        encoding="utf-8"
    )
    for name in ("relative-to-sequential", "turnover", "computing-time", "distributions"):
        assert (tmp_path / f"{name}.png").exists() and (tmp_path / f"{name}.svg").exists()


def test_a_failed_run_is_reported_and_counted(run: Callable[..., Any], tmp_path: Path) -> None:
    run(failed=5)
    with pytest.raises(SystemExit) as ended:
        main(["reproduce", "--only", "examples", "--out", str(tmp_path)])
    assert ended.value.code == 1
    report = tmp_path / "report.md"
    assert "5 different runs, of which 5 failed" in report.read_text(encoding="utf-8")
    assert lines_of(report, "examples | examples/example-appendix")[0][2:] == ["failed", "the worker died"]
    assert lines_of(report, "example-appendix")[0][3] == "no complete run"


@cases(
    "arguments message",
    (("--only", "packin"), 'there is no part "packin" (did you mean'),
    (("--quick", "--only", "large"), "large has no part in --quick"),
)
def test_wrong_arguments(tmp_path: Path, arguments: tuple[str, ...], message: str) -> None:
    out = tmp_path / "out"
    assert message in str(called(*arguments, "--out", str(out)).exception)
    assert not out.exists()
