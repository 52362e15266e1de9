"""Figures of a reproduction, from rows with known answers, and the report: text, Markdown, HTML, pictures, files."""

import re
from base64 import b64encode
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve
from pyarrow import parquet

from cases import cases
from rmfs_commands.cli.grids import Grid
from rmfs_commands.experiments import ExperimentResult
from rmfs_commands.experiments.report.plots import Plot
from rmfs_commands.experiments.rows import row_without_result
from rmfs_commands.reproduction.counts import count, unfinished
from rmfs_commands.reproduction.distributions import (
    distribution_tables,
    order_lengths,
    sku_probabilities,
    truncated_geometric,
)
from rmfs_commands.reproduction.estimates import Estimate, estimate, mean_of, metric, relative
from rmfs_commands.reproduction.extensions import large_tables, packing_tables, prefilter_tables
from rmfs_commands.reproduction.grids import number, settings_grid, statements_grid, table_grid
from rmfs_commands.reproduction.html import to_html
from rmfs_commands.reproduction.instance_sets import METHODS, implied_makespan, instance_set_tables
from rmfs_commands.reproduction.markdown import to_markdown
from rmfs_commands.reproduction.overview import overview
from rmfs_commands.reproduction.paper import Exhibit, Range, load_paper
from rmfs_commands.reproduction.parts import PARTS, experiment_of
from rmfs_commands.reproduction.plots import DRAWINGS, computing_time, draw, relative_figures, turnover
from rmfs_commands.reproduction.report import Report, make_report
from rmfs_commands.reproduction.report_files import write_report
from rmfs_commands.reproduction.settings import Setting, settings
from rmfs_commands.reproduction.statements import Comparison, Statement, statements
from rmfs_commands.reproduction.tables import NO_NUMBER, NO_RUN, Line, Table, as_factor, in_range
from rmfs_commands.testing import small_instance
from rmfs_core.scenario import RuleChoice, load_scenario


def test_nothing_is_hidden(row) -> None:
    lost = {key: row("integrated", seed=3)[key] for key in ("instance", "rule_set", "seed")}
    rows = [
        row(solves_stopped_early=2),
        row(seed=2, status="partial"),
        row("integrated", seed=2, status="failed", error="nobody moves", error_kind="StandstillError"),
        lost | {"status": "failed", "error": "the worker died", "error_kind": "WorkerDiedError"},
    ]
    sequential, integrated = count({"instances": rows})
    assert (sequential.runs, sequential.complete, sequential.partial, sequential.failed) == (2, 1, 1, 0)
    assert (sequential.stopped_early, sequential.seconds) == (2, 3.0)
    assert (integrated.runs, integrated.complete, integrated.failed, integrated.stood_still) == (2, 0, 2, 1)
    assert [(part, one["rule_set"], one["seed"]) for part, one in unfinished({"instances": rows})] == [
        ("instances", "sequential", 2),
        ("instances", "integrated", 2),
        ("instances", "integrated", 3),
    ]


FOUR_ORDERS = small_instance({"a": ["2"], "b": ["1"], "c": ["1", "2"], "d": ["1"]}, {})


def test_the_papers_distributions() -> None:
    assert truncated_geometric(0.5, 2) == pytest.approx([2 / 3, 1 / 3])
    table = order_lengths(load_paper()["order-lengths"], {1: FOUR_ORDERS})
    assert [line.ours.mean for line in table.lines[:3] if line.ours] == [0.75, 0.25, 0.0]
    assert len(table.lines) == 20
    table = sku_probabilities(load_paper()["sku-probabilities"], {1: FOUR_ORDERS})
    assert [line.ours.mean for line in table.lines[:2] if line.ours] == pytest.approx([2 / 3, 1 / 3])
    tables = distribution_tables(range(1, 11), load_paper())
    verdicts = [line.verdict for table in tables for line in table.lines if line.label[0] not in BEYOND]
    assert verdicts.count("in range") >= len(verdicts) - 4


