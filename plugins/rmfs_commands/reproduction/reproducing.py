"""A reproduction from start to end: run the parts, put the report together, write it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from attrs import field, frozen

from rmfs_commands.experiments import ExperimentResult, Watcher, run_experiment
from rmfs_commands.reproduction.counts import distinct
from rmfs_commands.reproduction.estimates import Row, Rows
from rmfs_commands.reproduction.machine import machine, versions
from rmfs_commands.reproduction.parts import Part, experiment_of
from rmfs_commands.reproduction.report import Report, make_report
from rmfs_commands.reproduction.report_files import write_report
from rmfs_core.scenario import Scenario

RUNS_FOLDER = "runs"


@frozen(eq=False)
class Reproduction:
    """Outcome of a reproduction.

    Parameters
    ----------
    report
        The report.
    rows
        One per run; runs that several parts share are there once.
    files
        Names of the files written.
    """

    report: Report
    rows: list[Row] = field(repr=False)
    files: list[str]

    @property
    def failed(self) -> list[Row]:
        """Rows of the runs that failed."""
        return [row for row in self.rows if row["status"] == "failed"]


def reproduce(
    parts: Sequence[Part],
    out: Path,
    *,
    quick: bool = False,
    command: str = "",
    jobs: int | None = None,
    dask: str | None = None,
    watch: Callable[[str], Watcher] = lambda _: Watcher(),
) -> Reproduction:
    """Run what is not stored in ``out/runs`` yet; write the report.

    Parameters
    ----------
    parts
        Parts to run, see `choose_parts`.
    out
        Folder for finished runs and the report.
    quick
        Whether to run the first seed of the smallest instance set alone.
    command
        The command that made the report, as it is shown there.
    jobs, dask
        As for `run_experiment`.
    watch
        Returns who is told how an experiment goes on, for its name.

    Raises
    ------
    InputError
        When ``out`` cannot be written to.
    """
    started = time.perf_counter()
    results: dict[str, ExperimentResult] = {}
    for part in parts:
        experiment = experiment_of(part, quick)
        results[part.name] = run_experiment(
            experiment, store=out / RUNS_FOLDER, jobs=jobs, dask=dask, watcher=watch(experiment.name)
        )
    seconds = time.perf_counter() - started
    rows = {name: result.rows for name, result in results.items()}
    facts = _facts(command, distinct(rows), sum(result.computed for result in results.values()), seconds)
    report = make_report(rows, _scenarios(results), facts)
    return Reproduction(report, distinct(rows), write_report(report, results, out))


def _scenarios(results: dict[str, ExperimentResult]) -> list[Scenario]:
    """Return the scenarios of the 24 instances under every rule set, one seed of each."""
    if "instances" not in results:
        return []
    experiment = results["instances"].experiment
    return [job.scenario for job in experiment.jobs() if job.seed == experiment.seeds[0]]


def _facts(command: str, rows: Rows, computed: int, seconds: float) -> dict[str, str]:
    own = sum(row.get("run_s") or 0.0 for row in rows)
    time_taken = f"{_minutes(seconds)} for {computed:,} runs"
    if computed < len(rows):
        time_taken += f"; {len(rows) - computed:,} were stored already"
    return {
        "Command": command,
        "Time": f"{time_taken}; the {len(rows):,} runs' own times add up to {_minutes(own)}",
        "Machine": ", ".join(f"{name} {value}" for name, value in machine().items()),
        "Versions": ", ".join(f"{name} {version}" for name, version in versions().items()),
    }


def _minutes(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds < 120 else f"{seconds / 60:.1f} min"
