"""What commands print: tables, lines, JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console


def table_console(pipe_width: int) -> Console:
    """Return a console as wide as the terminal; ``pipe_width`` columns wide where the output is none."""
    from rich.console import Console

    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=pipe_width)


def say(console: Console, text: str) -> None:
    """Print a line as it is: nothing in it is markup, and only the reader's terminal wraps it."""
    console.print(text, markup=False, highlight=False, soft_wrap=True)


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
