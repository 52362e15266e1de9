"""The files of a comparison."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from attrs import evolve
from rich.console import Console

from rmfs_commands.experiments import ExperimentResult
from rmfs_commands.experiments.report import print_comparison, write_report
from rmfs_core.errors import InputError
from rmfs_core.results.catalogue import Metric


def test_the_same_runs_give_the_same_files(result: ExperimentResult, tmp_path: Path) -> None:
    """Report, tables and plots hold no dates and no random ids."""
    for name in ("one", "two"):
        write_report(result, result.comparison(), tmp_path / name)
    files = sorted(path.relative_to(tmp_path / "one") for path in (tmp_path / "one").rglob("*.*"))
    assert len(files) == 3 + 3 * 4 + 3
    for file in files:
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes(), file
    names = {file.as_posix() for file in files}
    assert {"summary.csv", "runs.parquet", "report.html", "plots/differences.svg", "plots/pile_on.png"} <= names


def test_a_folder_that_cannot_be_made_is_refused(result: ExperimentResult, tmp_path: Path) -> None:
    """A file is in the way; it stays as it is."""
    (tmp_path / "file").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match="file"):
        write_report(result, result.comparison(), tmp_path / "file")
    assert (tmp_path / "file").read_text(encoding="utf-8") == "mine"


def test_an_observers_metric_is_called_what_it_likes(
    result: ExperimentResult, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its plot is a file beside that of all differences; its label is neither markup nor a formula."""
    label = "Price [s] [/nope] in $^$"
    rows = [row | {"differences": row["seed"] * 1.5} for row in result.rows]
    experiment = evolve(result.experiment, metrics=("differences", "pile_on"))
    measures = {"differences": Metric("differences", label)}
    one = evolve(result, rows=rows, experiment=experiment, measures=measures)
    comparison = one.comparison()
    write_report(one, comparison, tmp_path)
    print_comparison(Console(width=120, markup=False), one, comparison)  # as `output_console` has it
    assert label in capsys.readouterr().out
    plots = {path.name for path in (tmp_path / "plots").glob("*.svg")}
    assert plots == {"differences.svg", "metrics.differences.svg", "pile_on.svg"}
    assert len(set(re.findall(r'<img src="([^"]+)"', (tmp_path / "report.html").read_text("utf-8")))) == 3
