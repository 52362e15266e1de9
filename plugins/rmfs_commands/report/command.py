"""``rmfs report``: one page on a run."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

import click

from rmfs_commands.cli.options import WholeNumberRange, quiet_option
from rmfs_commands.cli.screen import tell

PAGE, REPLAY = "report.html", "replay.html"


@click.command(short_help="Write a page on a run: what limits it, and why.")
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), metavar="FILE", help=f"File of the page. [default: DIR/{PAGE}]")
@click.option(
    "--limit", type=WholeNumberRange(min=1), default=10, show_default=True, help="Orders of each kind to list at most."
)
@quiet_option
def report(folder: Path, out: Path | None, limit: int, quiet: bool) -> None:
    """Write a page on the run in DIR: what limits it, its hours, stations, robots, and its slowest orders with causes.

    DIR is what `rmfs run --out DIR` wrote. The page is one HTML file that needs no network. With the trace of
    `rmfs run --trace` it has heat maps of the hall, and links to the page of `rmfs replay`, written next to it:
    replay.html, or with `--out page.html` page-replay.html. With `--record-decisions` it says of each order in it what
    `rmfs explain --order` says.
    """
    from rmfs_commands.cli.pages import check_target
    from rmfs_commands.report.page import run_page
    from rmfs_commands.report.reading import read_run
    from rmfs_commands.results.files import AtomicFile, write_text
    from rmfs_commands.trace import fitting

    target = out or folder / PAGE
    beside = target.with_name(f"{target.stem}-{REPLAY}" if out else REPLAY)
    for file in (target, beside):
        check_target(file)
    run = read_run(folder)
    with fitting(folder, "reported"):
        text = run_page(run, limit, replay=quote(beside.name) if run.replay else None)
        played = None
        if run.replay is not None:
            from rmfs_commands.replay.page import page

            played = page([run.replay])
    with AtomicFile(target) as stream:  # both or none
        stream.write(text.encode("utf-8", "backslashreplace"))
        if played is not None:
            write_text(beside, played)
    if not quiet:
        tell(f"Open {target} in a browser.")
