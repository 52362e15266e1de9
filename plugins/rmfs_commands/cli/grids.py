"""Tables as text cells, for papers: as CSV, and what `rmfs_commands.cli.latex` has in LaTeX."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Collection, Sequence

from attrs import frozen


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


def grid_csv(grid: Grid) -> str:
    """Return a grid as CSV, the cells as they are shown."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    for row in (grid.columns, *grid.rows):
        writer.writerow(
            cell if number in grid.right else no_formula(" ".join(cell.split())) for number, cell in enumerate(row)
        )
    return text.getvalue()


def grid_markdown(grid: Grid) -> str:
    """Return a grid as a section of Markdown."""
    lines = [f"## {grid.title}", "", *(f"{note}\n" for note in grid.notes)]
    rule = "|".join("---:" if number in grid.right else "---" for number in range(len(grid.columns)))
    lines += [_row(grid.columns), f"|{rule}|", *map(_row, grid.rows)]
    return "\n".join(lines) + "\n"


def _row(cells: tuple[str, ...]) -> str:
    return "| " + " | ".join(" ".join(cell.split()).replace("|", r"\|") for cell in cells) + " |"


def no_formula(text: str) -> str:
    """Return a text that no spreadsheet takes for a formula."""
    plain = text.replace("\r", " ")
    return f"'{plain}" if plain.lstrip().startswith(("=", "+", "-", "@")) else plain


def file_name(title: str) -> str:
    """Return what the file of a grid is called: the words of its title as far as the first comma or colon."""
    words = re.findall(r"\w+", re.split(r"[,:;(]", title)[0].lower())
    return "-".join(words)
