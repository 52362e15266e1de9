"""Plots of a comparison."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import pytest
from attrs import evolve
from matplotlib.figure import Figure

from rmfs_commands.experiments import ExperimentResult, RuleSetChoice
from rmfs_commands.experiments.report.plots import MOST_RULE_SETS, make_plots, plot_of


def plots_of(result: ExperimentResult, **changes: Any) -> list[Any]:
    """Return the plots of a result with another experiment."""
    changed = evolve(result, experiment=evolve(result.experiment, **changes))
    return make_plots(changed.rows, changed.comparison())


def test_a_plot_of_differences_and_one_for_each_metric(result: ExperimentResult) -> None:
    """Each as SVG, PNG and PDF, named after the metric, with its title."""
    plots = plots_of(result)
    assert [plot.name for plot in plots] == ["differences", *result.experiment.metrics]
    assert [plot.title for plot in plots][:2] == ["Differences from base", "Pile-on"]
    assert all(plot.png.startswith(b"\x89PNG") and b"<svg" in plot.svg for plot in plots)
    assert all(plot.pdf.startswith(b"%PDF") for plot in plots)


def test_a_plot_for_each_front(with_front: ExperimentResult) -> None:
    """Who is best in both is named in it."""
    plots = plots_of(with_front)
    assert plots[-1].name == "front.pile_on.picker_utilisation"
    assert plots[-1].title == "Picker utilisation (%) against Pile-on"
    assert ">1 base</text>" in plots[-1].svg.decode()


def test_many_rule_sets_have_no_plots_of_single_runs(result: ExperimentResult) -> None:
    """The differences say more."""
    rule_sets = tuple(RuleSetChoice(f"rules {number}") for number in range(MOST_RULE_SETS + 1))
    rows = [dict(result.rows[0], rule_set=one.name, seed=seed) for one in rule_sets for seed in (1, 2)]
    changed = evolve(result, rows=rows)
    assert [plot.name for plot in plots_of(changed, rule_sets=rule_sets, baseline="rules 0")] == ["differences"]


def test_another_figure_gives_another_plot(result: ExperimentResult) -> None:
    """Of its metric, and of the differences."""
    metrics = ("pile_on", "picker_utilisation")
    before = {plot.name: plot.svg for plot in plots_of(result, metrics=metrics)}
    result.rows[0]["pile_on"] = 7.0
    after = {plot.name: plot.svg for plot in plots_of(result, metrics=metrics)}
    assert {name for name in before if before[name] != after[name]} == {"differences", "pile_on"}


NAMES = (
    "$\\frac{1$",
    "_hidden",
    "a\nb",
    "a\x00\x1bb",
    "\ud800",
    "{x} %s \\alpha",
    "\N{DEVANAGARI DIGIT ONE}",
    "n" * 300,
)


@pytest.mark.parametrize("name", NAMES)
def test_names_may_have_any_sign(result: ExperimentResult, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """None is a formula, a comment of a legend, or a reason not to draw; the pictures can be read."""
    for row in result.rows:
        row["rule_set"] = f"{name}{row['rule_set']}"
        row["instance"] = f"{name}{row['instance']}"
    rule_sets = tuple(evolve(one, name=f"{name}{one.name}") for one in result.experiment.rule_sets)
    plots = plots_of(result, rule_sets=rule_sets, baseline=f"{name}base", metrics=("pile_on",))
    assert [plot.name for plot in plots] == ["differences", "pile_on"]
    assert [ElementTree.fromstring(plot.svg).tag for plot in plots] == ["{http://www.w3.org/2000/svg}svg"] * 2
    assert capsys.readouterr().err == ""


def test_a_plot_that_fails_costs_that_plot_only(capsys: pytest.CaptureFixture[str]) -> None:
    """It is named, and there is none."""

    def draw() -> Figure:
        raise ValueError("no\nidea")

    assert plot_of("mine", "My plot", draw) is None
    assert capsys.readouterr().err == "Left out: the plot mine cannot be drawn: ValueError: no idea\n"
    drawn = plot_of("mine", "My plot", Figure)
    assert drawn is not None
    assert drawn.title == "My plot"


def test_a_single_rule_set_differs_from_nothing(result: ExperimentResult) -> None:
    """Its metrics are drawn all the same."""
    rows = [row for row in result.rows if row["rule_set"] == "base"]
    alone = evolve(result, rows=rows)
    chosen = tuple(one for one in result.experiment.rule_sets if one.name == "base")
    plots = plots_of(alone, rule_sets=chosen, metrics=("pile_on",))
    assert [plot.name for plot in plots] == ["pile_on"]


@pytest.mark.parametrize("values", [None, 0.0])
def test_what_no_run_has_is_drawn_empty(result: ExperimentResult, values: float | None) -> None:
    """Neither missing figures nor zeros, of which there are no relative differences, stop the report."""
    for row in result.rows:
        row["pile_on"] = values
    assert [plot.name for plot in plots_of(result, metrics=("pile_on",))] == ["differences", "pile_on"]


def test_a_bound_is_a_dashed_line(result: ExperimentResult) -> None:
    """In the plot of its metric alone; another bound is another picture."""
    metrics = ("pile_on", "picker_utilisation")
    pictures = []
    for bound in (None, 1.0, 1.5):
        for row in result.rows:
            row["bound.pile_on"] = bound
        pictures.append({plot.name: plot.svg for plot in plots_of(result, metrics=metrics)})
    without, low, high = pictures
    assert {name for name in without if without[name] != low[name]} == {"pile_on"}
    assert {name for name in without if low[name] != high[name]} == {"pile_on"}
    dashes = {name: svg.count(b"stroke-dasharray") for name, svg in low.items()}
    assert dashes["pile_on"] - without["pile_on"].count(b"stroke-dasharray") == 3 * 3
