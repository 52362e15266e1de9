"""`rmfs scenario`: check, show, draw and list scenarios."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rmfs_commands.cli.completion import SetCommand
from rmfs_commands.cli.options import (
    json_option,
    no_inline_option,
    scenario_argument,
    scenario_name,
    seed_option,
    set_option,
)
from rmfs_commands.cli.screen import print_json, tell
from rmfs_commands.cli.shipped import print_shipped

if TYPE_CHECKING:
    from rmfs_core.scenario import Scenario


@click.group()
def scenario() -> None:
    """Check, show, draw and list scenarios."""


@scenario.command(cls=SetCommand)
@scenario_argument
@set_option
@seed_option
@no_inline_option
@json_option
def check(scenario: str, overrides: tuple[str, ...], seed: int | None, no_inline_rules: bool, as_json: bool) -> None:
    """Report everything that is wrong with SCENARIO, without running it.

    Everything a run needs is made: orders and pods, the layout, the rules with their parameters. The load says whether
    pickers and robots can do what the orders want. Exit codes: 0 nothing is wrong, 2 something is.
    """
    from rmfs_commands.cli.checking import check_scenario
    from rmfs_commands.cli.loads import load_sentences
    from rmfs_core.wording import counted, sentence

    checked = check_scenario(scenario, overrides, seed, allow_inline=not no_inline_rules)
    for file in checked.inline_files:
        tell(f"Loaded code from {file}.", err=True)
    if as_json:
        found = {"valid": not checked.problems, "problems": checked.problems, "sizes": checked.sizes}
        print_json({**found, "loads": [load.to_dict() for load in checked.loads]})
    elif checked.problems:
        for problem in checked.problems:
            click.echo(sentence(f"Error: {problem['place']}: {problem['problem']}"), err=True)
    else:
        (_, orders), (_, items), *rest = checked.sizes.items()
        others = ", ".join(counted(number, what.removesuffix("s")) for what, number in rest)
        tell(f"{scenario} is valid: {counted(orders, 'order')} of {counted(items, 'item')}, {others}.")
        for note in (*load_sentences(checked.loads), *checked.notes):
            tell(note)
    if checked.problems:
        raise click.exceptions.Exit(2)


@scenario.command(cls=SetCommand)
@scenario_argument
@set_option
@seed_option
def show(scenario: str, overrides: tuple[str, ...], seed: int | None) -> None:
    """Print SCENARIO as TOML with every key, defaults included.

    Of the folder of a run, or of its result.json, it prints the scenario that was run: that repeats it, next to the
    files that it names.
    """
    from rmfs_commands.cli.checking import load_checked
    from rmfs_commands.cli.toml_scenario import to_toml
    from rmfs_commands.details.loading import load_result
    from rmfs_core.results import RESULT_FILE

    folder = Path(scenario).parent if Path(scenario).name == RESULT_FILE else Path(scenario)
    if not (folder / RESULT_FILE).is_file():
        shown = load_checked(scenario, overrides, seed)
    elif overrides or seed is not None:
        raise click.UsageError("--set and --seed change a scenario; expected neither with the folder of a run")
    else:
        shown = load_result(folder).scenario
    click.echo(to_toml(shown), nl=False)


@scenario.command(name="map", cls=SetCommand, short_help="Draw the layout of SCENARIO as text, or as a picture.")
@scenario_argument
@set_option
@seed_option
@click.option("--html", "as_page", is_flag=True, help="Write a page with a picture: stations, ways, pods, robots.")
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="File of the page. [default: SCENARIO-map.html]",
)
def map_(scenario: str, overrides: tuple[str, ...], seed: int | None, as_page: bool, out: Path | None) -> None:
    """Print the layout of SCENARIO as a text map, which `layout.map_file` reads.

    # is a storage location, O a picking station, . floor; > < ^ v and lines are floor that robots leave in these
    directions, arrows the cells of a queue, @ is wall. With `--html`, a page shows the hall before a run.
    """
    from rmfs_commands.cli.checking import load_checked
    from rmfs_commands.cli.map_drawing import draw_map
    from rmfs_core.errors import InputError
    from rmfs_core.scenario import located
    from rmfs_core.world import make_layout

    loaded = load_checked(scenario, overrides, seed)
    if as_page:
        _write_page(scenario_name(scenario), loaded, out)
        return
    if out is not None:
        raise InputError("--out", "is for a page; expected --html, too")
    with located(loaded):
        click.echo(draw_map(make_layout(loaded)), nl=False)


def _write_page(name: str, loaded: Scenario, out: Path | None) -> None:
    from rmfs_commands.cli.compiling import compiling_announced
    from rmfs_commands.cli.hall import hall
    from rmfs_commands.cli.notes import notes_console
    from rmfs_commands.cli.pages import check_target
    from rmfs_commands.results.files import write_text

    file = out or Path(f"{name}-map.html")
    check_target(file)
    with compiling_announced(notes_console()):
        page = hall(loaded, name).html
    write_text(file, page)
    tell(f"Open {file} in a browser.")


@scenario.command()
def schema() -> None:
    """Print the JSON Schema of scenario files, for editors."""
    import json

    from rmfs_commands.cli.schema import scenario_schema

    click.echo(json.dumps(scenario_schema(), indent=2))


@scenario.command(name="list")
@json_option
def list_(as_json: bool) -> None:
    """List the scenarios that come with the package."""
    from rmfs_core.scenario import shipped_scenarios

    print_shipped(shipped_scenarios(), as_json)
