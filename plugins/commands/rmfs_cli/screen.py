"""What commands print: tables, lines, JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table


def table_console(pipe_width: int) -> Console:
    """Return a console as wide as the terminal; ``pipe_width`` columns wide where the output is none."""
    from rich.console import Console

    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=pipe_width)


def print_named(console: Console, table: Table) -> None:
    """Print a table of figures, its first column names: beside their rows, or above them where they are too long.

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
    for line in lines[:head]:
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
    import click

    from rmfs_core.results.files import json_ready, to_json

    def plain(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: plain(entry) for key, entry in value.items()}
        if isinstance(value, list | tuple):
            return [plain(entry) for entry in value]
        return plain(attrs.asdict(value, recurse=False)) if attrs.has(type(value)) else value

    click.echo(to_json(json_ready(plain(value)), indent=2))
