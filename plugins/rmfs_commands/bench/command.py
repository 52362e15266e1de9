"""``rmfs bench``: rules compared in the same worlds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rmfs_commands.cli import completion
from rmfs_commands.cli.notes import notes_console
from rmfs_commands.cli.options import WholeNumberRange, decides_option, json_option, no_inline_option
from rmfs_commands.cli.screen import new_table, output_console, print_json, print_named, tell
from rmfs_core.roles import Role

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from rmfs_commands.bench.bench import Contestant, Measured
    from rmfs_commands.cli.grids import Grid

WORLDS = ("small", "250", "2000")
ROLES = tuple(role for role in Role if role is not Role.OBSERVER)
TIMES = ("Calls", "ms\n/call", "s\n/run")
JSON_FORMAT = "rmfs-bench"
JSON_VERSION = 1


@click.command(short_help="Measure rules in the same worlds: how good, how quick.")
@click.argument("rules", metavar="RULE...", nargs=-1, required=True, shell_complete=completion.rules)
@click.option(
    "--world",
    "worlds",
    multiple=True,
    metavar="WORLD",
    shell_complete=completion.scenarios,
    help="World to run in: small, 250, 2000, or a scenario (a file, or the name of a shipped one), whose own rules "
    "make the other decisions. Repeatable. [default: small, 250]",
)
@click.option(
    "--seed", "seeds", multiple=True, type=WholeNumberRange(min=0), help="Seed. Repeatable. [default: 1, 2, 3]"
)
@click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    shell_complete=completion.overrides,
    help="Change the worlds (`instance.orders=50`) or a fixed rule (`rules.pp=sipp`). Repeatable.",
)
@decides_option(ROLES, help="Decision in which to compare rules that decide several things.")
@click.option(
    "--table",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="File to write all figures to: LaTeX for `.tex`, CSV for `.csv`.",
)
@json_option
@no_inline_option
def bench(
    rules: tuple[str, ...],
    worlds: tuple[str, ...],
    seeds: tuple[int, ...],
    overrides: tuple[str, ...],
    decides: Role | None,
    table: Path | None,
    as_json: bool,
    no_inline_rules: bool,
) -> None:
    """Run rules in the same worlds, and show how good and how quick they are.

    RULE is the name of an installed rule, or a table as in scenario files: `{ rule = "most-covered", n = 10 }`. Every
    other decision is made by a fixed rule (pod-match, demand, nearest, nearest-robot, free-flow), and rules that decide
    the same are compared; a POA+PPS rule replaces both rules, so it is compared with POA rules.
    Quality is the same each time, wall-clock time is not. Exit code 1 if a run failed.
    """

    from rmfs_commands.bench.bench import bench as run_all
    from rmfs_commands.bench.bench import contestant
    from rmfs_commands.cli.choices import option_named, parse_choice
    from rmfs_commands.cli.latex import write_grid

    if table is not None and table.suffix not in (".tex", ".csv"):
        raise click.BadParameter(f"expected a name that ends in .tex or .csv, found {table.name}", param_hint="--table")
    if table is not None and (table.is_dir() or not table.parent.is_dir()):  # said before minutes of runs
        raise click.BadParameter(f"expected a file in a folder that is there, found {table}", param_hint="--table")
    worlds, seeds = worlds or WORLDS[:2], seeds or (1, 2, 3)
    allow_inline = not no_inline_rules
    contestants = []
    for text in dict.fromkeys(rules):
        with option_named("rule", f"RULE {text}"):
            choice = parse_choice(text, f"RULE {text}")
            contestants.append(contestant(text, choice, decides=decides, allow_inline=allow_inline))
    notes = notes_console()
    with notes.status("...") as status:
        runs = list(
            run_all(contestants, worlds, seeds, overrides=overrides, allow_inline=allow_inline, before=status.update)
        )
    if as_json:
        print_json(_plain(contestants, overrides, runs))
    else:
        _print(output_console(), contestants, worlds, seeds, runs)
    if table is not None:
        write_grid(_grid(contestants, worlds, seeds, runs), table)
    failed = [run for run in runs if run.error is not None]
    for run in failed:
        tell(f"{run.rule}, {run.world}, seed {run.seed} failed: {run.error}", err=True)
    if failed:
        raise click.exceptions.Exit(1)


def _print(
    console: Console,
    contestants: Sequence[Contestant],
    worlds: Sequence[str],
    seeds: Sequence[int],
    runs: Sequence[Measured],
) -> None:
    from rich.rule import Rule
    from rich.text import Text

    for (world, field), rows in _groups(contestants, worlds, runs).items():
        heading = Text(f"{field} in world {world}, {_named(seeds)}", style="bold")
        console.print(Rule(heading, align="left", style="dim"))
        print_named(console, _table(rows))
    if sentence := _at_the_horizon(runs):
        console.print(Text(sentence))
    if any(one.role is Role.POA_PPS for one in contestants):
        console.print(Text("Calls and times (of a run) are the rule's own: a POA rule's are without its PPS rule."))


def _at_the_horizon(runs: Sequence[Measured]) -> str | None:
    """Return what the figures of runs are of that reached their horizon; None where no run did."""
    from rmfs_core.wording import counted

    number = sum(run.status == "horizon" for run in runs)
    if not number:
        return None
    which = f"{number} of {counted(len(runs), 'run')} ended at the horizon (run.until_s) with orders left"
    return f"{which}: visits, metres and turn-over time are of completed orders only."


def _named(seeds: Sequence[int]) -> str:
    return f"mean over seeds {', '.join(map(str, seeds))}" if len(seeds) > 1 else f"seed {seeds[0]}"


def _groups(
    contestants: Sequence[Contestant], worlds: Sequence[str], runs: Sequence[Measured]
) -> dict[tuple[str, str], dict[str, list[Measured]]]:
    """Return the runs of each rule, by the world and by what it decides."""
    return {
        (world, field): {
            one.text: [run for run in runs if (run.rule, run.world) == (one.text, world)]
            for one in contestants
            if one.field == field
        }
        for world in worlds
        for field in dict.fromkeys(one.field for one in contestants)
    }


def _table(rows: Mapping[str, Sequence[Measured]]) -> Table:
    from rich.text import Text

    from rmfs_commands.bench.bench import QUALITY

    table = new_table()
    table.add_column("Rule")
    for heading in QUALITY.values():
        table.add_column(heading, justify="right", no_wrap=True)
    for heading in TIMES:
        table.add_column(heading, justify="right", no_wrap=True, style="dim")
    for rule, runs in rows.items():
        table.add_row(Text(rule), *_quality(runs), *_times(runs))
    return table


def _grid(
    contestants: Sequence[Contestant], worlds: Sequence[str], seeds: Sequence[int], runs: Sequence[Measured]
) -> Grid:
    from rmfs_commands.bench.bench import QUALITY
    from rmfs_commands.cli.grids import Grid

    rows = [
        (field, world, rule, *_quality(measured), *_times(measured))
        for (world, field), by_rule in _groups(contestants, worlds, runs).items()
        for rule, measured in by_rule.items()
    ]
    columns = tuple(" ".join(heading.split()) for heading in ("Decides", "World", "Rule", *QUALITY.values(), *TIMES))
    horizon = _at_the_horizon(runs)
    title = f"Rules, {_named(seeds)}{f'. {horizon}' if horizon else ''}"
    return Grid(title, (), columns, rows, range(3, len(columns)))


def _times(runs: Sequence[Measured]) -> tuple[str, str, str]:
    calls, seconds = sum(run.calls for run in runs), sum(run.seconds for run in runs)
    per_call = f"{1000 * seconds / calls:,.3f}" if calls else "-"
    return f"{calls / len(runs):,.0f}", per_call, f"{seconds / len(runs):,.3f}"


def _quality(runs: Sequence[Measured]) -> list[str]:
    """Return the means of the metrics; how the runs ended instead, where one was interrupted or failed."""
    from rmfs_commands.bench.bench import QUALITY
    from rmfs_commands.details.catalogue import METRICS
    from rmfs_commands.results.figures import show

    ended = [run.status for run in runs if run.status not in ("complete", "horizon")]
    if ended:
        return [f"{len(ended)} of {len(runs)} {ended[0]}", *["-"] * (len(QUALITY) - 1)]
    metrics = {metric.name: metric for group in METRICS.values() for metric in group}
    return [show(metrics[name], _mean([run.metrics[name] for run in runs])) for name in QUALITY]


def _mean(values: Sequence[float | None]) -> float | None:
    from statistics import fmean

    known = [value for value in values if value is not None]
    return fmean(known) if len(known) == len(values) else None


def _plain(contestants: Sequence[Contestant], overrides: Sequence[str], runs: Sequence[Measured]) -> dict[str, Any]:
    rules = [
        {"rule": one.text, "decides": one.decides, "distribution": one.distribution, "version": one.version}
        for one in contestants
    ]
    return {"format": JSON_FORMAT, "version": JSON_VERSION, "rules": rules, "set": list(overrides), "runs": runs}
