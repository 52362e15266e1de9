"""The report as one HTML file that needs neither network nor other files."""

from __future__ import annotations

import base64
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from rmfs_commands.cli.not_simulated import NOT_SIMULATED
from rmfs_commands.reproduction.report import TITLE, Report
from rmfs_commands.reproduction.tables import ABOVE, BELOW, IN_RANGE, NO_RUN

GOOD = (IN_RANGE, "same", "holds")
BAD = (BELOW, ABOVE, NO_RUN, "differs", "does not hold")
"""Verdicts by the colour they get; others have none."""


def to_html(report: Report) -> str:
    """Return the report with its plots inside."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("report.html.j2").render(
        title=TITLE,
        report=report,
        embedded=_embedded,
        not_simulated=NOT_SIMULATED,
        verdict_class=lambda cell: "good" if cell in GOOD else "bad" if cell in BAD else "",
    )


def _embedded(svg: bytes) -> str:
    return f"data:image/svg+xml;base64,{base64.b64encode(svg).decode('ascii')}"
