"""The report from rows of every part: complete, and written whole."""

from __future__ import annotations

import pytest

from rmfs_commands.cli.grids import Grid
from rmfs_commands.reproduction.paper import load_paper
from rmfs_commands.reproduction.report import Report, make_report

pytestmark = pytest.mark.slow


def grid(report: Report, start: str) -> Grid:
    """Return the one grid whose title starts so."""
    (found,) = (entry for entry in report.grids if entry.title.startswith(start))
    return found


def test_every_exhibit_of_the_paper_is_in_the_report(report: Report) -> None:
    """Each is a grid of its own, or stands among those that no run can give figures for."""
    titles = [entry.title for entry in report.grids]
    for exhibit in load_paper().values():
        title = f"{exhibit.item}: {exhibit.caption}"
        assert title in titles or title in [row[0] for row in grid(report, "Not in this report").rows]


def test_lines_show_mean_interval_and_runs(report: Report) -> None:
    """Relative figures of equal runs are 1 without spread; a failed run's pair is missing where it should be."""
    first = grid(report, "Figure 10").rows[0]
    assert first == ("50 orders, integrated", "0.70 to 0.80", "1.000 ± 0.000", "above", "2")
    assert grid(report, "Figure 16").rows[0][-1] == "1 of 2"


def test_the_overview_counts_verdicts(report: Report) -> None:
    """Nine figures of Figure 10, all 1.0 of sequential, lie above their ranges; all computing times are compared."""
    outcome = {row[0]: row[2:] for row in grid(report, "Overview").rows}
    assert outcome["Figure 10"] == ("9", "9 above")
    assert outcome["Figure 11"] == ("9", "9 no number in the paper")
    assert outcome["Table 4"] == ("12", "from 5.0 times faster to 670 times faster")


def test_failed_runs_are_shown(report: Report) -> None:
    """In the counts, and each with its error."""
    (counts,) = (entry for entry in report.grids if entry.title == "Runs")
    assert ("large", "sequential", "2", "1", "0", "1", "1", "0", "3.0") in counts.rows
    (lost,) = grid(report, "Runs that did not complete").rows
    assert lost == ("large", "one, sequential, seed 1", "failed", "robot 3 | waits for 4")


def test_a_report_on_some_parts_says_what_is_missing(row) -> None:
    """No tables, no plots, no settings of parts that were not run; and it is the same every time, plots and all."""
    parts = {"packing": [row("packing-10"), row()]}
    report = make_report(parts, [], {})
    again = make_report(parts, [], {})
    assert [*report.content] == [*again.content]
    missing = [cells[0] for cells in grid(report, "Not in this report").rows]
    assert missing[1:] == ["Part examples", "Part instances", "Part prefilter", "Part large"]
    assert [plot.name for plot in report.plots] == ["distributions"]
    titles = [entry.title for entry in report.grids]
    assert not any(title.startswith(("Tables 1", "Figure 10", "What Section")) for title in titles)
