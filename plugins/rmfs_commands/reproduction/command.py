"""``rmfs reproduce``: the paper's evaluation, run again and compared with its figures."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rmfs_commands.cli.notes import notes_console
from rmfs_commands.cli.options import dask_option, jobs_option, json_option, quiet_option, runs_out_option
from rmfs_commands.cli.screen import new_table, output_console, print_json, say

if TYPE_CHECKING:
    from rich.console import Console

    from rmfs_commands.reproduction import Reproduction


@click.command(short_help="Run the paper's evaluation, figure by figure.")
@click.option(
    "--only",
    multiple=True,
    metavar="PART",
    help="Run this part alone: examples, instances, packing, prefilter or large. May be given several times.",
)
@click.option("--quick", is_flag=True, help="One seed of the instances of 50 orders, and the examples: under a minute.")
@jobs_option
@dask_option
@runs_out_option("report", "rmfs-runs/reproduce, rmfs-runs/reproduce-quick")
@json_option
@quiet_option
def reproduce(
    only: tuple[str, ...],
    quick: bool,
    jobs: int | None,
    dask: str | None,
    out: Path | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Run the evaluation of the paper (arXiv:1902.03092, Section 4) and compare its figures with ours.

    The parts are the shipped experiments paper-examples, paper-instances (24 instances, four methods, ten seeds),
    paper-packing, paper-prefilter and paper-2000. Every finished run is kept in DIR/runs, so that an interrupted
    reproduction goes on where it stopped; delete that folder to compute everything again. The report, report.html and
    report.md, has every table and figure of that section next to ours. Exit code 1 when a run failed.
    """

    from rmfs_commands.cli.compiling import compile_searches
    from rmfs_commands.experiments.progress import experiment_display
    from rmfs_commands.reproduction import choose_parts
    from rmfs_commands.reproduction import reproduce as run_parts
    from rmfs_core.errors import RunError
    from rmfs_core.scenario import load_scenario

    parts = choose_parts(only, quick)
    folder = out or Path("rmfs-runs") / ("reproduce-quick" if quick else "reproduce")
    notes = notes_console(quiet=quiet)
    compile_searches(notes, load_scenario("paper-250-integrated"))
    try:
        done = run_parts(
            parts,
            folder,
            quick=quick,
            command=shlex.join(["rmfs", *sys.argv[1:]]),
            jobs=jobs,
            dask=dask,
            watch=lambda name: experiment_display(notes, name),
        )
    except KeyboardInterrupt:
        say(notes, f"Finished runs are kept in {folder}; the same command goes on from there.")
        raise
    if as_json:
        overview = done.report.grids[0]
        rows = [dict(zip(overview.columns, row, strict=True)) for row in overview.rows]
        counted = {"runs": len(done.rows), "failed": len(done.failed)}
        print_json({"folder": str(folder), "files": list(done.files), **counted, "overview": rows})
    else:
        console = output_console(quiet=quiet)
        _print_overview(console, done)
        console.print()
        say(console, f"Report in {folder}:")
        say(console, f"  {', '.join(done.files)}")
    if done.failed:
        raise RunError(f"{len(done.failed)} of {len(done.rows)} runs failed; the report has their errors.")


def _print_overview(console: Console, done: Reproduction) -> None:
    """Print the verdicts by exhibit, and how the runs ended."""
    from rich.text import Text

    overview, runs = done.report.grids[:2]
    table = new_table(overview.title)
    for number, column in enumerate(overview.columns):
        table.add_column(Text(column), justify="right" if number in overview.right else "left", overflow="fold")
    for row in overview.rows:
        table.add_row(*map(Text, row))
    console.print()
    console.print(table)
    say(console, runs.notes[0])
