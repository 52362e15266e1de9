"""The files of a reproduction."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rmfs_core.results.files import AtomicFile, output_folder, write_text
from rmfs_experiments import ExperimentResult
from rmfs_experiments.report.tables import write_parquet
from rmfs_reproduction.html import to_html
from rmfs_reproduction.markdown import to_markdown
from rmfs_reproduction.report import Report

HTML_FILE = "report.html"
MARKDOWN_FILE = "report.md"


def write_report(report: Report, results: Mapping[str, ExperimentResult], folder: Path) -> list[str]:
    """Write report.html, report.md, the plots as PNG and SVG, and a table of all runs for each part.

    Parameters
    ----------
    report
        What to write.
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
        for ending, picture in (("png", plot.png), ("svg", plot.svg)):
            names.append(f"{plot.name}.{ending}")
            with AtomicFile(path / names[-1]) as stream:
                stream.write(picture)
    for part, result in results.items():
        names.append(f"runs-{part}.parquet")
        write_parquet(result, path / names[-1])
    write_text(path / MARKDOWN_FILE, to_markdown(report))
    write_text(path / HTML_FILE, to_html(report))
    return names
