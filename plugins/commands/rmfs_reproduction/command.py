"""``rmfs reproduce``: the paper's evaluation, run again and held against its figures."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rmfs_cli.options import dask_option, jobs_option

if TYPE_CHECKING:
    from rich.console import Console

    from rmfs_reproduction import Reproduction


@click.command()
@click.option(
    "--only",
    multiple=True,
    metavar="PART",
    help="Run this part alone: examples, instances, packing, prefilter or large. May be given several times.",
)
@click.option("--quick", is_flag=True, help="One seed of the instances of 50 orders, and the examples: under a minute.")
@jobs_option
@dask_option
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder for finished runs and the report. [default: rmfs-runs/reproduce, rmfs-runs/reproduce-quick]",
)
@click.option("--quiet", "-q", is_flag=True, help="Print nothing but errors.")
def reproduce(
    only: tuple[str, ...], quick: bool, jobs: int | None, dask: str | None, out: Path | None, quiet: bool
) -> None:
    """Run the evaluation of the paper (arXiv:1902.03092, Section 4) and hold its figures against ours.

    The parts are the shipped experiments paper-examples, paper-instances (24 instances, four methods, ten seeds),
    paper-packing, paper-prefilter and paper-2000. Every finished run is kept in DIR/runs, so that an interrupted
    reproduction goes on where it stopped; delete that folder to compute everything again. The report, report.html and
    report.md, has every table and figure of that section beside ours. Exit code 1 when a run failed.
    """
    from rich.console import Console

    from rmfs_cli.run import announce_compiling
    from rmfs_core.scenario import load_scenario
    from rmfs_experiments.progress import progress_for
    from rmfs_reproduction import choose_parts
    from rmfs_reproduction import reproduce as run_parts

    parts = choose_parts(only, quick)
    folder = out or Path("rmfs-runs") / ("reproduce-quick" if quick else "reproduce")
    notes = Console(stderr=True, quiet=quiet)
    announce_compiling(notes, load_scenario("paper-250"))  # all parts but the examples plan paths by its rule
    try:
        done = run_parts(
            parts,
            folder,
            quick=quick,
            command=shlex.join(["rmfs", *sys.argv[1:]]),
            jobs=jobs,
            dask=dask,
            watch=lambda name: progress_for(notes, name),
        )
    except KeyboardInterrupt:
        _say(notes, f"Finished runs are kept in {folder}; the same command goes on from there.")
        raise
    console = Console(quiet=quiet)
    _print_overview(console, done)
    _conclude(console, done, folder)


def _print_overview(console: Console, done: Reproduction) -> None:
    """Print the verdicts by exhibit, and how the runs ended."""
    from rich.table import Table
    from rich.text import Text

    overview, runs = done.report.grids[:2]
    table = Table(title=overview.title, title_justify="left", title_style="bold", box=None, padding=(0, 2, 0, 0))
    for number, column in enumerate(overview.columns):
        table.add_column(Text(column), justify="right" if number in overview.right else "left", overflow="fold")
    for row in overview.rows:
        table.add_row(*map(Text, row))
    console.print()
    console.print(table)
    console.print()
    _say(console, runs.notes[0])


def _say(console: Console, text: str) -> None:
    """Print a line as it is: nothing in it is markup, and only the reader's terminal wraps it."""
    console.print(text, markup=False, highlight=False, soft_wrap=True)


def _conclude(console: Console, done: Reproduction, folder: Path) -> None:
    """Say where the files are, and that runs failed if some did."""
    from rmfs_core.errors import RunError

    console.print()
    _say(console, f"Report in {folder}:")
    _say(console, f"  {', '.join(done.files)}")
    if done.failed:
        raise RunError(f"{len(done.failed)} of {len(done.rows)} runs failed; the report has their errors.")
