"""Grids as LaTeX tables that fit: into a column of two where they are narrow, else into the text of `article`.

How wide a text is, is reckoned with the letters of Computer Modern, LaTeX's own font, which is a wide one. A table that
is too wide has its names on several lines; one that is still too wide is split, with the names again next to each part.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from rmfs_commands.cli.grids import Grid, grid_csv
from rmfs_commands.results.files import write_text

COLUMN_PT, TEXT_PT = 220.0, 345.0
"""How wide a column of a page of two is at least, and the text of `article`."""
FONT_PT, GAP_PT = 8.0, 6.0
"""Of ``\\footnotesize``; between two columns of a table."""

_SIGNS = {
    "\\": r"\textbackslash{}",
    "{": r"\textbraceleft{}",  # BibTeX counts braces, those after a backslash, too
    "}": r"\textbraceright{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"{\char34}",  # \textquotedbl is none of the usual encoding OT1
    "\N{PLUS-MINUS SIGN}": r"$\pm$",
    "\N{MULTIPLICATION SIGN}": r"$\times$",
    "\N{MINUS SIGN}": "$-$",
    "\N{DAGGER}": r"\dag{}",
    "\u00a0": "~",
    **{sign: f"\\{sign}" for sign in "&%$#_"},
}

_THOUSANDTHS = {
    278: ".,;:ijl![]'\u2019",
    389: "frst()-\u20ac",
    500: "0123456789",
    722: "w",
    778: "+<>=\N{MINUS SIGN}\N{PLUS-MINUS SIGN}\N{MULTIPLICATION SIGN}GOQAKMNWU",
    833: "m%&",
    1028: "",
}
"""Widths of letters in thousandths of the font's size; small letters without an entry take 556, others 764."""
_WIDTHS = {sign: width for width, signs in _THOUSANDTHS.items() for sign in signs}


def latex_text(text: str) -> str:
    """Return a text as LaTeX has it, on one line: no sign of it is a command."""
    return "".join(_SIGNS.get(sign, sign) for sign in " ".join(text.split()))


def width_pt(text: str) -> float:
    """Return about how wide a text is in a table."""
    return sum(_WIDTHS.get(sign, 556 if sign.islower() or sign == " " else 764) for sign in text) * FONT_PT / 1000


def to_latex(grid: Grid, name: str) -> str:
    """Return a grid as a ``table`` that needs the package booktabs; its title is the caption, its label ``tab:NAME``.

    In a class with two columns a wide one spans both.
    """
    names = [number for number in range(len(grid.columns)) if number not in grid.right]
    rows = [grid.columns, *grid.rows]
    widths = [max(width_pt(row[number]) for row in rows) for number in range(len(grid.columns))]
    narrow = _total(widths) <= COLUMN_PT
    limits = _limits(widths, names, rows)
    parts = list(_parts(limits, names, len(grid.columns)))
    kind = "table" if narrow else "table*"
    lines = [rf"\begin{{{kind}}}", r"  \centering", rf"  \caption{{{latex_text(grid.title)}}}"]
    label = re.sub(r"[^A-Za-z0-9:._-]", "-", name)
    lines += [rf"  \label{{tab:{label}}}", r"  \footnotesize", rf"  \setlength{{\tabcolsep}}{{{GAP_PT / 2:g}pt}}"]
    for place, part in enumerate(parts):
        lines += [r"  \par\medskip"] if place else []
        kinds = "".join("r" if number in grid.right else "l" for number in part)
        lines += [rf"  \begin{{tabular}}{{@{{}}{kinds}@{{}}}}", r"    \toprule"]
        for number, row in enumerate(rows):
            lines += [r"    \midrule"] if number == 1 else []
            lines.append(_line([_cell(row[column], limits[column]) for column in part]))
        lines += [] if grid.rows else [r"    \midrule"]
        lines += [r"    \bottomrule", r"  \end{tabular}"]
    lines += [f"  % {' '.join(note.split())}" for note in grid.notes]
    return "\n".join([*lines, rf"\end{{{kind}}}", ""])


def _total(widths: Sequence[float]) -> float:
    return sum(widths) + GAP_PT * (len(widths) - 1)


def _limits(widths: Sequence[float], names: Sequence[int], rows: Sequence[Sequence[str]]) -> list[float]:
    """Return how wide each column may become: names give way where that is enough, else down to half of the text."""
    limits, least = [*widths], [*widths]
    for number in names:
        parts = (width_pt(part) for row in rows for part in _breakable(row[number]))
        least[number] = max(parts, default=0.0) + 0.01  # no part of a text is wider than it for being summed otherwise
    split = _total(least) > TEXT_PT
    for number in sorted(names, key=lambda number: -widths[number]):
        most = TEXT_PT / 2 / len(names) if split else limits[number] - (_total(limits) - TEXT_PT)
        limits[number] = max(least[number], min(limits[number], most))
    return limits


def _parts(limits: Sequence[float], names: Sequence[int], columns: int) -> Iterator[list[int]]:
    """Yield the columns of each part of a table: the names, and as many figures as fit next to them."""
    part = [*names]
    for number in (number for number in range(columns) if number not in names):
        if len(part) > len(names) and _total([limits[one] for one in (*part, number)]) > TEXT_PT + 0.01:
            yield sorted(part)
            part = [*names]
        part.append(number)
    yield sorted(part)


def _breakable(text: str) -> list[str]:
    """Return the parts of a text between which a line may end: words, and what hyphens join."""
    return re.findall(r"[^\s-]+-?|-+", text)


def _cell(text: str, limit: float) -> str:
    """Return a cell in LaTeX, on several lines where it is wider than its column may be."""
    if width_pt(text) <= limit:
        return latex_text(text)
    lines = [""]
    for part in re.findall(r"[^\s-]+-?\s*|-+\s*", text):
        if lines[-1] and width_pt(f"{lines[-1]}{part}".rstrip()) > limit:
            lines.append("")
        lines[-1] += part
    inner = r" \\ ".join(latex_text(line) for line in lines)
    return rf"\begin{{tabular}}[t]{{@{{}}l@{{}}}}{inner}\end{{tabular}}"


def _line(cells: Sequence[str]) -> str:
    first, *others = cells
    first = f"{{{first}}}" if first.startswith("[") else first  # else an argument of the row's end above it
    return f"    {' & '.join([first, *others])} \\\\"


def write_grid(grid: Grid, file: Path) -> None:
    """Write a grid as the ending of a file's name says, ``.tex`` or ``.csv``, whole or not at all."""
    write_text(file, to_latex(grid, file.stem) if file.suffix == ".tex" else grid_csv(grid))