BEYOND = {f"length {length}" for length in range(16, 21)}
"""Longer than a station's item capacity: never generated."""


def test_estimates() -> None:
    found = estimate([(1, 1.0), (1, 3.0), (2, 4.0), (2, 6.0)])
    assert found.mean == 3.5
    assert found.half_width == pytest.approx(12.7062 * 1.5, rel=1e-4)
    assert (found.runs, found.expected) == (4, 4)
    found = estimate([(1, 1.0), (1, 3.0)])
    assert found is not None and found.half_width is None
    found = estimate([(1, 1.0), (1, None), (2, None)])
    assert (found.mean, found.runs, found.expected) == (1.0, 1, 3)
    assert estimate([(1, None)]) is None
    assert estimate([]) is None


def test_prefilter(row) -> None:
    rows = [
        row("sequential", psv_per_order=1.95),
        row("split-among-stations", psv_per_order=1.0, decision_s_later=10.0),
        row("most-covered-10", psv_per_order=1.17, decision_s_later=1.0, decision_percent_of_simulated=1.03),
    ]
    curve, share = prefilter_tables(rows, load_paper())
    of_ten = {line.label[1]: (line.ours.mean, line.verdict) for line in curve.lines if line.ours}
    assert of_ten == {
        "pod-station visits, to no prefilter": (1.17, "in range"),
        "pod-station visits, to sequential": (0.6, "in range"),
        "computing time t > 1, to no prefilter": (0.1, "in range"),
    }
    assert share.lines[0].verdict == "1.0 times faster"
    assert [line.verdict for line in share.lines[1:]] == ["no complete run"] * 8


def test_figures_of_the_packing_capacity_and_large_sets(row) -> None:
    rows = [
        row("sequential", psv_per_order=1.0, distance_per_order_m=100.0),
        row("integrated", psv_per_order=1.05, distance_per_order_m=99.0),
    ]
    table, _ = large_tables(rows, load_paper())
    verdicts = {line.label: line.verdict for line in table.lines}
    assert verdicts["integrated", "pod-station visits"] == "in range"
    assert verdicts["integrated", "robot distance"] == "below"
    assert verdicts["split-over-time", "robot distance"] == "no complete run"
    visits = {"sequential": 1.0, "packing-10": 0.65, "split-among-stations": 0.3}
    rows = [row(name, psv_per_order=number) for name, number in visits.items()]
    (table,) = packing_tables(rows, load_paper())
    assert [line.verdict for line in table.lines] == ["in range", "below"]


def tables_of(rows) -> dict[str, Table]:
    return {table.exhibit.name: table for table in instance_set_tables(rows, load_paper())}


def verdict(table: Table, *label: str) -> str:
    (line,) = (line for line in table.lines if line.label == label)
    return line.verdict


def test_visits_relative_to_sequential(row) -> None:
    """0.75 of the sequential visits lie in the paper's range of 20 % to 30 % fewer; half of them in "about 50 %"."""
    rows = [row(name, psv_per_order=number) for name, number in zip(METHODS, (2.0, 1.5, 1.0, 1.0), strict=True)]
    table = tables_of(rows)["pod-station-visits"]
    assert [line.label for line in table.lines] == [("50 orders", method) for method in METHODS[1:]]
    assert [line.ours.mean for line in table.lines if line.ours] == [0.75, 0.5, 0.5]
    assert [line.verdict for line in table.lines] == ["in range", "in range", "above"]


def test_the_second_baseline_is_sequential_with_six_orders(row) -> None:
    """Item capacity costs the sequential rules a quarter more visits; a model that saves 40 % of these saves 25 %."""
    visits = {"sequential": 2.5, "sequential, 6 orders": 2.0, "split-among-stations": 1.5}
    rows = [row(name, psv_per_order=number) for name, number in visits.items()]
    table = tables_of(rows)["second-baseline"]
    six = table.ours("50 orders", "visits", "sequential, 6 orders to sequential")
    model = table.ours("50 orders", "visits", "split-among-stations to sequential, 6 orders")
    assert (six.mean, model.mean) == (0.8, 0.75)


