"""`rmfs replay`: watch a recorded run."""

from __future__ import annotations

from pathlib import Path

import click

from rmfs_cli.options import quiet_option

PAGE = "replay.html"


@click.command(short_help="Write a recorded run as a page to watch.")
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.argument("other", metavar="[OTHER]", required=False, type=click.Path(path_type=Path))
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help=f"Where the page shall be. [default: DIR/{PAGE}]",
)
@quiet_option
def replay(folder: Path, other: Path | None, out: Path | None, quiet: bool) -> None:
    """Write the run in DIR as a page: the warehouse, robots, pods and orders in motion.

    DIR is what `rmfs run --trace --out DIR` wrote, or a trace file. With OTHER, another run, the page shows both side by
    side on one clock. The page is one HTML file that needs no network. What was recorded with `--record-decisions` says
    in it why something was done.
    """
    from rmfs_core.results.files import write_text
    from rmfs_replay.page import page
    from rmfs_replay.reading import read_replay

    replays = [read_replay(one) for one in (folder, other) if one is not None]
    target = out or (folder if folder.is_dir() else folder.parent) / PAGE
    write_text(target, page(replays))
    if not quiet:
        click.echo(f"Open {target} in a browser.")
