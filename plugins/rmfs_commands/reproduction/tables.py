"""A table of the report: the paper's figures next to ours, row by row."""

from __future__ import annotations

from attrs import frozen

from rmfs_commands.reproduction.estimates import Estimate
from rmfs_commands.reproduction.paper import Exhibit, Range

IN_RANGE, BELOW, ABOVE = "in range", "below", "above"
NO_NUMBER = "no number in the paper"
NO_RUN = "no complete run"


@frozen
class Line:
    """A figure of the paper next to ours.

    Parameters
    ----------
    label
        Its subject: parts such as instance set, method.
    paper
        The paper's figure or range; None where it has none.
    ours
        Ours; None where no run gave one.
    verdict
        ``"in range"``, ``"below"``, ``"above"``, how many times faster or slower, or why there is nothing to compare.
    speedup
        Of a figure of computing time that the paper has too: how many times faster ours is.
    """

    label: tuple[str, ...]
    paper: Range | None
    ours: Estimate | None
    verdict: str
    speedup: float | None = None


@frozen
class Table:
    """Verdict on an exhibit of the paper.

    Parameters
    ----------
    exhibit
        The paper's.
    lines
        Its figures.
    unit
        Of all figures in it; empty for plain numbers.
    digits
        Digits after the point that make sense.
    what
        The quantity shown, where the exhibit's caption leaves it open.
    """

    exhibit: Exhibit
    lines: tuple[Line, ...]
    unit: str
    digits: int
    what: str = ""

    def ours(self, *label: str) -> Estimate | None:
        """Return our figure under a label; None when there is none."""
        return next((line.ours for line in self.lines if line.label == label), None)

    def paper(self, *label: str) -> Range | None:
        """Return the paper's figure under a label; None when there is none."""
        return next((line.paper for line in self.lines if line.label == label), None)


def in_range(label: tuple[str, ...], paper: Range | None, ours: Estimate | None) -> Line:
    """Return a line whose verdict says where our mean lies."""
    if paper is None or ours is None:
        return _without_verdict(label, paper, ours)
    return Line(label, paper, ours, place(ours.mean, paper))


def place(figure: float, paper: Range) -> str:
    """Say where a figure lies with regard to the paper's range."""
    if figure < paper.low:
        return BELOW
    return ABOVE if figure > paper.high else IN_RANGE


def as_factor(label: tuple[str, ...], paper: Range | None, ours: Estimate | None) -> Line:
    """Return a line of computing time, whose verdict says how many times faster or slower ours is."""
    if paper is None or ours is None:
        return _without_verdict(label, paper, ours)
    speedup = (paper.low + paper.high) / 2 / ours.mean
    return Line(label, paper, ours, speed(speedup), speedup)


def _without_verdict(label: tuple[str, ...], paper: Range | None, ours: Estimate | None) -> Line:
    return Line(label, paper, ours, NO_RUN if ours is None else NO_NUMBER)


def speed(speedup: float) -> str:
    """Return a speedup in words."""
    return f"{_short(speedup)} times faster" if speedup >= 1 else f"{_short(1 / speedup)} times slower"


def _short(factor: float) -> str:
    return f"{factor:.1f}" if factor < 10 else f"{factor:,.0f}"
