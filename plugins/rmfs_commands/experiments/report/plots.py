"""Plots of a comparison. The same comparison gives the same bytes: no dates, no random ids, no random jitter."""

from __future__ import annotations

import io
import sys
import textwrap
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from attrs import frozen

from rmfs_commands.experiments.compare import COUNTED, Comparison, Interval
from rmfs_commands.experiments.report.numbers import MARK, aim, heading
from rmfs_core.wording import one_line, sentence

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999")
"""Okabe and Ito's palette, which colour-blind readers can tell apart."""

MOST_SETS = 8
"""With more instance sets than these a plot has the overall figures alone."""
MOST_RULE_SETS = 20
"""With more of them there are no plots of single runs: nobody could tell them apart."""
MOST_DOTS = 1_000
"""With more runs than these their dots are one bitmap in SVG and PDF, where each alone would take 50 bytes or more."""
LONGEST = 60
"""Characters of a name that fit."""
PAGE, PANEL = 7.1, 0.9
"""Inches that a picture of a paper may be high, with a caption below; and that a panel takes next to its rule sets."""
DPI = 150
DIFFERENCES = "differences"
STYLE: dict[Any, Any] = {
    "svg.hashsalt": "rmfs",  # else ids in the SVG are random
    "svg.fonttype": "none",  # text stays text, to be searched, read aloud and edited
    "pdf.fonttype": 42,
    "text.parse_math": False,  # a dollar in a label is a dollar
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "legend.frameon": False,
}

PAPER: dict[Any, Any] = dict.fromkeys(
    ("font.size", "axes.titlesize", "axes.labelsize", "xtick.labelsize", "ytick.labelsize", "legend.fontsize"), 8
)
"""Of pictures for papers, which stand next to text of 8 to 10 pt."""
MOST_NAMED = 12
"""With more rule sets than these, a picture of fronts names only the baseline and those on a front."""
AROUND = ((-9, -9), (3, 3), (3, -9), (-9, 3))
"""Offsets of a number from its dot, in points. They alternate, so that numbers of close dots do not overlap."""
LETTER = 0.062
"""Inches that a letter of 8 or 9 pt takes on average."""


@frozen
class Plot:
    """A picture.

    Parameters
    ----------
    name
        Of its files, without the ending.
    title
        Its title.
    svg, png, pdf
        The picture; the last two are empty where it is for a page alone.
    """

    name: str
    title: str
    svg: bytes
    png: bytes
    pdf: bytes

    @property
    def files(self) -> dict[str, bytes]:
        """Names of its files, and what is in them."""
        return {f"{self.name}.{ending}": getattr(self, ending) for ending in ("png", "svg", "pdf")}


def make_plots(rows: Sequence[Mapping[str, Any]], comparison: Comparison, width: float | None = None) -> list[Plot]:
    """Return the plot of all differences, one for each metric with every run that counts in it, and the fronts.

    One that cannot be drawn is left out, and named on standard error.

    Parameters
    ----------
    rows, comparison
        Rows and comparison to draw.
    width
        Of each picture in inches, with letters of 8 pt, for a paper that shows it at its size; left out, each is an
        SVG as wide as it needs to be on a screen.
    """
    import matplotlib as mpl

    of, sets = partial(plot_of, page=width is None), shown_sets(comparison)
    with mpl.rc_context(STYLE if width is None else STYLE | PAPER):
        plots = [
            of(plot_name(metric), _title(comparison, metric), partial(_runs, rows, comparison, metric, width))
            for metric in comparison.metrics
            if len(comparison.rule_sets) <= MOST_RULE_SETS and _values(rows, comparison, metric, sets)
        ]
        heading = f"Differences from {comparison.baseline}"
        draws: list[Callable[[], Figure]]
        draws = [partial(_differences, comparison, width, *part) for part in _parts_of_differences(comparison, width)]
        plots[:0] = _numbered(of, DIFFERENCES, heading, draws if len(comparison.rule_sets) > 1 else ())
        for first, second in comparison.fronts:
            heading = f"{_title(comparison, second)} against {_title(comparison, first)}"
            fit = len(sets) if width is None else 2 * max(1, int(width / 3))  # two lines of panels
            draws = [partial(_fronts, comparison, first, second, width, part) for part in _parts(sets, fit)]
            plots += _numbered(of, front_name(first, second), heading, draws)
    return [plot for plot in plots if plot is not None]


