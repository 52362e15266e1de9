"""The report's pictures, drawn from its tables: every figure in them is in a table too."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from attrs import frozen

from rmfs_commands.experiments.report.plots import STYLE, Plot, plot_of
from rmfs_commands.reproduction.extensions import PREFILTER
from rmfs_commands.reproduction.instance_sets import METHODS, MODELS
from rmfs_commands.reproduction.tables import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Tables = Mapping[str, Table]

COLOURS = {
    "sequential": "#8c8c8c",
    "integrated": "#0072b2",
    "split-among-stations": "#e69f00",
    "split-over-time": "#009e73",
}  # Okabe and Ito: told apart by people who see colours differently
DPI = 110
PAPER = "#222222"
THIN = 1.2


def distributions(tables: Tables) -> Figure:
    """Draw order lengths and SKU probabilities."""
    figure, axes = _figure(1, 2, 3.0)
    for axis, name in zip(axes, ("order-lengths", "sku-probabilities"), strict=True):
        lines = tables[name].lines
        numbers = range(1, len(lines) + 1)
        axis.bar(numbers, [line.ours.mean if line.ours else 0 for line in lines], color="#9ecae1", label="generated")
        formula = [line.paper.low if line.paper else 0 for line in lines]
        axis.plot(numbers, formula, "o", color=PAPER, markersize=3.5, label="the paper's formula")
        axis.set_xticks([1, 5, 10, 15, 20])
        axis.set_ylabel("probability")
    axes[0].set_xlabel("order lines")
    axes[1].set_xlabel("SKU, most wanted first")
    axes[1].legend()
    return figure


def relative_figures(tables: Tables) -> Figure:
    """Draw visits, distances and pile-on relative to sequential."""
    titles = {
        "pod-station-visits": "Pod-station visits per order",
        "distances": "Robot distance per order",
        "pile-on": "Pile-on",
    }
    figure, axes = _figure(1, 3, 3.3)
    for axis, (name, title) in zip(axes, titles.items(), strict=True):
        _bars(axis, tables[name], _sets(tables[name]), MODELS)
        axis.axhline(1.0, color=PAPER, linewidth=THIN, linestyle=":")
        axis.set_title(title)
    highest = tables["pile-on"].paper("highest of the sets", "split-over-time")
    if highest is not None and highest.printed is not None:
        axes[2].axhline(highest.printed, color=PAPER, linewidth=THIN)
        place, text = axes[2].get_yaxis_transform(), f"the paper: up to {highest.printed}"
        axes[2].text(0.02, highest.printed, text, transform=place, va="bottom", size=8)
    for axis in axes:
        axis.set_ylim(bottom=0)
    axes[0].set_ylabel("relative to sequential")
    _legend(figure, MODELS, ("range",))
    return figure


def turnover(tables: Tables) -> Figure:
    """Draw the two parts of the turn-over time, one upon the other."""
    table = tables["turnover"]
    figure, (axis,) = _figure(1, 1, 3.4)
    sets = _sets(table)
    for column, method in enumerate(METHODS):
        at = [row + _offset(column, len(METHODS)) for row in range(len(sets))]
        backlog = [_mean(table, (name, method, "backlog")) / 60 for name in sets]
        station = [_mean(table, (name, method, "station")) / 60 for name in sets]
        width = 0.8 / len(METHODS)
        axis.bar(at, backlog, width, color=COLOURS[method], edgecolor="white")
        axis.bar(at, station, width, bottom=backlog, color=COLOURS[method], alpha=0.45, edgecolor="white")
    axis.set_xticks(range(len(sets)), sets)
    axis.set_ylabel("minutes")
    axis.set_title("Turn-over time: in the backlog (below), in the station (above, lighter)")
    _legend(figure, METHODS)
    return figure


def computing_time(tables: Tables) -> Figure:
    """Draw computing times of a run for t = 1 and t > 1, and for t > 1 per order next to the paper's."""
    table = tables["computing-time"]
    figure, axes = _figure(1, 3, 3.3)
    sets = _sets(table)
    for axis, part in zip(axes, ("t = 1", "t > 1"), strict=False):
        _bars(axis, table, sets, METHODS, (part,))
        axis.set_title(f"Seconds a run, {part}")
    _bars(axes[2], tables["time-per-order"], sets, METHODS)
    axes[2].set_title("Seconds an order, t > 1")
    for axis in axes:
        _log_scale(axis)
    _legend(figure, METHODS, ("figure",))
    return figure


