"""``rmfs advise``: which of the usual rule sets serves a scenario best."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rmfs_commands.cli.completion import SetCommand
from rmfs_commands.cli.notes import notes_console
from rmfs_commands.cli.options import NumberRange, WholeNumberRange, scenario_argument, scenario_name, search_options
from rmfs_commands.cli.screen import output_console, print_json, print_named, say

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

RUNS_FOLDER, ADVICE_FILE = "runs", "advice.json"
MOST_SEEDS = 1_000


@click.command(cls=SetCommand, short_help="Say which rule set serves a scenario best.")
@scenario_argument
@click.option(
    "--hours",
    type=NumberRange(min=0, min_open=True),
    metavar="H",
    help="Hours to simulate, from the first order that counts. [default: enough for 300 orders; where trucks leave, "
    "until the last one of that day]",
)
@click.option(
    "--seeds",
    type=WholeNumberRange(1, MOST_SEEDS),
    default=5,
    show_default=True,
    metavar="N",
    help="Runs of each rule set, each with a seed of its own.",
)
@click.option(
    "--most",
    metavar="METRIC=X",
    help="Name the cheapest of the rule sets whose mean is at most that, such as `missed_percent=2`; with costs.",
)
@search_options("advise")
def advise(
    scenario: str,
    hours: float | None,
    seeds: int,
    most: str | None,
    overrides: tuple[str, ...],
    seed: int | None,
    jobs: int | None,
    dask: str | None,
    out: Path | None,
    no_inline_rules: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Run SCENARIO with its own rules and with a handful of others, and say which to take.

    All rule sets see the same orders, pods and robots on each seed. Rule sets that split orders are tried where the
    scenario has packing stations, or its own rules split orders. Every finished run is kept in DIR/runs, so that an
    interrupted command goes on where it stopped. The answer is printed and written to DIR/advice.json. Exit code 1 when
    a run failed.
    """
    from rmfs_commands.advice.answer import (
        against_whole,
        best_of_each,
        caption,
        cheapest,
        content_of,
        sentences_of,
        table_of,
        with_open_orders,
    )
    from rmfs_commands.advice.candidates import advice_experiment, lets_split
    from rmfs_commands.advice.cutting import cut
    from rmfs_commands.cli.checking import load_checked
    from rmfs_commands.cli.compiling import compile_searches
    from rmfs_commands.experiments import run_experiment
    from rmfs_commands.experiments.progress import experiment_display
    from rmfs_commands.experiments.report.numbers import fixed
    from rmfs_commands.results.files import json_ready, output_folder, to_json, write_text
    from rmfs_core.errors import RunError
    from rmfs_core.rules import RuleSet
    from rmfs_core.scenario import located

    limit = None if most is None else _limit(most)
    loaded = load_checked(scenario, overrides, seed)
    if limit is not None and loaded.costs is None:
        raise click.UsageError("expected a scenario with a section `costs` with --most")
    with located(loaded):
        rules = RuleSet.load(loaded.rules, loaded.folder, allow_inline=not no_inline_rules)
        part = cut(loaded, hours)
    notes = notes_console(quiet=quiet)
    for file in rules.inline_files:
        say(notes, f"Loading code from {file}.")
    split = lets_split(loaded, rules)
    name = scenario_name(scenario)
    more, every = (() if limit is None else limit[:1]), tuple(range(loaded.seed, loaded.seed + seeds))
    experiment = advice_experiment(part.scenario, name, every, split=split, more=more, more_place=f"--most {most}")
    folder = out or Path("rmfs-runs") / experiment.name
    compile_searches(notes, loaded)
    try:
        result = run_experiment(
            experiment,
            store=folder / RUNS_FOLDER,
            jobs=jobs,
            dask=dask,
            watcher=experiment_display(notes, experiment.name),
            allow_inline_rules=not no_inline_rules,
        )
    except KeyboardInterrupt:
        say(notes, f"Finished runs are kept in {folder / RUNS_FOLDER}; the same command goes on from there.")
        raise
    if not result.computed:
        say(notes, f"{experiment.name}: all {len(result.rows):,} runs are stored already")
    result = against_whole(with_open_orders(result))
    found = best_of_each(result)
    told = [*sentences_of(found, seeds, repeats=result.repeats), *cheapest(result, limit), *part.told]
    if not split:
        told.append("Left out: rule sets that split orders. They need packing stations (a section [packing]).")
    told += filter(None, [fixed(result.comparison())])
    content = {"scenario": name, **content_of(result, found, told)}
    write_text(output_folder(folder) / ADVICE_FILE, to_json(json_ready(content), indent=2) + "\n")
    if as_json:
        print_json(content)
    else:
        _show(output_console(quiet=quiet), table_of(result, found), caption(result), told)
        say(output_console(quiet=quiet), f"\nIn {folder}: {ADVICE_FILE}, {RUNS_FOLDER}/")
    if result.failed:
        raise RunError(
            f"{len(result.failed)} of {len(result.rows)} runs failed; {folder / ADVICE_FILE} has their errors."
        )


def _limit(text: str) -> tuple[str, float]:
    """Return the metric and the limit of ``--most``."""
    from rmfs_commands.details.catalogue import better

    metric, _, number = text.partition("=")
    if better(metric.strip()) == "more":
        raise click.UsageError(f"more of `{metric.strip()}` is better; expected one of which less is, in --most {text}")
    with suppress(ValueError):
        if metric.strip() and math.isfinite(limit := float(number)):
            return metric.strip(), limit
    raise click.UsageError(f"expected a metric and a number, as in --most missed_percent=2, found {text}")


def _show(console: Console, table: Table, about: str, sentences: Sequence[str]) -> None:
    console.print()
    print_named(console, table)
    console.print(about, style="dim", markup=False)
    console.print()
    for number, sentence in enumerate(sentences):
        console.print(sentence, style="" if number else "bold", markup=False)