def test_pile_on_and_turnover(row) -> None:
    rows = [row(orders=orders, pile_on=1.0) for orders in (50, 250)]
    rows += [row("split-over-time", orders=50, pile_on=3.0), row("split-over-time", orders=250, pile_on=5.5)]
    table = tables_of(rows)["pile-on"]
    assert verdict(table, "50 orders", "split-over-time") == "no number in the paper"
    assert verdict(table, "highest of the sets", "split-over-time") == "in range"
    table = tables_of([row(turnover_backlog_s=300.0, turnover_station_s=60.0)])["turnover"]
    means = [table.ours("50 orders", "sequential", part).mean for part in ("backlog", "station")]
    assert means == [300.0, 60.0]
    assert verdict(table, "50 orders", "integrated", "backlog") == "no complete run"
    computed = {"decision_percent_of_simulated": 0.0339, "decision_s_per_order": 0.048}
    tables = tables_of([row("integrated", orders=250, **computed)])
    assert verdict(tables["share-of-simulated-time"], "250 orders", "integrated") == "100 times faster"
    assert verdict(tables["time-per-order"], "250 orders", "integrated") == "10 times faster"


def test_makespans_beside_the_implied_one(row) -> None:
    found = implied_makespan(Range(0.475, 0.485, 0.48), Range(3.385, 3.395, 3.39), 250)
    assert found.low == pytest.approx(0.475 * 250 / 0.03395)
    assert found.high == pytest.approx(0.485 * 250 / 0.03385)
    assert found.low < 3540 < found.high
    assert implied_makespan(None, Range(1, 2), 50) is None
    rows = [row(method, orders=250, makespan_s=3540.0) for method in METHODS]
    table = tables_of(rows)["makespan"]
    assert [line.verdict for line in table.lines] == ["in range", "in range", "above", "above"]
    for table in instance_set_tables([row(method) for method in METHODS], load_paper()):
        assert all("150" not in line.label[0] and "250" not in line.label[0] for line in table.lines)


def verdict_on(rows, start: str) -> str:
    (found,) = (statement for statement in statements(rows) if statement.sentence.startswith(start))
    return found.verdict


def test_differences_and_verdicts() -> None:
    good, bad = Comparison("a", 1.0, 2.0), Comparison("b", 2.0, 2.0)
    assert Statement("", "", (good, good)).verdict == "holds"
    assert Statement("", "", (good, bad)).verdict == "holds in 1 of 2"
    assert Statement("", "", (bad,)).verdict == "does not hold"
    assert Statement("", "", ()).verdict == "no complete run"
    scenario = load_scenario("paper-250-integrated", ["robots.count=9", "rules.pp=free-flow"])
    weighted = RuleChoice("integrated", {"unused_capacity_weight": 3.5})
    scenario = evolve(scenario, rules=evolve(scenario.rules, poa_pps=weighted))
    found = {entry.name: entry for entry in settings(load_paper()["settings"], [scenario])}
    assert found["Robots"] == Setting("Robots", "8", "9")
    assert (found["Robots"].verdict, found["W_u"].ours) == ("differs", "3.5")
    assert (found["PP"].ours, found["POA, sequential"].ours) == ("free-flow", "")


def test_statements_have_verdicts(row) -> None:
    rows = [row(), row("integrated", psv_per_order=0.7, distance_per_order_m=80.0)]
    assert verdict_on(rows, "Robot distances") == "holds"
    rows = [row(), row("integrated", turnover_backlog_s=300.0, turnover_station_s=210.0)]
    rows.append(row("split-over-time", turnover_s=700.0))
    assert verdict_on(rows, "With the integrated") == "holds in 1 of 2"
    assert verdict_on(rows, "The turn-over time of split-over-time") == "holds"
    first = {"sequential": 0.01, "integrated": 2.0, "split-among-stations": 0.3, "split-over-time": 0.5}
    rows = [row(method, decision_s_first=first[method], decision_percent_of_simulated=14.9) for method in METHODS]
    assert verdict_on(rows, "Computing times") == "holds"
    assert verdict_on(rows, "At t = 1") == "holds in 1 of 2"
    assert verdict_on(rows, "Computing the decisions") == "holds"
    assert verdict_on([row(decision_s_per_order=1.6)], "It takes") == "does not hold"