def prefilter(tables: Tables) -> Figure:
    """Draw visits and share of simulated time against the number of orders that the prefilter leaves."""
    visits, share = tables["prefilter"], tables["prefilter-share"]
    figure, axes = _figure(1, 2, 3.2)
    places = [str(n) for n in PREFILTER]
    for to, colour in (("sequential", "#0072b2"), ("no prefilter", "#e69f00")):
        means = [_mean(visits, (f"n = {n}", f"pod-station visits, to {to}")) for n in PREFILTER]
        axes[0].plot(places, means, "o-", color=colour, markersize=4, label=f"relative to {to}")
        paper = visits.paper(f"n = {PREFILTER[0]}", f"pod-station visits, to {to}")
        if paper is not None:
            axes[0].vlines(0, paper.low, paper.high, color=PAPER, linewidth=2)
    axes[0].plot([], [], color=PAPER, linewidth=2, label="the paper's range")
    axes[0].set_title("Pod-station visits per order")
    axes[0].set_ylim(bottom=0)
    axes[1].plot(places, [_mean(share, (f"n = {n}",)) for n in PREFILTER], "o-", color="#0072b2", markersize=4)
    printed = [paper.printed or math.nan for n in PREFILTER if (paper := share.paper(f"n = {n}"))]
    axes[1].plot(places, printed, "s--", color=PAPER, markersize=4)
    axes[1].set_yscale("log")
    axes[1].set_title("Computing time t > 1, % of simulated time")
    axes[1].legend(["ours", "the paper's"])
    axes[0].legend()
    for axis in axes:
        axis.set_xlabel("orders that the prefilter leaves, n")
    return figure


def large(tables: Tables) -> Figure:
    """Draw visits, distances and computing time for 2000 orders."""
    table, share = tables["large"], tables["large-share"]
    figure, axes = _figure(1, 2, 3.2)
    labels = ("pod-station visits", "robot distance")
    for column, model in enumerate(MODELS):
        for row, label in enumerate(labels):
            _bar(axes[0], table, row + _offset(column, len(MODELS)), (model, label), model, len(MODELS))
    axes[0].axhline(1.0, color=PAPER, linewidth=THIN, linestyle=":")
    axes[0].set_xticks(range(len(labels)), labels)
    axes[0].set_title("2,000 orders, relative to sequential")
    axes[0].set_ylim(bottom=0)
    for column, method in enumerate(METHODS):
        _bar(axes[1], share, column, (method,), method, 1)
    axes[1].set_xticks([])
    _log_scale(axes[1])
    axes[1].set_title("Computing time t > 1, % of simulated time")
    _legend(figure, METHODS, ("range", "figure"))
    return figure


def _bars(axis: Axes, table: Table, sets: Sequence[str], methods: Sequence[str], part: tuple[str, ...] = ()) -> None:
    """Draw a group of bars for each instance set, with what the paper has."""
    for column, method in enumerate(methods):
        for row, name in enumerate(sets):
            _bar(axis, table, row + _offset(column, len(methods)), (name, method, *part), method, len(methods))
    axis.set_xticks(range(len(sets)), sets)


