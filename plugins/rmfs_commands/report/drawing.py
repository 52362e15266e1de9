"""Small plots as SVG inside a page: as wide as a phone, in the page's colours, each bar with its figure as a title."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from attrs import frozen
from markupsafe import Markup

from rmfs_core.wording import counted

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 360, 190, 46, 6, 10, 34
ACROSS, DOWN = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM
MOST_LABELS = 6
"""On the axis below a plot."""


@frozen
class Series:
    """Figures over classes of equal width.

    Parameters
    ----------
    name
        Its title.
    values
        A figure for each class.
    colour
        Number of the page's colour.
    line
        Whether a line is drawn instead of bars.
    """

    name: str
    values: Sequence[float]
    colour: int = 1
    line: bool = False


def nice(least: float) -> float:
    """Return the smallest of 1, 2, 5, 10, 20 ... times a power of 10 that is not less."""
    if least <= 0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(least))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= least * (1 - 1e-9))


def chart(
    title: str,
    series: Sequence[Series],
    step: float,
    below: str,
    *,
    shown: Callable[[float], str] = "{:,g}".format,
    marks: Mapping[str, float] | None = None,
) -> Markup:
    """Return a plot of figures over classes of equal width that begin at 0.

    Parameters
    ----------
    title
        Its title.
    series
        The figures, bars before lines.
    step
        Width of a class.
    below
        Title of the axis below.
    shown
        How a value on that axis is written.
    marks
        Values on that axis to be marked, by name.
    """
    number = max(len(one.values) for one in series)
    most = max((value for one in series for value in one.values), default=0)
    unit = max(nice(most / 4), 1)
    top = unit * max(math.ceil(most / unit), 1)
    across, down = ACROSS / max(number, 1), DOWN / top
    parts = [_line(y, f"{unit * i:,g}") for i in range(round(top / unit) + 1) for y in [TOP + DOWN - unit * i * down]]
    for one in series:
        if one.line:
            ends = ((i + side, value) for i, value in enumerate(one.values) for side in (0, 1))
            points = " ".join(f"{LEFT + i * across:.1f},{TOP + DOWN - value * down:.1f}" for i, value in ends)
            parts.append(Markup('<polyline points="{}" style="stroke:var(--c{})"/>').format(points, one.colour))
            continue
        for i, value in enumerate(one.values):
            if value:
                thing = one.name.removesuffix("s")
                number_of = f"{value:,g} {thing}" if thing == one.name else counted(int(value), thing)
                says = f"{shown(i * step)} to {shown((i + 1) * step)}: {number_of}"
                parts.append(_bar(i * across, across, TOP + DOWN - value * down, value * down, one.colour, says))
    every = nice(number / MOST_LABELS) if number > MOST_LABELS else 1
    labelled = range(0, number + 1, max(int(every), 1))
    parts += [_text(LEFT + i * across, HEIGHT - BOTTOM + 14, shown(i * step)) for i in labelled]
    for place, (name, value) in enumerate((marks or {}).items()):
        x = LEFT + min(value / step, number) * across
        rule = Markup('<line class="mark" x1="{0:.1f}" x2="{0:.1f}" y1="{1}" y2="{2}"/>')
        parts.append(rule.format(x, TOP, TOP + DOWN))
        end = x > LEFT + 0.5 * ACROSS
        parts.append(_text(x + (-4 if end else 4), TOP + 8 + 13 * place, name, "end" if end else "start", "mark"))
    parts.append(_text(LEFT + ACROSS / 2, HEIGHT - 4, below))
    legend = [(one.name, one.colour) for one in series] if len(series) > 1 else []
    return _figure(title, parts, legend)


def stacked(title: str, names: Sequence[str], parts: Sequence[Series], below: str) -> Markup:
    """Return a plot with a column for each name: shares of its parts, which are left out where all are 0."""
    kept = [one for one in parts if any(one.values)]
    wholes = [sum(of) or 1.0 for of in zip(*(one.values for one in kept), strict=True)] or [1.0] * len(names)
    across = ACROSS / max(len(names), 1)
    drawn = [_line(TOP + DOWN * (1 - share / 100), f"{share} %") for share in (0, 25, 50, 75, 100)]
    bottoms = [0.0] * len(wholes)
    for one in kept:
        for i, (name, value) in enumerate(zip(names, one.values, strict=True)):
            height = DOWN * value / wholes[i]
            if height:
                says = f"{below} {name}: {one.name} {100 * value / wholes[i]:.1f} %"
                y = TOP + DOWN - bottoms[i] - height
                drawn.append(_bar(i * across, across, y, height, one.colour, says))
            bottoms[i] += height
    every = math.ceil(len(names) / 12)
    labelled = range(0, len(names), every)
    drawn += [_text(LEFT + (i + 0.5) * across, HEIGHT - BOTTOM + 14, names[i]) for i in labelled]
    drawn.append(_text(LEFT + ACROSS / 2, HEIGHT - 4, below))
    return _figure(title, drawn, [(one.name, one.colour) for one in kept])


def _bar(x: float, width: float, y: float, height: float, colour: int, says: str) -> Markup:
    gap = min(width * 0.15, 3)
    box = Markup('<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" style="fill:var(--c{})">')
    return box.format(LEFT + x + gap / 2, y, width - gap, height, colour) + Markup("<title>{}</title></rect>").format(
        says
    )


def _line(y: float, text: str) -> Markup:
    rule = Markup('<line x1="{}" x2="{}" y1="{:.1f}" y2="{:.1f}"/>').format(LEFT, WIDTH - RIGHT, y, y)
    return rule + _text(LEFT - 5, y + 4, text, "end")


def _text(x: float, y: float, text: str, anchor: str = "middle", kind: str = "") -> Markup:
    line = Markup('<text x="{:.1f}" y="{:.1f}" text-anchor="{}" class="{}">{}</text>')
    return line.format(x, y, anchor, kind, text)


def _figure(title: str, parts: Sequence[Markup], legend: Sequence[tuple[str, int]]) -> Markup:
    keys = Markup("").join(
        Markup('<span><i style="background:var(--c{})"></i>{}</span>').format(colour, name) for name, colour in legend
    )
    text = '<figure><figcaption>{0}</figcaption>{3}<svg viewBox="0 0 {1} {2}" role="img" aria-label="{0}">'
    below = Markup('<p class="key">{}</p>').format(keys) if legend else ""
    begun = Markup(text).format(title, WIDTH, HEIGHT, below)
    return begun + Markup("<title>{}</title>").format(title) + Markup("").join(parts) + Markup("</svg></figure>")