DIAGRAMS = ("fig:mu_simulationframework", "fig:problemdependencies", "fig:locusBots")
SETTINGS = ("tab:instance", "fig:Layout", "tab:decrules")
FIGURES = (
    *("fig:orderlen", "fig:skus", "fig:podstationvisitsperorder", "fig:distancesperorder", "fig:pileon"),
    *("fig:turnovertime", "fig:comptime_total", "fig:prefiltering", "fig:psv_distance_2000_fil10_8bots"),
)
TABLES = ("tab:reltosimtime", "tab:reltotimeperorder", "tab:rel", "tab:reltosimtime_2000")


def test_what_the_paper_prints() -> None:
    labels = [label for exhibit in load_paper().values() for label in exhibit.label.split(", ")]
    assert not {*DIAGRAMS, *SETTINGS, *FIGURES, *TABLES} - set(labels)
    assert load_paper()["pod-station-visits"].range("integrated") == Range(0.70, 0.80)
    found = load_paper()["time-per-order"].range("250", "integrated")
    assert (found.low, found.high, found.printed) == (pytest.approx(0.475), pytest.approx(0.485), 0.48)
    assert load_paper()["distances"].range("integrated") is None
    assert load_paper()["pile-on"].range("highest", "integrated") is None


def test_settings_of_the_paper(jobs) -> None:
    scenarios = [job.scenario for job in jobs["instances"] if job.seed == 1]
    differing = [entry for entry in settings(load_paper()["settings"], scenarios) if entry.verdict != "same"]
    assert differing == []
    assert Setting("Number of orders |O|", "50, 150, 250", "50").verdict == "some of them"
    assert Setting("Number of orders |O|", "50, 150, 250", "40, 50").verdict == "differs"
    assert Setting("PP", "whca-n", "").verdict == "differs"


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


@pytest.mark.slow
def test_a_report_shows_all_exhibits_means_verdicts_and_failed_runs(report: Report) -> None:
    titles = [entry.title for entry in report.grids]
    for exhibit in load_paper().values():
        title = f"{exhibit.item}: {exhibit.caption}"
        assert title in titles or title in [row[0] for row in grid(report, "Not in this report").rows]
    first = grid(report, "Figure 10").rows[0]
    assert first == ("50 orders, integrated", "0.70 to 0.80", "1.000 ± 0.000", "above", "2")
    assert grid(report, "Figure 16").rows[0][-1] == "1 of 2"
    outcome = {row[0]: row[2:] for row in grid(report, "Overview").rows}
    assert outcome["Figure 10"] == ("9", "9 above")
    assert outcome["Figure 11"] == ("9", "9 no number in the paper")
    assert outcome["Table 4"] == ("12", "from 5.0 times faster to 670 times faster")
    (counts,) = (entry for entry in report.grids if entry.title == "Runs")
    assert ("large", "sequential", "2", "1", "0", "1", "1", "0", "3.0") in counts.rows
    (lost,) = grid(report, "Runs that did not complete").rows
    assert lost == ("large", "one, sequential, seed 1", "failed", "robot 3 | waits for 4")


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
    shown = [number(value) for value in (0.0, 0.012345, 1.0034, 12345.0, -2.5)]
    assert shown == ["0", "0.01235", "1.003", "12,345", "-2.500"]


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


