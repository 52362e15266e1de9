"""The report from rows of every part: complete, and written whole."""

from __future__ import annotations

import re

import pytest

from rmfs_core.scenario import load_scenario
from rmfs_reproduction.extensions import PREFILTER, prefiltered
from rmfs_reproduction.grids import Grid, number
from rmfs_reproduction.html import to_html
from rmfs_reproduction.instance_sets import METHODS
from rmfs_reproduction.markdown import to_markdown
from rmfs_reproduction.paper import load_paper
from rmfs_reproduction.plots import DRAWINGS
from rmfs_reproduction.report import Report, make_report


@pytest.fixture(scope="module")
def report(row) -> Report:
    """Return the report on two seeds of everything; one run of the large part failed."""
    unfiltered = ("sequential", "split-among-stations")
    rule_sets = {
        "instances": METHODS,
        "packing": (*unfiltered, "packing-10"),
        "prefilter": (*unfiltered, *map(prefiltered, PREFILTER)),
        "large": METHODS,
    }
    parts = {
        part: [
            row(rule_set, seed, orders=orders, psv_per_order=1 + seed / 10)
            for rule_set in names
            for seed in (1, 2)
            for orders in ((50, 150, 250) if part == "instances" else (250,))
        ]
        for part, names in rule_sets.items()
    }
    parts["examples"] = [row(instance=name) for name in load_paper()["examples"].values]
    parts["large"][0] |= {"status": "failed", "error": "robot 3 | waits for 4", "error_kind": "StandstillError"}
    return make_report(parts, [load_scenario("paper-250")], {"Command": "rmfs reproduce"})


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


def test_plots_are_there(report: Report) -> None:
    """Every drawing as SVG and PNG, without a date."""
    assert [plot.name for plot in report.plots] == list(DRAWINGS)
    for plot in report.plots:
        assert plot.png.startswith(b"\x89PNG")
        assert b"<svg" in plot.svg
        assert b"dc:date" not in plot.svg


def test_a_report_on_some_parts_says_what_is_missing(row) -> None:
    """No tables, no plots, no settings of parts that were not run; and it is the same every time, plots and all."""
    parts = {"packing": [row("packing-10"), row()]}
    report = make_report(parts, [], {})
    assert to_html(report) == to_html(make_report(parts, [], {}))
    missing = [cells[0] for cells in grid(report, "Not in this report").rows]
    assert missing[1:] == ["Part examples", "Part instances", "Part prefilter", "Part large"]
    assert [plot.name for plot in report.plots] == ["distributions"]
    titles = [entry.title for entry in report.grids]
    assert not any(title.startswith(("Tables 1", "Figure 10", "What Section")) for title in titles)


def test_markdown_tables_are_well_formed(report: Report) -> None:
    """Every row of a table has as many cells as its head; a bar within a cell is escaped."""
    text = to_markdown(report)
    assert "- Command: `rmfs reproduce`" in text
    assert r"robot 3 \| waits for 4" in text
    for block in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
        cells = [len(re.split(r"(?<!\\)\|", line)) for line in block.splitlines()]
        assert len(set(cells)) == 1, block
    for plot in report.plots:
        assert f"({plot.name}.png)" in text


def test_html_needs_nothing_else(report: Report) -> None:
    """Pictures are inside; texts are escaped; nothing is fetched."""
    html = to_html(report)
    assert html.count("data:image/svg+xml;base64,") == len(DRAWINGS)
    assert "The paper&#39;s evaluation" in html
    assert not re.search(r'(?:src|href)="(?!data:)', html)


@pytest.mark.parametrize(("value", "text"), [(0.0, "0"), (0.012345, "0.01235"), (1.0034, "1.003"), (12345.0, "12,345")])
def test_four_significant_digits(value: float, text: str) -> None:
    """However small or large."""
    assert number(value) == text