def _bar(axis: Axes, table: Table, at: float, label: tuple[str, ...], method: str, columns: int) -> None:
    """Draw a bar with its interval, and the paper's range or figure upon it."""
    width = 0.8 / columns
    ours, paper = table.ours(*label), table.paper(*label)
    if ours is not None:
        error = ours.half_width or None
        axis.bar(at, ours.mean, width * 0.92, yerr=error, color=COLOURS[method], error_kw={"linewidth": 0.8})
    if paper is not None and paper.printed is None:
        left, height = at - width / 2, paper.high - paper.low
        axis.bar(left, height, width, bottom=paper.low, align="edge", fill=False, edgecolor=PAPER, linewidth=THIN)
    elif paper is not None and paper.printed is not None:
        axis.hlines(paper.printed, at - width / 2, at + width / 2, color=PAPER, linewidth=THIN)


def _log_scale(axis: Axes) -> None:
    """Give bars a logarithmic scale that begins at a power of ten: one that began just below them would exaggerate."""
    from matplotlib.patches import Rectangle

    heights = [height for bar in axis.patches if isinstance(bar, Rectangle) and (height := bar.get_height()) > 0]
    axis.set_yscale("log")
    if heights:
        axis.set_ylim(bottom=10.0 ** math.floor(math.log10(min(heights))))


def _figure(rows: int, columns: int, height: float) -> tuple[Figure, list[Axes]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, height * rows), layout="constrained")
    axes = [figure.add_subplot(rows, columns, place) for place in range(1, rows * columns + 1)]
    for axis in axes:
        axis.grid(axis="y", linewidth=0.4, alpha=0.6)
        axis.set_axisbelow(True)
        axis.tick_params(labelsize=8)
    return figure, axes


def _legend(figure: Figure, methods: Sequence[str], paper: Collection[str] = ()) -> None:
    """Name the methods, and what stands for the paper's ``range`` and ``figure`` where there is one."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Patch | Line2D] = [Patch(color=COLOURS[method], label=method) for method in methods]
    if "range" in paper:
        handles.append(Patch(fill=False, edgecolor=PAPER, label="the paper's range"))
    if "figure" in paper:
        handles.append(Line2D([], [], color=PAPER, linewidth=THIN, label="the paper's figure"))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False, fontsize=8)


def _sets(table: Table) -> list[str]:
    return list(dict.fromkeys(line.label[0] for line in table.lines if line.label[0].endswith("orders")))


def _offset(column: int, columns: int) -> float:
    return (column - (columns - 1) / 2) * 0.8 / columns


def _mean(table: Table, label: tuple[str, ...]) -> float:
    ours = table.ours(*label)
    return math.nan if ours is None else ours.mean


@frozen
class Drawing:
    """A picture of the report.

    Parameters
    ----------
    title
        Its title.
    exhibits
        Tables it is drawn from, in the paper's order.
    draw
        Draws it.
    """

    title: str
    exhibits: tuple[str, ...]
    draw: Callable[[Tables], Figure]


DRAWINGS = {
    "distributions": Drawing("Order lengths and SKUs", ("order-lengths", "sku-probabilities"), distributions),
    "relative-to-sequential": Drawing(
        "Pod-station visits, distances and pile-on relative to sequential",
        ("pod-station-visits", "distances", "pile-on"),
        relative_figures,
    ),
    "turnover": Drawing("Turn-over time", ("turnover",), turnover),
    "computing-time": Drawing("Computing time", ("computing-time", "time-per-order"), computing_time),
    "prefilter": Drawing("Prefilter on 250 orders", ("prefilter", "prefilter-share"), prefilter),
    "large": Drawing("2,000 orders", ("large", "large-share"), large),
}
"""Every picture by its file's name without the ending."""


def draw(tables: Tables) -> dict[str, Plot]:
    """Return the plots that there are all tables for, by name; one that cannot be drawn is named on standard error.

    Parameters
    ----------
    tables
        The report's tables by the name of their exhibit.
    """
    import matplotlib as mpl

    with mpl.rc_context(STYLE):
        plots = {
            name: plot_of(name, drawing.title, partial(drawing.draw, tables), DPI)
            for name, drawing in DRAWINGS.items()
            if all(exhibit in tables for exhibit in drawing.exhibits)
        }
    return {name: plot for name, plot in plots.items() if plot is not None}
