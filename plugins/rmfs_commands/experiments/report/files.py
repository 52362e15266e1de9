"""The files of a comparison."""

from __future__ import annotations

from pathlib import Path

from rmfs_commands.cli.latex import to_latex
from rmfs_commands.experiments.compare import Comparison
from rmfs_commands.experiments.report.html import report_html
from rmfs_commands.experiments.report.plots import make_plots
from rmfs_commands.experiments.report.repeating import repeating
from rmfs_commands.experiments.report.tables import grids, summary_csv, write_parquet
from rmfs_commands.experiments.running import ExperimentResult
from rmfs_commands.results.files import AtomicFile, json_ready, output_folder, to_json, write_text

SUMMARY_FILE = "summary.csv"
PARQUET_FILE = "runs.parquet"
REPORT_FILE = "report.html"
REPEATING_FILE = "experiment.json"
PLOTS_FOLDER = "plots"
TABLES_FOLDER = "tables"


ONE_COLUMN_CM = 7.7
"""Of a page of two columns: those of journals are 8 to 9 cm wide, those of LaTeX's `article` on A4 are 7.8."""


def write_report(
    result: ExperimentResult, comparison: Comparison, folder: str | Path, width_cm: float = ONE_COLUMN_CM
) -> None:
    """Write report.html, tables, plots and what is needed to repeat the experiment, each file whole or not at all.

    Parameters
    ----------
    result, comparison
        The experiment's result to report.
    folder
        Where to.
    width_cm
        How wide the plots are.

    Raises
    ------
    InputError
        When the folder cannot be written to.
    """
    path = output_folder(folder)
    plots = make_plots(result.rows, comparison)
    for plot in make_plots(result.rows, comparison, width_cm / 2.54):
        for file, content in plot.files.items():
            with AtomicFile(output_folder(path / PLOTS_FOLDER) / file) as stream:
                stream.write(content)
    for name, grid in grids(comparison).items():
        write_text(output_folder(path / TABLES_FOLDER) / f"{name}.tex", to_latex(grid, name))
    write_text(path / SUMMARY_FILE, summary_csv(comparison))
    write_parquet(result, path / PARQUET_FILE)
    write_text(path / REPEATING_FILE, to_json(json_ready(repeating(result)), indent=2) + "\n")
    write_text(path / REPORT_FILE, report_html(result, comparison, plots))