def plot_of(name: str, heading: str, draw: Callable[[], Figure], dpi: int = DPI, *, page: bool = False) -> Plot | None:
    """Return a plot; None, with a sentence on standard error, where it cannot be drawn: it costs no other.

    ``page``: it is for a page alone, as SVG on whatever the page's background is.
    """
    svg, png, pdf = io.BytesIO(), io.BytesIO(), io.BytesIO()
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Glyph .* missing from font")  # a box stands for the sign
            figure = draw()
            figure.savefig(svg, format="svg", dpi=dpi, metadata={"Date": None, "Creator": None}, transparent=page)
            if not page:
                figure.savefig(png, format="png", dpi=dpi, metadata={"Software": None})
                figure.savefig(pdf, format="pdf", metadata={"CreationDate": None, "Creator": None, "Producer": None})
    except Exception as error:  # whatever a library makes of names and figures
        print(sentence(f"Left out: the plot {name} cannot be drawn: {one_line(error)}"), file=sys.stderr)
        return None
    return Plot(name, heading, svg.getvalue(), png.getvalue(), pdf.getvalue())


def _numbered(
    of: Callable[..., Plot | None], name: str, heading: str, draws: Sequence[Callable[[], Figure]]
) -> list[Plot | None]:
    """Return the plots of something that may take several: the second is called ``NAME-2``."""
    return [of(name if i == 1 else f"{name}-{i}", heading, draw) for i, draw in enumerate(draws, 1)]


def _parts(things: Sequence[str], number: int) -> list[Sequence[str]]:
    return [things[i : i + number] for i in range(0, len(things), number)]


def plain(text: object) -> str:
    """Return a name as a picture can show it: not too long, and without signs that no font and no SVG has."""
    shown = "".join(sign if sign.isprintable() else "\N{REPLACEMENT CHARACTER}" for sign in str(text)[: LONGEST + 1])
    if len(shown) > LONGEST:
        shown = f"{shown[: LONGEST - 1]}\N{HORIZONTAL ELLIPSIS}"
    return f" {shown}" if shown.startswith("_") else shown  # legends leave out what begins so


def plot_name(metric: str) -> str:
    """Return what the plot of a metric is called: an observer's may have the name of the plot of all differences."""
    return f"metrics.{metric}" if metric.lower() == DIFFERENCES else metric


def front_name(first: str, second: str) -> str:
    """Return what the plot of two metrics against each other is called."""
    return f"front.{first}.{second}"


def _title(comparison: Comparison, metric: str) -> str:
    return heading(comparison, metric)


