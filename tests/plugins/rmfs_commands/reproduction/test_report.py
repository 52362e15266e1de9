"""The report: grids of text, Markdown, HTML, pictures and files."""

import re
from base64 import b64encode
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
from pyarrow import parquet

from cases import cases
from rmfs_commands.cli.grids import Grid
from rmfs_commands.experiments import ExperimentResult
from rmfs_commands.experiments.report.plots import Plot
from rmfs_commands.experiments.rows import row_without_result
from rmfs_commands.reproduction.estimates import Estimate
from rmfs_commands.reproduction.grids import number, settings_grid, statements_grid, table_grid
from rmfs_commands.reproduction.html import to_html
from rmfs_commands.reproduction.instance_sets import METHODS, instance_set_tables
from rmfs_commands.reproduction.markdown import to_markdown
from rmfs_commands.reproduction.overview import overview
from rmfs_commands.reproduction.paper import Exhibit, Range, load_paper
from rmfs_commands.reproduction.parts import PARTS, experiment_of
from rmfs_commands.reproduction.plots import DRAWINGS, computing_time, draw, relative_figures, turnover
from rmfs_commands.reproduction.report import Report, make_report
from rmfs_commands.reproduction.report_files import write_report
from rmfs_commands.reproduction.settings import Setting
from rmfs_commands.reproduction.statements import Comparison, Statement
from rmfs_commands.reproduction.tables import Line, Table, as_factor, in_range

EXHIBIT = Exhibit("visits", "fig:visits", "Figure 10", "Visits", "They are fewer.")
PRINTED = Exhibit("time", "tab:time", "Table 4", "Time", "It is short.", rounded_to=0.01)


def cells(*lines: Line, exhibit: Exhibit = EXHIBIT, digits: int = 2) -> tuple[tuple[str, ...], ...]:
    return table_grid(Table(exhibit, lines, "", digits)).rows


def test_cells_of_tables() -> None:
    line = in_range(("50 orders", "integrated"), Range(0.7, 0.8), Estimate(0.75, 0.01, 8, 8))
    grid = table_grid(Table(EXHIBIT, (line,), "s", 2, what="a mean"))
    assert (grid.title, grid.notes) == ("Figure 10: Visits", ("The paper: They are fewer.", "Here: a mean."))
    assert grid.columns == ("", "paper (s)", "ours (s)", "verdict", "runs")
    assert grid.rows == (("50 orders, integrated", "0.70 to 0.80", "0.75 ± 0.01", "in range", "8"),)
    assert table_grid(Table(EXHIBIT, (line,), "", 2)).columns[:3] == ("", "paper", "ours")
    (unprinted,) = cells(in_range(("a",), None, Estimate(2.0, None, 1, 1)))
    assert unprinted[1:] == ("-", "2.00", "no number in the paper", "1")
    assert cells(in_range(("a",), Range(1.0, 2.0), None))[0][1:] == ("1.00 to 2.00", "-", "no complete run", "0")
    assert cells(in_range(("a",), Range(1.0, 2.0), Estimate(2.0, None, 1, 3)))[0][-1] == "1 of 3"


def test_figures_and_statements() -> None:
    ours = Estimate(1234.56789, 0.5, 2, 2)
    assert cells(in_range(("a",), Range(0.7, 0.8), ours), digits=4)[0][1:3] == ("0.70 to 0.80", "1,234.5679 ± 0.5000")
    (printed,) = cells(in_range(("a",), Range(1.0, 2.0, 1.5), ours), exhibit=PRINTED, digits=0)
    assert printed[1:3] == ("1.50", "1,235 ± 0")
    assert cells(in_range(("a",), Range(1.5, 1.5, 1.5), ours), digits=1)[0][1] == "1.5"
    grid = settings_grid(EXHIBIT, [Setting("Robots", "8", "8"), Setting("PP", "WHCA*n", "sipp")])
    assert grid.rows == (("Robots", "8", "8", "same"), ("PP", "WHCA*n", "sipp", "differs"))
    fine, wrong = Comparison("50 orders", 0.5, 1.0), Comparison("150 orders", 1234.5, 0.0123456)
    both = [Statement("Figure 11", "It is less.", (fine, wrong)), Statement("Figure 12", "It is, too.", (fine,))]
    assert statements_grid(both).rows == (
        ("Figure 11", "It is less.", "holds in 1 of 2", "150 orders: 1,234 against 0.01235"),
        ("Figure 12", "It is, too.", "holds", ""),
    )


