"""The report as one HTML file that needs neither network nor other files."""

from __future__ import annotations

from pathlib import Path

from rmfs_commands.cli.not_simulated import NOT_SIMULATED
from rmfs_commands.cli.pages import render
from rmfs_commands.reproduction.report import TITLE, Report
from rmfs_commands.reproduction.tables import ABOVE, BELOW, IN_RANGE, NO_RUN

GOOD = (IN_RANGE, "same", "holds")
BAD = (BELOW, ABOVE, NO_RUN, "differs", "does not hold")
"""Verdicts by the colour they get; others have none."""


def to_html(report: Report) -> str:
    """Return the report with its plots inside."""
    return render(
        Path(__file__).parent / "report.html.j2",
        title=TITLE,
        report=report,
        not_simulated=NOT_SIMULATED,
        verdict_class=lambda cell: "good" if cell in GOOD else "bad" if cell in BAD else "",
    )
