"""Plots of a comparison."""

from __future__ import annotations

from typing import Any

import pytest
from attrs import evolve

from rmfs_experiments import ExperimentResult
from rmfs_experiments.report.plots import make_plots


def plots_of(result: ExperimentResult, **changes: Any) -> list[Any]:
    """Return the plots of a result with another experiment."""
    changed = evolve(result, experiment=evolve(result.experiment, **changes))
    return make_plots(changed.rows, changed.comparison())


def test_a_plot_of_differences_and_one_for_each_metric(result: ExperimentResult) -> None:
    """Each as SVG and PNG, named after the metric, with its title."""
    plots = plots_of(result)
    assert [plot.name for plot in plots] == ["differences", *result.experiment.metrics]
    assert [plot.title for plot in plots][:2] == ["Differences from base", "Pile-on"]
    assert all(plot.png.startswith(b"\x89PNG") and b"<svg" in plot.svg for plot in plots)


def test_another_figure_gives_another_plot(result: ExperimentResult) -> None:
    """Of its metric, and of the differences."""
    metrics = ("pile_on", "picker_utilisation")
    before = {plot.name: plot.svg for plot in plots_of(result, metrics=metrics)}
    result.rows[0]["pile_on"] = 7.0
    after = {plot.name: plot.svg for plot in plots_of(result, metrics=metrics)}
    assert {name for name in before if before[name] != after[name]} == {"differences", "pile_on"}


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