@cases("value text", (0.0, "0"), (0.012345, "0.01235"), (1.0034, "1.003"), (12345.0, "12,345"), (-2.5, "-2.500"))
def test_four_significant_digits(value: float, text: str) -> None:
    assert number(value) == text


@pytest.mark.slow
def test_html_needs_nothing_else(report: Report) -> None:
    html = to_html(report)
    assert html.count("data:image/svg+xml;base64,") == len(DRAWINGS)
    assert "The paper&#39;s evaluation" in html
    assert not re.search(r'(?:src|href)="(?!data:)', html)


@pytest.mark.slow
def test_everything_of_a_report_is_shown() -> None:
    grid = Grid("Figure 1: <Visits>", ("A & B",), ("what", "ours"), (("a < b", "1.5"),), right=(1,))
    html = to_html(Report({"Command": "rmfs reproduce"}, [grid, Plot("p", "A plot", b"<svg>1</svg>", b"", b"")]))
    for text in ("rmfs reproduce", "Figure 1: &lt;Visits&gt;", "A &amp; B", "a &lt; b", "1.5", "A plot"):
        assert text in html
    assert b64encode(b"<svg>1</svg>").decode() in html


@pytest.mark.slow
def test_verdicts_have_colours() -> None:
    def classes(cell: str) -> set[str]:
        html = to_html(Report({}, [Grid("t", (), ("verdict",), ((cell,),))]))
        return {name for name in ("good", "bad") if re.search(rf'class="[^"]*\b{name}\b[^"]*"', html)}

    assert classes("in range") == classes("same") == classes("holds") == {"good"}
    assert classes("above") == classes("no complete run") == classes("does not hold") == {"bad"}
    assert classes("2.0 times faster") == classes("holds in 1 of 2") == set()


def test_markdown_tables_are_well_formed(report: Report) -> None:
    text = to_markdown(report)
    assert "- Command: `rmfs reproduce`" in text
    assert r"robot 3 \| waits for 4" in text
    for block in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
        cells = [len(re.split(r"(?<!\\)\|", line)) for line in block.splitlines()]
        assert len(set(cells)) == 1, block
    for plot in report.plots:
        assert f"({plot.name}.png)" in text


def test_a_small_report() -> None:
    grid = Grid("Figure 1: Visits", ("A note.", "Another."), ("what", "ours"), (("two\nlines", "1.5"),), right=(1,))
    report = Report({"Command": "rmfs reproduce", "Time": "3 s"}, [grid, Plot("visits", "Visits drawn", b"", b"", b"")])
    assert (
        to_markdown(report)
        == """\
# The paper's evaluation, and ours

- Command: `rmfs reproduce`
- Time: 3 s

## Figure 1: Visits

A note.

Another.

| what | ours |
|---|---:|
| two lines | 1.5 |

![Visits drawn](visits.png)
"""
    )


ONE = Range(0.9, 1.1)


def at(mean: float) -> Estimate:
    return Estimate(mean, None, 1, 1)


def outcome(*lines: Line) -> str:
    (row,) = overview([Table(EXHIBIT, lines, "", 2)], [], []).rows
    assert row[:3] == ("Figure 10", "Visits", str(len(lines)))
    return row[3]


