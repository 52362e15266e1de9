"""Output of commands: tables, lines, JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from rmfs_core.errors import RmfsError


PIPE_WIDTH = 80
"""Columns where the output is no terminal, unless the variable COLUMNS says another number."""

ROOM_FOR_WORDS = 36
"""Columns that sentences want, at least, next to a name."""


def output_console(*, quiet: bool = False) -> Console:
    """Return where a command prints: as wide as the terminal, or `PIPE_WIDTH` columns; no line ends in blanks.

    Nothing that is printed is markup: names of users stand in nearly every table.
    """
    from rich.console import Console

    from rmfs_commands.cli.trimming import WithoutTrailingBlanks
    from rmfs_commands.cli.visible import VisibleSigns

    console = Console(highlight=False, markup=False, quiet=quiet)
    if not (console.is_terminal or os.environ.get("COLUMNS")):  # rich would ask the terminal of another stream
        console = Console(highlight=False, markup=False, quiet=quiet, width=PIPE_WIDTH)
    console.push_render_hook(VisibleSigns())
    console.push_render_hook(WithoutTrailingBlanks())
    return console


def new_table(title: str | None = None) -> Table:
    """Return a table as all commands have them: a line below the headings, no box."""
    from rich import box
    from rich.table import Table

    return Table(
        title=title,
        title_justify="left",
        title_style="bold",
        box=box.SIMPLE_HEAD,
        header_style="bold cyan",
        pad_edge=False,
        collapse_padding=True,
    )


def print_described(console: Console, described: Mapping[str, str]) -> None:
    """Print names and what they are: side by side, or one below the other where they do not fit."""
    from rich.padding import Padding
    from rich.table import Table
    from rich.text import Text

    longest = max(map(len, described), default=0)
    if longest + 2 + ROOM_FOR_WORDS <= console.width:
        grid = Table.grid(padding=(0, 2, 0, 0))
        grid.add_column(no_wrap=True)
        grid.add_column()
        for name, text in described.items():
            grid.add_row(Text(name), Text(text))
        console.print(grid)
        return
    for name, text in described.items():
        console.print(Text(name), soft_wrap=True)
        console.print(Padding(Text(text), (0, 0, 0, 4)))


def print_named(console: Console, table: Table) -> None:
    """Print a table of figures, its first column names: next to their rows, or above them where they are too long.

    Parameters
    ----------
    console
        Where to.
    table
        The cells of its other columns are a line each.
    """
    from rich.measure import Measurement
    from rich.segment import Segment, Segments
    from rich.table import Table
    from rich.text import Text

    for column in table.columns:
        column.no_wrap = True
    unlimited = console.options.update(max_width=10_000)
    if Measurement.get(console, unlimited, table).maximum <= console.width:
        console.print(table)
        return
    figures = Table(box=table.box, header_style=table.header_style, pad_edge=table.pad_edge)
    figures.padding, figures.collapse_padding = table.padding, table.collapse_padding
    names, *columns = table.columns
    for column in columns:
        figures.add_column(column.header, justify=column.justify, style=column.style, no_wrap=True)
    for cells in zip(*(column.cells for column in columns), strict=True):
        figures.add_row(*cells)
    lines = console.render_lines(figures, pad=False)
    below = 1 if table.box else 0  # an empty line of the box
    head = len(lines) - table.row_count - below
    if table.title:
        console.print(table.title, style=table.title_style or "")
    for number, line in enumerate(lines[:head]):
        if number == below and names.header:
            console.print(names.header, style=table.header_style or "", soft_wrap=True)
        console.print(Segments([*line, Segment.line()]), end="")
    for name, line in zip(names.cells, lines[head:], strict=False):
        console.print(name if isinstance(name, Text) else Text(str(name)), soft_wrap=True)
        if any(segment.text.strip() for segment in line):
            console.print(Segments([*line, Segment.line()]), end="")
    if below:
        console.print()


def say(console: Console, text: str, style: str = "") -> None:
    """Print a line as it is: nothing in it is markup, and only the reader's terminal wraps it."""
    console.print(text, style=style, markup=False, highlight=False, soft_wrap=True)


def print_json(value: Any) -> None:
    """Print plain values and attrs objects as JSON: all that a command with ``--json`` writes to the output."""
    import attrs

    from rmfs_commands.cli.streams import answer
    from rmfs_commands.results.files import json_ready, to_json

    def plain(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: plain(entry) for key, entry in value.items()}
        if isinstance(value, list | tuple):
            return [plain(entry) for entry in value]
        return plain(attrs.asdict(value, recurse=False)) if attrs.has(type(value)) else value

    answer(visible_json(to_json(json_ready(plain(value)), indent=2)))


def failure(error: RmfsError, code: int) -> dict[str, Any]:
    """Return what a command with ``--json`` prints where it fails: the sentence, and its parts."""
    from rmfs_core.wording import sentence

    place = None if error.place is None else sentence(error.place)
    problem = sentence(error.problem).removeprefix("Error: ")
    return {"error": sentence(str(error)), "place": place, "problem": problem, "exit_code": code}


def visible_json(text: str) -> str:
    """Return JSON that says the same, with every sign that would steer a terminal written as JSON escapes it."""
    if text.isascii() and "\x7f" not in text:  # JSON escapes all others of these
        return text
    return "".join(sign if sign.isprintable() or sign == "\n" else json.dumps(sign)[1:-1] for sign in text)


def tell(text: str, *, err: bool = False) -> None:
    """Print a line for people, or several, with no sign in it that would steer a terminal."""
    import click

    from rmfs_core.wording import visible

    click.echo(visible(text), err=err)
