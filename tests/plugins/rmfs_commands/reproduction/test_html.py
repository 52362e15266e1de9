"""The report as one HTML file."""

from __future__ import annotations

import re
from base64 import b64encode

import pytest

from rmfs_commands.cli.grids import Grid
from rmfs_commands.experiments.report.plots import Plot
from rmfs_commands.reproduction.html import to_html
from rmfs_commands.reproduction.plots import DRAWINGS
from rmfs_commands.reproduction.report import Report

pytestmark = pytest.mark.slow


def test_html_needs_nothing_else(report: Report) -> None:
    """Pictures are inside; texts are escaped; nothing is fetched."""
    html = to_html(report)
    assert html.count("data:image/svg+xml;base64,") == len(DRAWINGS)
    assert "The paper&#39;s evaluation" in html
    assert not re.search(r'(?:src|href)="(?!data:)', html)


def test_everything_of_a_report_is_shown() -> None:
    """Facts, titles, notes and cells, escaped; pictures as they are."""
    grid = Grid("Figure 1: <Visits>", ("A & B",), ("what", "ours"), (("a < b", "1.5"),), right=(1,))
    html = to_html(Report({"Command": "rmfs reproduce"}, [grid, Plot("p", "A plot", b"<svg>1</svg>", b"", b"")]))
    for text in ("rmfs reproduce", "Figure 1: &lt;Visits&gt;", "A &amp; B", "a &lt; b", "1.5", "A plot"):
        assert text in html
    assert b64encode(b"<svg>1</svg>").decode() in html


def test_verdicts_have_colours() -> None:
    """What agrees and what does not are told apart; other cells have no class of theirs."""

    def classes(cell: str) -> set[str]:
        html = to_html(Report({}, [Grid("t", (), ("verdict",), ((cell,),))]))
        return {name for name in ("good", "bad") if re.search(rf'class="[^"]*\b{name}\b[^"]*"', html)}

    assert classes("in range") == classes("same") == classes("holds") == {"good"}
    assert classes("above") == classes("no complete run") == classes("does not hold") == {"bad"}
    assert classes("2.0 times faster") == classes("holds in 1 of 2") == set()


def test_equal_reports_are_equal_files(report: Report) -> None:
    """Nothing of the time of writing is in them."""
    assert to_html(report) == to_html(Report(dict(report.facts), [*report.content]))