def test_the_order_of_the_overview() -> None:
    lines = [
        in_range(("a",), ONE, at(2.0)),
        in_range(("b",), ONE, None),
        in_range(("c",), None, at(1.0)),
        in_range(("d",), ONE, at(0.1)),
        in_range(("e",), ONE, at(1.0)),
        in_range(("f",), ONE, at(1.1)),
    ]
    assert outcome(*lines) == "2 in range, 1 below, 1 above, 1 no number in the paper, 1 no complete run"
    fast, slow = as_factor(("a",), ONE, at(0.01)), as_factor(("b",), ONE, at(2.0))
    assert outcome(fast, slow) == "from 2.0 times slower to 100 times faster"
    assert outcome(fast, as_factor(("c",), None, at(1.0))) == (
        "1 no number in the paper; from 100 times faster to 100 times faster"
    )
    table = Table(EXHIBIT, (in_range(("a",), ONE, at(1.0)),), "", 2)
    settings = [Setting("Robots", "8", "8"), Setting("PP", "WHCA*n", "sipp"), Setting("PR", "nearest", "nearest")]
    held = Statement("Figure 11", "It is less.", (Comparison("50 orders", 0.5, 1.0),))
    grid = overview([table], settings, [held, Statement("Figure 12", "So.", ())])
    assert grid.rows == (
        ("Section 4.1", "Settings", "3", "2 same, 1 differs"),
        ("Figure 10", "Visits", "1", "1 in range"),
        ("Section 4.2", "What it says in words", "2", "1 holds, 1 no complete run"),
    )


def tables(row: Any, **figures: Any) -> Mapping[str, Table]:
    rows: Sequence[Any] = [
        row(rule_set, seed, orders=orders, **figures)
        for rule_set in METHODS
        for seed in (1, 2)
        for orders in (50, 150, 250)
    ]
    return {table.exhibit.name: table for table in instance_set_tables(rows, load_paper())}


def test_plots_are_there_where_all_their_tables_are(report: Report, row: Any) -> None:
    assert [plot.name for plot in report.plots] == list(DRAWINGS)
    for plot in report.plots:
        assert plot.png.startswith(b"\x89PNG")
        assert b"<svg" in plot.svg
        assert b"dc:date" not in plot.svg
    given = tables(row)
    few = {name: given[name] for name in ("turnover", "computing-time", "pod-station-visits", "distances")}
    drawn = draw(few)
    assert list(drawn) == ["turnover"]
    assert draw(few) == drawn


def test_bars_and_scales(row: Any) -> None:
    figure = relative_figures(tables(row))
    for axis in figure.axes:
        ours = [bar for bar in axis.patches if bar.get_fill()]
        assert [bar.get_height() for bar in ours] == [1.0] * 9
        assert [text.get_text() for text in axis.get_xticklabels()] == ["50 orders", "150 orders", "250 orders"]
        assert axis.get_ylim()[0] == 0
    figure = turnover(tables(row, turnover_backlog_s=600.0, turnover_station_s=120.0))
    (axis,) = figure.axes
    bars = [(bar.get_y(), bar.get_height()) for bar in axis.patches]
    assert sorted(set(bars)) == [(0.0, 10.0), (10.0, 2.0)]
    assert len(bars) == 2 * 3 * len(METHODS)
    figure = computing_time(tables(row, decision_s_first=0.5, decision_s_later=0.02))
    first, later, _ = figure.axes
    assert (first.get_yscale(), first.get_ylim()[0], later.get_ylim()[0]) == ("log", 0.1, 0.01)
    assert [axis.get_title() for axis in (first, later)] == ["Seconds a run, t = 1", "Seconds a run, t > 1"]


def test_the_legend_names_the_methods_and_the_paper(row: Any) -> None:
    def names(figure: Any) -> list[str]:
        return [text.get_text() for legend in figure.legends for text in legend.get_texts()]

    given = tables(row)
    assert names(relative_figures(given)) == [*METHODS[1:], "the paper's range"]
    assert names(computing_time(given)) == [*METHODS, "the paper's figure"]
    assert names(turnover(given)) == [*METHODS]


