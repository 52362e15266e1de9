"""`rmfs validate`: check what a run recorded."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rmfs_commands.cli.options import WholeNumberRange, json_option
from rmfs_commands.cli.screen import new_table, output_console, print_json, tell

if TYPE_CHECKING:
    from rich.console import Console

    from rmfs_commands.validation import Fault, Report


@click.command(short_help="Check the trace of a run for impossible things.")
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option(
    "--collisions/--no-collisions",
    default=None,
    help="Check that no two robots hold a cell at once, or do not. Default: if the PP rule keeps robots apart.",
)
@click.option("--limit", type=WholeNumberRange(min=1), default=50, show_default=True, help="Faults to show at most.")
@json_option
def validate(folder: Path, collisions: bool | None, limit: int, as_json: bool) -> None:
    """Check the trace of a run in DIR: whether all of its events can have happened.

    DIR is what `rmfs run --trace --out DIR` wrote, or a trace file. It reads the trace and, if they are in the
    same folder, the metrics of result.json and the tables. Exit codes: 0 no faults, 1 with faults, 2 bad input.
    """
    from rmfs_commands.validation import check_trace

    report = check_trace(folder, collisions=collisions)
    if as_json:
        print_json(report)
        raise click.exceptions.Exit(1 if report.faults else 0)
    console = output_console()
    if report.faults:
        _print_faults(console, report.faults, limit)
    for line in _remarks(report, unasked=collisions is False):
        tell(line)
    if report.faults:
        raise click.exceptions.Exit(1)


def _print_faults(console: Console, faults: list[Fault], limit: int) -> None:
    from rich.text import Text

    table = new_table()
    table.add_column("Time", justify="right", no_wrap=True)
    table.add_column("Kind", style="bold red", no_wrap=True)
    table.add_column("Fault")
    for fault in faults[:limit]:
        table.add_row(f"{fault.time_s:.3f} s", fault.kind, Text(fault.sentence))
    console.print(table)
    if len(faults) > limit:
        tell(f"... and {len(faults) - limit} more; --limit shows more of them.")


def _remarks(report: Report, *, unasked: bool) -> list[str]:
    faults = len(report.faults)
    counted = {0: "no faults", 1: "1 fault"}.get(faults, f"{faults} faults")
    lines = [f"{counted} in {report.events} events"]
    if report.floor is not None:
        lines.append("Not checked, of a real day: ways, speeds, collisions, how long anything took, when bundles came.")
        if (corrected_s := report.floor["corrected_s"]) is not None:
            then = f"from {corrected_s:.3f} s on, when the floor first corrected what was known"
            lines.append(f"Not checked {then}: whether events fit those before. Metrics and tables are checked.")
    elif not report.collisions_checked:
        why = ", as --no-collisions asks."
        if not unasked:
            why = ". The trace says that its PP rule ignores other robots; --collisions checks it all the same."
        lines.append(f"NOT CHECKED: WHETHER ROBOTS COLLIDE{why}")
    if not report.start_checked:
        lines.append(
            "Not checked: whether the run starts from what its scenario makes; other versions of rmfs and numpy, or "
            "unknown ones, have recorded it."
        )
    if not report.metrics_checked:
        lines.append("Not checked: metrics; there is no result.json next to the trace.")
    return lines