def _figure(width: float, height: float) -> Figure:
    """Return a figure that no window system knows of (pyplot would keep it forever)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def shown_sets(comparison: Comparison) -> tuple[str, ...]:
    """Return the instance sets that fit: all of a few, else the overall figures."""
    return comparison.instance_sets if len(comparison.instance_sets) <= MOST_SETS else comparison.instance_sets[-1:]


def _wrapped(text: str, width: float) -> str:
    """Return a text on as many lines as it needs within a width in inches."""
    return "\n".join(textwrap.wrap(plain(text), max(8, int(width / LETTER)))) or plain(text)


def _legend_columns(names: Sequence[str], width: float) -> int:
    """Return how many names of a legend fit side by side."""
    return max(1, min(4, len(names), int(width / (LETTER * max(map(len, names)) + 0.5))))


def _sizes_of_differences(comparison: Comparison, width: float | None) -> tuple[float, float, int, float]:
    """Return inches for names, at most and of the longest; columns of panels, and inches a rule set takes in one."""
    others = [name for name in comparison.rule_sets if name != comparison.baseline]
    most = 0.4 * width if width else 9.0
    names = min(0.07 * max(len(plain(other)) for other in others), most)
    fit = 3 if width is None else int((width - names) / 1.8)
    lines = max(_wrapped(other, most).count("\n") + 1 for other in others)
    return most, names, max(1, min(3, fit)), max(0.2 * (len(shown_sets(comparison)) + 1), 0.14 * lines)


def _parts_of_differences(comparison: Comparison, width: float | None) -> Iterator[tuple[Sequence[str], Sequence[str]]]:
    """Yield rule sets and metrics of each picture: of all, or where it is for a paper of as many as a page holds."""
    others = [name for name in comparison.rule_sets if name != comparison.baseline]
    differing = {one.metric for one in comparison.paired if one.difference.mean is not None}
    metrics = [metric for metric in comparison.metrics if metric in differing]
    if not others or not metrics:
        return
    _, _, columns, row = _sizes_of_differences(comparison, width)
    fit = len(others) if width is None else max(1, int((PAGE - PANEL) / row))
    for part in _parts(others, fit):
        lines = len(metrics) if width is None else max(1, int(PAGE / (PANEL + row * len(part))))
        yield from ((part, some) for some in _parts(metrics, lines * columns))


def _differences(comparison: Comparison, width: float | None, others: Sequence[str], metrics: Sequence[str]) -> Figure:
    """Intervals of the differences: a panel for each metric, a row for each rule set and instance set."""
    sets = shown_sets(comparison)
    most, names, columns, row = _sizes_of_differences(comparison, width)
    columns = min(columns, len(metrics))
    lines = -(-len(metrics) // columns)
    whole = width or 3.2 * columns + max(1.0, names)
    figure = _figure(whole, lines * (PANEL + row * len(others)))
    panel_width = (whole - names) / columns - 0.2
    panels = list(figure.subplots(lines, columns, sharey=True, squeeze=False).flat)
    for panel, metric in zip(panels, metrics, strict=False):
        _forest(panel, comparison, metric, others, sets, panel_width)
        panel.set_yticks(range(len(others)), [_wrapped(other, most) for other in others])
    for panel in panels[len(metrics) :]:
        panel.set_visible(False)
    if len(sets) > 1:
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=_legend_columns(labels, whole))
    return figure


def _forest(
    panel: Axes, comparison: Comparison, metric: str, others: Sequence[str], sets: Sequence[str], width: float
) -> None:
    found = {(one.rule_set, one.instances): one for name in sets for one in comparison.of(name, metric)}
    unit = comparison.described(metric).unit
    in_percent = unit != "%" and all(found[other, name].relative.mean is not None for other in others for name in sets)
    panel.axvline(0, color="0.6", linewidth=0.8)
    for place, name in enumerate(sets):
        spread = (place - (len(sets) - 1) / 2) * 0.8 / len(sets)
        colour = "black" if place == len(sets) - 1 else COLOURS[place % len(COLOURS)]
        for row, other in enumerate(others):
            one = found[other, name]
            interval = one.relative if in_percent else one.difference
            _whisker(panel, interval, row + spread, colour, 100 if in_percent else _scale(metric))
        panel.plot([], [], "o", color=colour, label=plain(name))
    panel.set_ylim(len(others) - 0.5, -0.5)
    panel.locator_params(axis="x", nbins=5)  # labels such as -0.0025 are wide
    mark = MARK if comparison.censored(metric) else ""
    panel.set_title(_wrapped(f"{_title(comparison, metric).partition(' (')[0].rstrip(MARK)}{mark}", width))
    absolute = f"difference ({'percentage points' if unit == '%' else unit})" if unit else "difference"
    shown = f"difference, % of {comparison.baseline}" if in_percent else absolute
    panel.set_xlabel("\n".join([_wrapped(shown, width), *_aim(metric)]))


def _aim(metric: str) -> list[str]:
    """Return the line of an axis that says which way is better; none where neither is."""
    return [aim(metric)] if aim(metric) else []


def _whisker(panel: Axes, interval: Interval, y: float, colour: str, scale: float) -> None:
    if interval.mean is None:
        return
    panel.plot(scale * interval.mean, y, "o", color=colour, markersize=4)
    if interval.low_holm is not None and interval.high_holm is not None:
        panel.plot([scale * interval.low_holm, scale * interval.high_holm], [y, y], color=colour, linewidth=1.4)


def _scale(metric: str) -> float:
    """Return what a figure is multiplied by for people: a share is shown in percent."""
    return 100.0 if metric == "picker_utilisation" else 1.0


def _fronts(comparison: Comparison, first: str, second: str, width: float | None, sets: Sequence[str]) -> Figure:
    """Means of all rule sets in two metrics, a panel for each instance set; those none beats in both are joined.

    Of many rule sets only the baseline and those on a front are named.
    """
    rule_sets: Sequence[str] = comparison.rule_sets
    if len(rule_sets) > MOST_NAMED:
        on_front = {one.rule_set for name in sets for one, _ in comparison.front(name, first, second)}
        rule_sets = [name for name in rule_sets if name in on_front or name == comparison.baseline]
    columns = min(2 if width is None else max(1, int(width / 3)), len(sets))
    lines, whole = -(-len(sets) // columns), width or 4.6 * columns
    names = [_wrapped(f"{number} {name}", whole - 0.3) for number, name in enumerate(rule_sets, 1)]
    beside = _legend_columns(names, whole)
    rows = sum(max(name.count("\n") + 1 for name in names[i : i + beside]) for i in range(0, len(names), beside))
    figure = _figure(whole, (3.6 if width is None else 2.6) * lines + (0.21 if width is None else 0.17) * rows)
    panels = list(figure.subplots(lines, columns, squeeze=False).flat)
    for panel, name in zip(panels, sets, strict=False):
        _front(panel, comparison, name, (first, second), rule_sets, whole / columns)
    for panel in panels[len(sets) :]:
        panel.set_visible(False)
    handles = [panels[0].plot([], [], " ")[0] for _ in names]  # names next to the points would overlap
    figure.legend(handles, names, loc="outside lower center", ncols=beside, handlelength=0, handletextpad=0)
    return figure


def _front(
    panel: Axes,
    comparison: Comparison,
    instances: str,
    metrics: tuple[str, str],
    named: Sequence[str],
    width: float,
) -> None:
    first, second = metrics
    both = zip(comparison.of(instances, first), comparison.of(instances, second), strict=True)
    shown = [(one, other) for one, other in both if one.mean is not None and other.mean is not None]
    across, up = _scale(first), _scale(second)
    points = [(across * (a.mean or 0), up * (b.mean or 0), a.rule_set) for a, b in shown]
    panel.plot([x for x, _, _ in points], [y for _, y, _ in points], "o", color="0.75")
    front = comparison.front(instances, first, second)
    xs, ys = [across * (a.mean or 0) for a, _ in front], [up * (b.mean or 0) for _, b in front]
    panel.plot(xs, ys, "o-", color=COLOURS[0], markersize=4, linewidth=1, drawstyle="steps-post")
    for x, y, rule_set in points:
        if rule_set not in named:
            continue
        number = named.index(rule_set) + 1
        panel.annotate(str(number), (x, y), AROUND[number % len(AROUND)], textcoords="offset points")
    for one, other in shown[:1]:
        for bound, line, scale in ((one.bound, panel.axvline, across), (other.bound, panel.axhline, up)):
            if bound is not None:
                line(scale * bound, linestyle="--", color="black", linewidth=1)
    if len(shown_sets(comparison)) > 1:
        panel.set_title(_wrapped(instances, width - 0.6))
    panel.set_xlabel("\n".join([_wrapped(_title(comparison, first), width - 0.6), *_aim(first)]))
    panel.set_ylabel("\n".join([_wrapped(_title(comparison, second), 2.0), *_aim(second)]))
    panel.set_xlim(left=0)
    panel.set_ylim(bottom=0)


def _runs(rows: Sequence[Mapping[str, Any]], comparison: Comparison, metric: str, paper_width: float | None) -> Figure:
    """Every run that counts as a dot, means and bounds of the table as bars, by instance set and rule set."""
    sets = shown_sets(comparison)
    found = {(one.rule_set, one.instances): one for name in sets for one in comparison.of(name, metric)}
    whole = paper_width or max(4.0, 1.2 + 0.45 * len(comparison.rule_sets) * len(sets))
    names = [_wrapped(rule_set, whole - 0.6) for rule_set in comparison.rule_sets]
    columns = _legend_columns(names, whole)
    room = (whole - 0.7) / len(sets)
    labels = ["\n".join(_wrapped(part, max(room, 1.2)) for part in name.split(", ")) for name in sets]
    lines = [line for label in labels for line in label.split("\n")]
    rotated = LETTER * (max(map(len, lines)) + 2) > room  # two of them apart
    below = LETTER * max(map(len, lines)) if rotated else 0.15 * max(label.count("\n") for label in labels)
    figure = _figure(whole, 2.6 + below + 0.15 * -(-len(names) // columns))
    panel = figure.subplots()
    width = 0.8 / len(comparison.rule_sets)
    lowest = 0.0
    by_set = _values(rows, comparison, metric, sets)
    many = sum(map(len, by_set.values())) > MOST_DOTS
    for place, rule_set in enumerate(comparison.rule_sets):
        colour = COLOURS[place % len(COLOURS)]
        for column, name in enumerate(sets):
            x = column + (place - (len(comparison.rule_sets) - 1) / 2) * width
            values = by_set.get((rule_set, name), [])
            if not values:
                continue
            offsets = [(0.5 - (i + 0.5) / len(values)) * width * 0.7 for i in range(len(values))]
            dots: dict[str, Any] = {"color": colour, "markersize": 3, "alpha": 0.5, "rasterized": many}
            panel.plot([x + offset for offset in offsets], values, "o", **dots)
            lowest = min(lowest, *values)
            one = found[rule_set, name]
            if one.mean is not None:
                bar = [_scale(metric) * one.mean] * 2
                panel.plot([x - width * 0.42, x + width * 0.42], bar, color=colour, linewidth=2.2)
            if one.bound is not None:
                bar = [_scale(metric) * one.bound] * 2
                panel.plot([x - width / 2, x + width / 2], bar, "--", color="black", linewidth=1)
        panel.plot([], [], "o", color=colour, label=names[place])
    if comparison.bounded(metric):
        panel.set_xlabel("dashed: what no rules can beat")
    panel.set_xticks(range(len(sets)), labels, rotation=90 if rotated else 0)
    panel.set_xlim(-0.5, len(sets) - 0.5)
    if lowest == 0:
        panel.set_ylim(bottom=0)
    panel.set_ylabel("\n".join([_wrapped(_title(comparison, metric), 2.0), *_aim(metric)]))
    figure.legend(loc="outside upper left", ncols=columns)
    return figure


def _values(
    rows: Sequence[Mapping[str, Any]], comparison: Comparison, metric: str, sets: Sequence[str]
) -> dict[tuple[str, str], list[float]]:
    """Return the figures of the runs that count by rule set and instance set."""
    found: dict[tuple[str, str], list[float]] = {}
    for row in rows:
        if row["status"] in COUNTED and row.get(metric) is not None:
            for name in (one for one in sets if comparison.holds(one, row)):
                found.setdefault((row["rule_set"], name), []).append(_scale(metric) * row[metric])
    return found