def grid(report: Report, start: str) -> Grid:
    (found,) = (entry for entry in report.grids if entry.title.startswith(start))
    return found


@pytest.mark.slow
def test_every_exhibit_of_the_paper_is_in_the_report(report: Report) -> None:
    titles = [entry.title for entry in report.grids]
    for exhibit in load_paper().values():
        title = f"{exhibit.item}: {exhibit.caption}"
        assert title in titles or title in [row[0] for row in grid(report, "Not in this report").rows]


@pytest.mark.slow
def test_lines_show_mean_interval_and_runs(report: Report) -> None:
    first = grid(report, "Figure 10").rows[0]
    assert first == ("50 orders, integrated", "0.70 to 0.80", "1.000 ± 0.000", "above", "2")
    assert grid(report, "Figure 16").rows[0][-1] == "1 of 2"


@pytest.mark.slow
def test_the_overview_counts_verdicts(report: Report) -> None:
    """Nine figures of Figure 10, all 1.0 of sequential, lie above their ranges; all computing times are compared."""
    outcome = {row[0]: row[2:] for row in grid(report, "Overview").rows}
    assert outcome["Figure 10"] == ("9", "9 above")
    assert outcome["Figure 11"] == ("9", "9 no number in the paper")
    assert outcome["Table 4"] == ("12", "from 5.0 times faster to 670 times faster")


@pytest.mark.slow
def test_failed_runs_are_shown(report: Report) -> None:
    (counts,) = (entry for entry in report.grids if entry.title == "Runs")
    assert ("large", "sequential", "2", "1", "0", "1", "1", "0", "3.0") in counts.rows
    (lost,) = grid(report, "Runs that did not complete").rows
    assert lost == ("large", "one, sequential, seed 1", "failed", "robot 3 | waits for 4")


@pytest.mark.slow
def test_a_report_on_some_parts_says_what_is_missing(row) -> None:
    parts = {"packing": [row("packing-10"), row()]}
    report = make_report(parts, [], {})
    again = make_report(parts, [], {})
    assert [*report.content] == [*again.content]
    missing = [cells[0] for cells in grid(report, "Not in this report").rows]
    assert missing[1:] == ["Part examples", "Part instances", "Part prefilter", "Part large"]
    assert [plot.name for plot in report.plots] == ["distributions"]
    titles = [entry.title for entry in report.grids]
    assert not any(title.startswith(("Tables 1", "Figure 10", "What Section")) for title in titles)


REPORT = Report({}, [Grid("Runs", (), ("a",), (("b",),)), Plot("visits", "Visits", b"<svg/>", b"png", b"pdf")])


@pytest.fixture(scope="module")
def result() -> Any:
    experiment = experiment_of(PARTS[0])
    rows = [row_without_result(job, "the worker died", "WorkerDiedError") for job in experiment.jobs()]
    return ExperimentResult(experiment, rows, computed=len(rows))


def test_everything_is_written(result: Any, tmp_path: Path) -> None:
    out = tmp_path / "new" / "folder"
    names = write_report(REPORT, {"examples": result}, out)
    plots, tables = ["visits.png", "visits.svg", "visits.pdf"], ["tables/runs.tex", "tables/runs.csv"]
    assert names == ["report.html", "report.md", *plots, *tables, "runs-examples.parquet"]
    assert sorted(path.relative_to(out).as_posix() for path in out.rglob("*.*")) == sorted(names)
    assert (out / "tables/runs.csv").read_text(encoding="utf-8") == "a\nb\n"
    assert (out / "report.md").read_text(encoding="utf-8") == to_markdown(REPORT)
    assert (out / "report.html").read_text(encoding="utf-8") == to_html(REPORT)
    assert ((out / "visits.png").read_bytes(), (out / "visits.svg").read_bytes()) == (b"png", b"<svg/>")
    assert parquet.read_table(out / "runs-examples.parquet")["status"].to_pylist() == ["failed"] * len(result.rows)
