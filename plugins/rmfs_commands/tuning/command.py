"""``rmfs tune``: parameters of rules that serve a scenario best."""

from __future__ import annotations

from contextlib import closing
from math import prod
from pathlib import Path

import click

from rmfs_commands.cli.completion import SetCommand
from rmfs_commands.cli.notes import notes_console
from rmfs_commands.cli.options import WholeNumberRange, scenario_argument, scenario_name, search_options
from rmfs_commands.cli.screen import output_console, print_json, say

RUNS_FOLDER = "runs"
MOST_SEEDS = 1_000


@click.command(cls=SetCommand, short_help="Search for parameters of rules that serve a scenario best.")
@scenario_argument
@click.option(
    "--rules",
    "searched",
    metavar="KEYS",
    help="Rules of which to search all parameters with a known range: pps, or poa,pps. `rmfs rules NAME` lists them.",
)
@click.option(
    "--parameter",
    "given",
    multiple=True,
    metavar="RULE.NAME=RANGE",
    help="Search a parameter in a range or a list: pps.max_wait_s=60..1200, poa.tie_break=random,lowest.",
)
@click.option(
    "--objective",
    "objectives",
    multiple=True,
    metavar="METRIC",
    help="Metric to make as good as can be; twice for what no values beat in both. One of your own is NAME=less or "
    "NAME=more. [default: turnover_s, or packed_s]",
)
@click.option(
    "--axis",
    "varied",
    multiple=True,
    metavar="KEY=[A, B]",
    help="Run each trial in several instances, as an axis of an experiment has them: instance.skus=[20, 100]. An "
    "objective is then the mean over all of them.",
)
@click.option(
    "--runs",
    type=WholeNumberRange(1, 1_000_000),
    default=200,
    show_default=True,
    metavar="N",
    help="Runs of the search.",
)
@click.option(
    "--seeds",
    type=WholeNumberRange(2, MOST_SEEDS),
    default=8,
    show_default=True,
    metavar="N",
    help="Seeds of the search, from the scenario's on.",
)
@click.option(
    "--held-back",
    type=WholeNumberRange(3, MOST_SEEDS),
    default=10,
    show_default=True,
    metavar="N",
    help="Seeds on which the answer is compared with the scenario's own values.",
)
@click.option(
    "--held-back-from",
    "held_back_from",
    type=WholeNumberRange(0),
    metavar="N",
    help="The first of them. [default: the one after those of the search]",
)
@search_options("tune")
def tune(
    scenario: str,
    searched: str | None,
    given: tuple[str, ...],
    objectives: tuple[str, ...],
    varied: tuple[str, ...],
    runs: int,
    seeds: int,
    held_back: int,
    held_back_from: int | None,
    overrides: tuple[str, ...],
    seed: int | None,
    jobs: int | None,
    dask: str | None,
    out: Path | None,
    no_inline_rules: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Search for parameters of SCENARIO's rules: `--rules pps --objective turnover_s`.

    Values are tried on the same seeds as the scenario's own; values that are surely worse after some of the seeds are
    given up. What is found is then compared with the scenario's own values on seeds that the search never saw. Every
    finished run is kept in DIR/runs, so that an interrupted search goes on where it stopped. The answer is printed and
    written to DIR: a section for the scenario (tuned.toml), trials.csv, and the comparison (report.html). Exit code 1
    when the search finds no run that counts.
    """
    from rmfs_commands.cli.checking import load_checked
    from rmfs_commands.cli.compiling import compile_searches
    from rmfs_commands.experiments.running import open_workers
    from rmfs_commands.sizing.notices import Notices
    from rmfs_commands.tuning import answer
    from rmfs_commands.tuning.searching import Search, objectives_of
    from rmfs_commands.tuning.space import axes_of, make_space
    from rmfs_core.errors import InputError
    from rmfs_core.rules import RuleSet
    from rmfs_core.scenario import located

    try:
        import optuna  # noqa: F401
    except ImportError:
        raise InputError(
            "rmfs tune", 'needs Optuna, which is not installed; `pip install "rmfs[tune]"` brings it'
        ) from None
    if searched is None and not given:
        raise click.UsageError("expected --rules or --parameter, as in --parameter pps.max_wait_s=60..1200")
    loaded = load_checked(scenario, overrides, seed)
    with located(loaded):
        rules = RuleSet.load(loaded.rules, loaded.folder, allow_inline=not no_inline_rules)
    keys = [key.strip() for key in searched.split(",") if key.strip()] if searched else []
    axes = axes_of(varied)
    space = make_space(rules, loaded.rules, keys, given)
    wanted = objectives_of(objectives or ["turnover_s" if loaded.packing is None else "packed_s"])
    _check_runs(runs, seeds, prod(len(axis.points) for axis in axes))
    searching, judging = _seeds(loaded.seed, seeds, held_back_from, held_back)
    notes, name = notes_console(quiet=quiet), scenario_name(scenario)
    for file in rules.inline_files:
        say(notes, f"Loading code from {file}.")
    for line in answer.space_lines(space):
        say(notes, line)
    folder = out or Path("rmfs-runs") / f"tune-{name}"
    compile_searches(notes, loaded)
    try:
        with closing(open_workers(jobs, dask)) as workers:
            search = Search(
                loaded,
                name,
                space,
                tuple(wanted),
                tuple(wanted.values()),
                tuple(searching),
                runs,
                folder / RUNS_FOLDER,
                workers,
                Notices(notes),
                lambda trial: say(notes, answer.trial_line(trial, list(wanted))),
                allow_inline_rules=not no_inline_rules,
                axes=axes,
            )
            trials = search.trials()
            found = answer.judge(search, trials, judging)
    except KeyboardInterrupt:
        say(notes, f"Finished runs are kept in {folder / RUNS_FOLDER}; the same command goes on from there.")
        raise
    files = answer.write(found, folder)
    if as_json:
        print_json(answer.content_of(found))
        return
    console = output_console(quiet=quiet)
    answer.show(console, found)
    say(console, f"\nIn {folder}: {', '.join(files)}, {RUNS_FOLDER}/")


def _seeds(first: int, seeds: int, held_back_from: int | None, held_back: int) -> tuple[range, range]:
    """Return the seeds of the search and those held back; raise `InputError` where they overlap."""
    from rmfs_core.errors import InputError

    searching = range(first, first + seeds)
    start = searching.stop if held_back_from is None else held_back_from
    if start < searching.stop and first < start + held_back:
        seen = f"{first} to {searching[-1]}"
        raise InputError("--held-back-from", f"found {start}; expected seeds apart from the search's, {seen}")
    return searching, range(start, start + held_back)


def _check_runs(runs: int, seeds: int, instances: int) -> None:
    """Raise `InputError` where runs are not enough for a batch of trials."""
    from rmfs_commands.tuning.searching import BATCH
    from rmfs_core.errors import InputError

    if runs < (least := (BATCH + 1) * seeds * instances):
        needs = f"the scenario's own values and {BATCH} trials, each on {seeds} seeds"
        needs += f" of {instances} instances" if instances > 1 else ""
        raise InputError("--runs", f"found {runs}; expected at least {least}: {needs}")
