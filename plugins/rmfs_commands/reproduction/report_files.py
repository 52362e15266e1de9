"""The files of a reproduction."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rmfs_commands.cli.grids import file_name
from rmfs_commands.cli.latex import write_grid
from rmfs_commands.experiments import ExperimentResult
from rmfs_commands.experiments.report import TABLES_FOLDER
from rmfs_commands.experiments.report.tables import write_parquet
from rmfs_commands.reproduction.html import to_html
from rmfs_commands.reproduction.markdown import to_markdown
from rmfs_commands.reproduction.report import Report
from rmfs_commands.results.files import AtomicFile, output_folder, write_text

HTML_FILE = "report.html"
MARKDOWN_FILE = "report.md"


def write_report(report: Report, results: Mapping[str, ExperimentResult], folder: Path) -> list[str]:
    """Write report.html, report.md, plots as PNG, SVG and PDF, tables as LaTeX and CSV, and all runs of each part.

    Parameters
    ----------
    report
        The report to write.
    results
        Runs by the name of the part, for ``runs-<part>.parquet``.
    folder
        Where; made when it is not there.

    Returns
    -------
    list of str
        Names of the files.

    Raises
    ------
    InputError
        When the folder cannot be written to.
    """
    path = output_folder(folder)
    names = [HTML_FILE, MARKDOWN_FILE]
    for plot in report.plots:
        for name, picture in plot.files.items():
            names.append(name)
            with AtomicFile(path / name) as stream:
                stream.write(picture)
    for grid in report.grids:
        for ending in ("tex", "csv"):
            names.append(f"{TABLES_FOLDER}/{file_name(grid.title)}.{ending}")
            write_grid(grid, output_folder(path / TABLES_FOLDER) / Path(names[-1]).name)
    for part, result in results.items():
        names.append(f"runs-{part}.parquet")
        write_parquet(result, path / names[-1])
    write_text(path / MARKDOWN_FILE, to_markdown(report))
    write_text(path / HTML_FILE, to_html(report))
    return names