def test_ratios_divide_the_means_of_a_seed_and_need_both_runs(row) -> None:
    rows = [row(seed=1, pile_on=2.0), row(seed=2, pile_on=4.0), row(seed=1, instance="two", pile_on=1.0)]
    others = [one | {"pile_on": of} for one, of in zip(rows, (3.0, 4.0, 2.5), strict=True)]
    assert relative(others, rows, metric("pile_on")).mean == (2.75 / 1.5 + 1.0) / 2
    for failed in ({"status": "failed", "pile_on": 99.0}, {"status": "partial"}, {"pile_on": 0.0}):
        broken = [rows[0], rows[1] | failed]
        found = relative(others[:2], broken, metric("pile_on"))
        assert (found.mean, found.runs, found.expected) == (1.5, 1, 2)
    found = relative([others[0], others[1] | {"status": "failed", "pile_on": 99.0}], rows[:2], metric("pile_on"))
    assert (found.mean, found.runs, found.expected) == (1.5, 1, 2)
    lost = {key: row()[key] for key in ("instance", "rule_set", "seed", "error_kind")} | {"status": "failed"}
    found = mean_of([lost, row(seed=2, makespan_s=7.0)], metric("makespan_s"))
    assert (found.mean, found.runs, found.expected) == (7.0, 1, 2)


ONE = Range(0.9, 1.1)


@cases(
    "compare printed mean verdict",
    (in_range, Range(0.70, 0.80), 0.69, "below"),
    (in_range, Range(0.70, 0.80), 0.70, "in range"),
    (in_range, Range(0.70, 0.80), 0.75, "in range"),
    (in_range, Range(0.70, 0.80), 0.80, "in range"),
    (in_range, Range(0.70, 0.80), 0.81, "above"),
    (as_factor, ONE, 0.02, "50 times faster"),
    (as_factor, ONE, 1.0, "1.0 times faster"),
    (as_factor, ONE, 0.4, "2.5 times faster"),
    (as_factor, ONE, 3.0, "3.0 times slower"),
    *((compare, None, 1.0, NO_NUMBER) for compare in (in_range, as_factor)),
    *((compare, printed, None, NO_RUN) for compare in (in_range, as_factor) for printed in (ONE, None)),
)
def test_our_mean_against_the_printed_figure(compare, printed, mean, verdict) -> None:
    line = compare(("a",), printed, None if mean is None else at(mean))
    assert line.verdict == verdict
    if compare is as_factor and printed and mean:
        assert line.speedup == pytest.approx(1 / mean)


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
    def names(figure: Any) -> list[str]:
        return [text.get_text() for legend in figure.legends for text in legend.get_texts()]

    figure = relative_figures(tables(row))
    assert names(figure) == [*METHODS[1:], "the paper's range"]
    for axis in figure.axes:
        ours = [bar for bar in axis.patches if bar.get_fill()]
        assert [bar.get_height() for bar in ours] == [1.0] * 9
        assert [text.get_text() for text in axis.get_xticklabels()] == ["50 orders", "150 orders", "250 orders"]
        assert axis.get_ylim()[0] == 0
    figure = turnover(tables(row, turnover_backlog_s=600.0, turnover_station_s=120.0))
    assert names(figure) == [*METHODS]
    (axis,) = figure.axes
    bars = [(bar.get_y(), bar.get_height()) for bar in axis.patches]
    assert sorted(set(bars)) == [(0.0, 10.0), (10.0, 2.0)]
    assert len(bars) == 2 * 3 * len(METHODS)
    figure = computing_time(tables(row, decision_s_first=0.5, decision_s_later=0.02))
    assert names(figure) == [*METHODS, "the paper's figure"]
    first, later, _ = figure.axes
    assert (first.get_yscale(), first.get_ylim()[0], later.get_ylim()[0]) == ("log", 0.1, 0.01)
    assert [axis.get_title() for axis in (first, later)] == ["Seconds a run, t = 1", "Seconds a run, t > 1"]


def grid(report: Report, start: str) -> Grid:
    (found,) = (entry for entry in report.grids if entry.title.startswith(start))
    return found


@pytest.mark.slow
def test_a_report_on_some_parts_says_what_is_missing(row) -> None:
    parts = {"packing": [row("packing-10"), row()]}
    report = make_report(parts, [], {})
    assert [*report.content] == [*make_report(parts, [], {}).content]
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
