"""Tables as text cells, for papers: LaTeX with booktabs, and CSV."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Collection, Sequence
from pathlib import Path

from attrs import frozen

from rmfs_core.results.files import write_text

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
    "\u00a0": "~",
    **{sign: f"\\{sign}" for sign in "&%$#_"},
}


@frozen
class Grid:
    """A titled grid of text.

    Parameters
    ----------
    title
        One line.
    notes
        Sentences about the grid.
    columns
        Headings.
    rows
        Cells, as many in each row as there are headings.
    right
        Numbers of the columns that hold figures and are aligned on the right.
    """

    title: str
    notes: tuple[str, ...]
    columns: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    right: Collection[int] = ()


def latex_text(text: str) -> str:
    """Return a text as LaTeX has it, on one line: no sign of it is a command."""
    return "".join(_SIGNS.get(sign, sign) for sign in " ".join(text.split()))


def to_latex(grid: Grid) -> str:
    """Return a grid as a ``table`` that needs the package booktabs; its title is the caption."""
    kinds = "".join("r" if number in grid.right else "l" for number in range(len(grid.columns)))
    lines = [r"\begin{table}", r"  \centering", rf"  \caption{{{latex_text(grid.title)}}}"]
    lines += [rf"  \begin{{tabular}}{{@{{}}{kinds}@{{}}}}", r"    \toprule", _line(grid.columns), r"    \midrule"]
    lines += [*map(_line, grid.rows), r"    \bottomrule", r"  \end{tabular}"]
    lines += [f"  % {' '.join(note.split())}" for note in grid.notes]
    return "\n".join([*lines, r"\end{table}", ""])


def _line(cells: Sequence[str]) -> str:
    first, *others = (latex_text(cell) for cell in cells)
    first = f"{{{first}}}" if first.startswith("[") else first  # else an argument of the row's end above it
    return f"    {' & '.join([first, *others])} \\\\"


def grid_csv(grid: Grid) -> str:
    """Return a grid as CSV, the cells as they are shown."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    for row in (grid.columns, *grid.rows):
        writer.writerow(
            cell if number in grid.right else no_formula(" ".join(cell.split())) for number, cell in enumerate(row)
        )
    return text.getvalue()


def no_formula(text: str) -> str:
    """Return a text that no spreadsheet takes for a formula."""
    plain = text.replace("\r", " ")
    return f"'{plain}" if plain.lstrip().startswith(("=", "+", "-", "@")) else plain


def file_name(title: str) -> str:
    """Return what the file of a grid is called: the words of its title as far as the first comma or colon."""
    words = re.findall(r"\w+", re.split(r"[,:;(]", title)[0].lower())
    return "-".join(words)


def write_grid(grid: Grid, file: Path) -> None:
    """Write a grid as the ending of a file's name says, ``.tex`` or ``.csv``, whole or not at all."""
    write_text(file, to_latex(grid) if file.suffix == ".tex" else grid_csv(grid))
