"""``rmfs import``: files of other simulators and benchmarks."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rmfs_commands.cli.options import OutPath, WholeNumberRange, json_option
from rmfs_commands.cli.screen import new_table, output_console, print_json, say

if TYPE_CHECKING:
    from rmfs_commands.import_.notes import Imported

REPORT = "import.json"


@click.command("import", short_help="Make scenarios and maps from files of other programs.")
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--format",
    "asked",
    type=click.Choice(["rawsim-o", "rhcr", "lorr", "movingai"]),
    help="Format of the files. [default: told by their first lines]",
)
@click.option("--out", required=True, metavar="DIR", type=OutPath(), help="Folder to write to.")
@click.option(
    "--seed", type=WholeNumberRange(min=0), default=1, show_default=True, help="Seed of trips of RHCR's maps."
)
@click.option("--force", is_flag=True, help="Replace files that are there already.")
@json_option
def import_(files: tuple[Path, ...], asked: str | None, out: Path, seed: int, force: bool, as_json: bool) -> None:
    """Make a scenario, a text map and CSV files from FILEs of one instance.

    RAWSim-O: an .xinst or .xlayo, and if you have them .xsett, .xgenc or .xitem, .xconf. RHCR: a .map or .grid. League
    of Robot Runners (lorr): a problem in JSON, or a map. MovingAI: a .map, and a .scen. `rmfs run` or `rmfs plan` takes
    what is written to DIR. Everything without a counterpart is reported, also in DIR/import.json.
    """
    from rmfs_commands.cli.file_writing import write_files
    from rmfs_commands.import_.kinds import sorted_out
    from rmfs_commands.import_.rawsimo import import_rawsimo
    from rmfs_commands.import_.trips import import_lorr, import_movingai, import_rhcr
    from rmfs_commands.results.files import to_json

    chosen, found = sorted_out(files, asked)
    if chosen == "rawsim-o":
        imported = import_rawsimo(found)
    elif chosen == "rhcr":
        imported = import_rhcr(next(iter(found.values())), seed)
    elif chosen == "lorr":
        imported = import_lorr(next(iter(found.values())))
    else:
        imported = import_movingai(found["octile"], found.get("scen"))
    report = _report(imported)
    texts = {**imported.files, REPORT: to_json(report, indent=2) + "\n"}
    write_files(out, {name: text.encode() for name, text in texts.items()}, force=force)
    if as_json:
        print_json({**report, "folder": str(out)})
    else:
        _print(imported, out)


def _report(imported: Imported) -> Mapping[str, Any]:
    return {
        "format": imported.kind,
        "read": imported.read,
        "without_counterpart": [
            {"what": note.what, "number": note.number, "instead": note.instead} for note in imported.notes.taken
        ],
        "files": sorted((*imported.files, REPORT)),
        "command": "rmfs " + imported.command.replace("{}", "DIR"),
    }


def _print(imported: Imported, out: Path) -> None:
    console = output_console()
    read = ", ".join(f"{what} {number:,}" for what, number in imported.read.items())
    say(console, f"Read from {imported.kind}: {read}.")
    if imported.notes.taken:
        table = new_table("Without a counterpart in rmfs")
        table.add_column("What")
        table.add_column("Number", justify="right")
        table.add_column("Instead")
        for note in imported.notes.taken:
            table.add_row(note.what, f"{note.number:,}", note.instead)
        console.print(table)
    say(console, f"Wrote {', '.join(sorted((*imported.files, REPORT)))} to {out}.")
    words = (word.replace("{}", str(out)) for word in imported.command.split())
    say(console, f"Run it with: {shlex.join(['rmfs', *words])}")
