"""The files of a reproduction."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from pyarrow import parquet

from rmfs_commands.cli.grids import Grid
from rmfs_commands.experiments import ExperimentResult
from rmfs_commands.experiments.report.plots import Plot
from rmfs_commands.experiments.rows import row_without_result
from rmfs_commands.reproduction.html import to_html
from rmfs_commands.reproduction.markdown import to_markdown
from rmfs_commands.reproduction.parts import PARTS, experiment_of
from rmfs_commands.reproduction.report import Report
from rmfs_commands.reproduction.report_files import write_report
from rmfs_core.errors import InputError

REPORT = Report({}, [Grid("Runs", (), ("a",), (("b",),)), Plot("visits", "Visits", b"<svg/>", b"png", b"pdf")])


@pytest.fixture(scope="module")
def result() -> Any:
    """Return the runs of the examples, all of which failed."""
    experiment = experiment_of(PARTS[0])
    rows = [row_without_result(job, "the worker died", "WorkerDiedError") for job in experiment.jobs()]
    return ExperimentResult(experiment, rows, computed=len(rows))


def test_everything_is_written(result: Any, tmp_path: Path) -> None:
    """The report in both forms, each plot in both, a table of runs for each part; the names are returned."""
    out = tmp_path / "new" / "folder"
    names = write_report(REPORT, {"examples": result}, out)
    plots, tables = ["visits.png", "visits.svg", "visits.pdf"], ["tables/runs.tex", "tables/runs.csv"]
    assert names == ["report.html", "report.md", *plots, *tables, "runs-examples.parquet"]
    assert sorted(path.relative_to(out).as_posix() for path in out.rglob("*.*")) == sorted(names)
    assert (out / "tables/runs.csv").read_text(encoding="utf-8") == "a\nb\n"
    assert (out / "report.md").read_text(encoding="utf-8") == to_markdown(REPORT)
    assert (out / "report.html").read_text(encoding="utf-8") == to_html(REPORT)
    assert ((out / "visits.png").read_bytes(), (out / "visits.svg").read_bytes()) == (b"png", b"<svg/>")
    assert parquet.read_table(out / "runs-examples.parquet")["status"].to_pylist() == ["failed"] * len(result.rows)


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    """A file is in the way."""
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="file"):
        write_report(REPORT, {}, tmp_path / "file")
