"""Command ``rmfs acme-first``."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(name="acme-first")
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
def first(folder: Path) -> None:
    """Print when each station had its first pick in the run in DIR."""
    from acme.observer import FILE
    from rmfs import InputError, load_result

    result = load_result(folder)
    if not (folder / FILE).is_file():
        raise InputError(str(folder), "the run had no observer acme-first-picks")
    _, *rows = (folder / FILE).read_text(encoding="utf-8").splitlines()
    for station, first_s in (row.split(",") for row in rows):
        click.echo(f"station {station}: {first_s} s of {result.metrics['makespan_s']} s")
