"""The report's pictures, from its tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rmfs_commands.reproduction.instance_sets import METHODS, instance_set_tables
from rmfs_commands.reproduction.paper import load_paper
from rmfs_commands.reproduction.plots import DRAWINGS, computing_time, draw, relative_figures, turnover
from rmfs_commands.reproduction.report import Report
from rmfs_commands.reproduction.tables import Table


def tables(row: Any, **figures: Any) -> Mapping[str, Table]:
    """Return the tables of the instance sets, of runs with these figures."""
    rows: Sequence[Any] = [
        row(rule_set, seed, orders=orders, **figures)
        for rule_set in METHODS
        for seed in (1, 2)
        for orders in (50, 150, 250)
    ]
    return {table.exhibit.name: table for table in instance_set_tables(rows, load_paper())}


def test_plots_are_there(report: Report) -> None:
    """Every drawing as SVG and PNG, without a date."""
    assert [plot.name for plot in report.plots] == list(DRAWINGS)
    for plot in report.plots:
        assert plot.png.startswith(b"\x89PNG")
        assert b"<svg" in plot.svg
        assert b"dc:date" not in plot.svg


def test_a_picture_is_drawn_where_all_its_tables_are(row: Any) -> None:
    """And only there; twice the same bytes."""
    given = tables(row)
    few = {name: given[name] for name in ("turnover", "computing-time", "pod-station-visits", "distances")}
    drawn = draw(few)
    assert list(drawn) == ["turnover"]
    assert draw(few) == drawn


def test_bars_are_as_high_as_the_figures(row: Any) -> None:
    """Relative to sequential: runs alike are all 1, a group for each instance set and a bar for each model."""
    figure = relative_figures(tables(row))
    for axis in figure.axes:
        ours = [bar for bar in axis.patches if bar.get_fill()]
        assert [bar.get_height() for bar in ours] == [1.0] * 9
        assert [text.get_text() for text in axis.get_xticklabels()] == ["50 orders", "150 orders", "250 orders"]
        assert axis.get_ylim()[0] == 0


def test_the_parts_of_the_turn_over_time_stand_upon_each_other(row: Any) -> None:
    """In minutes: the backlog below, the station above."""
    figure = turnover(tables(row, turnover_backlog_s=600.0, turnover_station_s=120.0))
    (axis,) = figure.axes
    bars = [(bar.get_y(), bar.get_height()) for bar in axis.patches]
    assert sorted(set(bars)) == [(0.0, 10.0), (10.0, 2.0)]
    assert len(bars) == 2 * 3 * len(METHODS)


def test_scales_of_computing_times_begin_at_a_power_of_ten(row: Any) -> None:
    """A bar's length is comparable then; each axis has one of its own."""
    figure = computing_time(tables(row, decision_s_first=0.5, decision_s_later=0.02))
    first, later, _ = figure.axes
    assert (first.get_yscale(), first.get_ylim()[0], later.get_ylim()[0]) == ("log", 0.1, 0.01)
    assert [axis.get_title() for axis in (first, later)] == ["Seconds a run, t = 1", "Seconds a run, t > 1"]


def test_the_legend_names_the_methods_and_the_paper(row: Any) -> None:
    """Ranges where the exhibit has ranges, figures where it has figures, neither where it has none."""

    def names(figure: Any) -> list[str]:
        return [text.get_text() for legend in figure.legends for text in legend.get_texts()]

    given = tables(row)
    assert names(relative_figures(given)) == [*METHODS[1:], "the paper's range"]
    assert names(computing_time(given)) == [*METHODS, "the paper's figure"]
    assert names(turnover(given)) == [*METHODS]
