"""`rmfs reproduce`, from the command line to its files."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner
from pyarrow import parquet

from rmfs_commands.cli.main import main, rmfs
from rmfs_commands.experiments import ExperimentResult
from rmfs_commands.experiments.rows import row_without_result


def reproduce(*arguments: str):
    """Run the command."""
    return CliRunner().invoke(rmfs, ["reproduce", *arguments])


def lines_of(report: Path, start: str) -> list[list[str]]:
    """Return the cells of the lines of report.md that start so."""
    lines = report.read_text(encoding="utf-8").splitlines()
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line.startswith(f"| {start}")]


@pytest.mark.slow
def test_the_examples(tmp_path: Path) -> None:
    """The five examples have the paper's visits; a second call finds them stored and writes the same tables."""
    done = reproduce("--only", "examples", "--jobs", "1", "--out", str(tmp_path))
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
    again = reproduce("--only", "examples", "--jobs", "1", "--out", str(tmp_path))
    assert again.exit_code == 0
    second = report.read_text(encoding="utf-8")
    assert "5 were stored already" in second
    assert second[second.index("## Overview") :] == first[first.index("## Overview") :]


@pytest.mark.slow
def test_quick(tmp_path: Path) -> None:
    """One seed of the set of 50 orders: all runs complete, every plot of the part is there."""
    done = reproduce("--quick", "--out", str(tmp_path))
    assert done.exit_code == 0, done.output
    assert parquet.read_table(tmp_path / "runs-instances.parquet").num_rows == 40
    report = tmp_path / "report.md"
    assert [line[4] for line in lines_of(report, "50 orders, integrated")[:2]] == ["8", "8"]
    assert "45 different runs, of which 0 failed; solves that a time limit stopped: 0." in report.read_text(
        encoding="utf-8"
    )
    for name in ("relative-to-sequential", "turnover", "computing-time", "distributions"):
        assert (tmp_path / f"{name}.png").exists() and (tmp_path / f"{name}.svg").exists()


@pytest.mark.slow
def test_a_failed_run_is_reported_and_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The report is written all the same, with the error; the command ends with exit code 1."""

    def fail_all(experiment, **_):
        rows = [row_without_result(job, "the worker died", "WorkerDiedError") for job in experiment.jobs()]
        return ExperimentResult(experiment, rows, computed=len(rows))

    monkeypatch.setattr("rmfs_commands.reproduction.reproducing.run_experiment", fail_all)
    with pytest.raises(SystemExit) as ended:
        main(["reproduce", "--only", "examples", "--out", str(tmp_path)])
    assert ended.value.code == 1
    report = tmp_path / "report.md"
    assert "5 different runs, of which 5 failed" in report.read_text(encoding="utf-8")
    assert lines_of(report, "examples | examples/example-appendix")[0][2:] == ["failed", "the worker died"]
    assert lines_of(report, "example-appendix")[0][3] == "no complete run"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--only", "packin"), 'there is no part "packin" (did you mean'),
        (("--quick", "--only", "large"), "large has no part in --quick"),
    ],
)
def test_wrong_arguments(tmp_path: Path, arguments: tuple[str, ...], message: str) -> None:
    """One sentence, and nothing is written."""
    out = tmp_path / "out"
    done = reproduce(*arguments, "--out", str(out))
    assert message in str(done.exception)
    assert not out.exists()
