"""`rmfs metrics`: what runs measure."""

from __future__ import annotations

import click

from rmfs_commands.cli.options import json_option
from rmfs_commands.cli.screen import new_table, output_console, print_json, tell


@click.command(short_help="List all metrics, with unit and meaning.")
@click.argument("words", metavar="[WORD]...", nargs=-1)
@json_option
def metrics(words: tuple[str, ...], as_json: bool) -> None:
    """List the metrics of result.json, with units and meanings; with WORDs, those in which each of them occurs.

    Experiments name them in `metrics`. Observers of your own measure more: what they say of it is shown by a run.
    """
    from attrs import asdict
    from rich.text import Text

    from rmfs_commands.details.catalogue import CATALOGUE, HOOK_TIMES, MEASURES
    from rmfs_commands.results.figures import TIMING
    from rmfs_commands.results.recorders import make_observers
    from rmfs_core.results.catalogue import described_by

    known = {metric.name for metrics in (*CATALOGUE.values(), MEASURES) for metric in metrics}
    others = described_by(observer for observer, _ in make_observers(quiet=True))
    more = tuple(metric for name, metric in others.items() if name not in known)
    groups = {**CATALOGUE, "Of other packages": more, "Wall clock (under `timing`)": (*TIMING, *HOOK_TIMES)}
    found = {
        heading: [
            one
            for one in metrics
            if all(word.lower() in f"{one.name} {one.label} {one.meaning}".lower() for word in words)
        ]
        for heading, metrics in groups.items()
    }
    if as_json:
        print_json([{**asdict(one), "group": heading} for heading, metrics in found.items() for one in metrics])
        return
    console = output_console()
    for heading, shown in found.items():
        if not shown:
            continue
        table = new_table(heading)
        for name in ("Name", "Unit", "Meaning"):
            table.add_column(name, no_wrap=name != "Meaning", overflow="fold")
        for one in shown:
            table.add_row(*map(Text, (one.name, one.unit if one.scale == 1 else "share", one.meaning)))
        console.print(table)
    if not any(found.values()):
        tell(f"No metric has {' and '.join(words)} in its name or meaning.")
