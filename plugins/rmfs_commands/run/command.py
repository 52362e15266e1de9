"""``rmfs run``: simulate a scenario, watch it, keep what it measured."""

from __future__ import annotations

import re
import traceback
from collections.abc import Callable, Sequence
from contextlib import closing, nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from rmfs_commands.cli.completion import SetCommand, recorders
from rmfs_commands.cli.notes import notes_console
from rmfs_commands.cli.options import (
    OutPath,
    json_option,
    no_inline_option,
    quiet_option,
    scenario_argument,
    scenario_name,
    seed_option,
    set_option,
)
from rmfs_commands.cli.screen import failure, output_console, print_json, say

if TYPE_CHECKING:
    from rich.console import Console

    from rmfs_commands.cli.progress import RunDisplay
    from rmfs_commands.replay.live import Watch
    from rmfs_core.errors import InputError, RunError
    from rmfs_core.results import Result
    from rmfs_core.scenario import Scenario

RUNS_FOLDER = "rmfs-runs"
LONGEST_SUFFIX = 60


@click.command(cls=SetCommand, short_help="Simulate a scenario.")
@scenario_argument
@seed_option
@set_option
@click.option(
    "--out",
    type=OutPath(),
    metavar="DIR",
    help=f"Folder for the result's files; files of an earlier run in it are replaced. "
    f"[default: {RUNS_FOLDER}/<scenario>-seed<seed>, with what --set changed]",
)
@click.option("--from", "begin", type=click.Path(), metavar="STATE", help="Begin in a state, a JSON file.")
@click.option("--save-state", type=click.Path(), metavar="FILE", help="Write the state at run.until_s to a file.")
@click.option(
    "--journal",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Replay the journal of a hall (`rmfs serve --hall`) as a run. SCENARIO is the hall's file, or NAME.hall.json.",
)
@click.option("--trace", is_flag=True, help="Record every event in DIR/trace.jsonl.gz too.")
@click.option("--record-decisions", is_flag=True, help="Record what each rule saw and decided, for `rmfs explain`.")
@click.option(
    "--record",
    metavar="RECORDER",
    multiple=True,
    shell_complete=recorders,
    help="Switch on a recorder: trace, decisions ...",
)
@click.option("--watch", is_flag=True, help="Show the run in a browser while it goes on, and until Ctrl-C.")
@click.option("--profile", is_flag=True, help="Print where the wall-clock time went.")
@no_inline_option
@json_option
@quiet_option
@click.option("--traceback", "show_traceback", is_flag=True, help="When a rule fails, print where in its code.")
def run(
    scenario: str,
    seed: int | None,
    overrides: tuple[str, ...],
    out: Path | None,
    begin: str | None,
    save_state: str | None,
    journal: Path | None,
    trace: bool,
    record_decisions: bool,
    record: tuple[str, ...],
    watch: bool,
    profile: bool,
    no_inline_rules: bool,
    as_json: bool,
    quiet: bool,
    show_traceback: bool,
) -> None:
    """Simulate SCENARIO: a scenario file, or the name of a shipped one (paper-250).

    Shows the run while it goes on, then its metrics, and writes result.json and tables: orders.csv, visits.csv,
    periods.csv, hours.csv, stations.csv, robots.csv and delays.csv. Ctrl-C ends a run early and keeps what was measured
    until then.
    """

    from rmfs_commands.cli.checking import idle_notes, load_checked
    from rmfs_commands.cli.compiling import compiling_for
    from rmfs_commands.cli.loads import ToldLoads
    from rmfs_commands.cli.progress import run_display
    from rmfs_commands.cli.summary import print_bottleneck, print_profile, print_summary
    from rmfs_commands.cli.waiting import StockWaits
    from rmfs_core import run as run_scenario
    from rmfs_core.errors import RunError
    from rmfs_core.scenario import located
    from rmfs_core.world import make_layout

    _check_recorders(record)
    overrides = overrides if begin is None else (*overrides, f"instance.state_file={begin}")
    recorded = (*record, *(("trace",) if trace else ()), *(("decisions",) if record_decisions else ()))
    simulate: Callable[..., Result] = partial(run_scenario, save_state=save_state)
    if journal is None:
        resolved = load_checked(scenario, overrides, seed)
    else:
        resolved, simulate = _of_journal(journal, scenario, overrides)
    name = scenario_name(scenario)
    folder = default_folder(name, resolved.seed, overrides) if out is None else out
    notes = notes_console(quiet=quiet)
    if resolved.robots.available is not None:
        with located(resolved):
            for note in idle_notes(resolved, make_layout(resolved)):
                say(notes, note)
    if not no_inline_rules:
        _announce_inline_rules(notes, resolved)
    progress: RunDisplay | None = None if quiet or journal is not None else run_display(notes, name)
    viewer = _viewer(name) if watch else None
    waits, told = StockWaits(), ToldLoads(notes)
    try:
        with (
            nullcontext() if progress is None else closing(progress),
            compiling_for(notes, resolved, own=journal is None),
        ):
            result = simulate(
                resolved,
                out=folder,
                record=recorded,
                observers=[one for one in (waits, progress, viewer, told) if one is not None],
                allow_inline_rules=not no_inline_rules,
            )
    except RunError as error:
        _failed(notes, error, folder, show_traceback=show_traceback)
        if as_json and error.result is not None:
            print_json({**error.result.to_dict(), "folder": str(folder), **failure(error, error.exit_code)})
        raise
    if as_json:
        print_json({**result.to_dict(), "folder": str(folder)})
    else:
        console = output_console(quiet=quiet)
        print_summary(console, name, result)
        print_bottleneck(console, result)
        if profile:
            print_profile(console, result)
        _report(console, result, waits.sentence, folder, recorded)
    _finish(notes, save_state, result, viewer)


def _of_journal(journal: Path, scenario: str, overrides: Sequence[str]) -> tuple[Scenario, Callable[..., Result]]:
    """Return the scenario of a hall, and what replays its journal.

    Options that have no meaning for a real day are refused; a hall that was made over HTTP is as it was posted.
    """
    from rmfs_commands.cli.checking import load_checked
    from rmfs_commands.serve.halls import POSTED, posted
    from rmfs_commands.session.day import run_day

    made_over_http = scenario.endswith(POSTED)
    ctx, options = click.get_current_context(), {"seed": "seed", "begin": "from", "save_state": "save-state"}
    options |= {"watch": "watch", **({"overrides": "set"} if made_over_http else {})}
    for name, option in options.items():
        if ctx.get_parameter_source(name) is not ParameterSource.DEFAULT:
            raise click.UsageError(f"found --{option} with --journal; expected one without the other.", ctx)
    resolved = posted(scenario) if made_over_http else load_checked(scenario, overrides, None)
    return resolved, partial(run_day, journal=journal)


def _finish(notes: Console, save_state: str | None, result: Result, viewer: Watch | None) -> None:
    """Say where the state is in which a run ended, serve who watches it, and raise where there is none."""
    if save_state is not None and result.status == "horizon":
        say(notes, f"The state at the end is in {save_state}.")
    if result.interrupted:
        raise click.Abort
    if viewer is not None:
        viewer.wait()
    if save_state is not None and result.status != "horizon":
        raise _not_saved(save_state, result)


def _not_saved(save_state: str, result: Result) -> InputError:
    """Return the error that a run was over before its state could be saved."""
    from rmfs_core.errors import InputError

    until_s, over_s = result.scenario.run.until_s or 0.0, result.metrics["simulated_s"]
    earlier = "; the file there is an earlier one" if Path(save_state).exists() else ""
    problem = f"found {until_s:g}, but the run was over at {over_s:g} s, so {save_state} was not written{earlier}"
    return InputError("run.until_s", f"{problem}; expected an earlier time")


def _failed(notes: Console, error: RunError, folder: Path, *, show_traceback: bool) -> None:
    """Print where an error came from, or how to see that, and where what was measured before it is."""
    if show_traceback:
        click.echo("".join(traceback.format_exception(error.__cause__ or error)), err=True, nl=False)
    elif error.__cause__ is not None:
        say(notes, "With --traceback the same command prints the calls that led to the error.")
    if error.result is not None:
        say(notes, f"What was measured until the error is in {folder}.")


def _viewer(name: str) -> Watch:
    """Return what shows a run in a browser; it stops when the command does."""
    from rmfs_commands.replay.live import Watch

    viewer = Watch(name)
    click.get_current_context().call_on_close(viewer.close)
    return viewer


def default_folder(name: str, seed: int, overrides: tuple[str, ...] = ()) -> Path:
    """Return the folder for a run's files: runs that differ in what was set do not replace each other."""
    suffix = "".join(f"-{re.sub(r'[^A-Za-z0-9_.=-]+', '_', override)}" for override in overrides)
    if len(suffix) > LONGEST_SUFFIX:
        import hashlib

        digest = hashlib.sha256("\n".join(overrides).encode()).hexdigest()[:8]
        suffix = f"{suffix[: LONGEST_SUFFIX - 9]}-{digest}"
    return Path(RUNS_FOLDER) / f"{name}-seed{seed}{suffix}"


def _check_recorders(names: Sequence[str]) -> None:
    """Name the option that names a recorder which cannot be had."""
    from rmfs_commands.results.recorders import load_recorder
    from rmfs_core.errors import InputError

    for name in names:
        try:
            load_recorder(name)
        except InputError as error:
            raise InputError(f"--record {name}", error.problem) from error


def _announce_inline_rules(notes: Console, scenario: Scenario) -> None:
    from rmfs_core.scenario.rulenames import is_inline, rule_choices

    names = (choice.rule for _, choice in rule_choices(scenario.rules) if is_inline(choice.rule))
    for file in dict.fromkeys(name.rpartition(":")[0] for name in names):
        say(notes, f"Loading code from {Path(scenario.folder) / file}.")


def _at_the_horizon(result: Result) -> str:
    """Say what a run that has reached its horizon leaves."""
    from rmfs_commands.cli.display import duration
    from rmfs_core.wording import counted

    names = ("open_orders_end", "backlog_end", "open_age_s", "open_age_max_s", "unpacked_end")
    open_, backlog, mean, oldest, unpacked = map(result.metrics.get, names)
    done = sum(row["completed_s"] is not None for row in result.orders)
    text = f"The run reached its horizon, {duration(result.scenario.run.until_s or 0)} (run.until_s): "
    text += f"{done:,} of {counted(len(result.orders), 'order')} complete"
    coming = len(result.orders) - done - (open_ or 0)
    text += f"{f', {coming:,} not arrived' if coming else ''}, {open_:,} open"
    text += f", {backlog:,} of them in the backlog" if open_ else ""
    text += f"; {counted(unpacked, 'arrived order')} not packed" if unpacked is not None else ""
    if open_:
        text += f"; age of the open orders: mean {duration(mean or 0)}, oldest {duration(oldest or 0)}"
    return f"{text}."


def _report(console: Console, result: Result, waited: str, folder: Path, record: Sequence[str]) -> None:
    """Say what is not complete, what ``waited`` for stock, and where the files are."""
    from rich.padding import Padding
    from rich.text import Text

    from rmfs_commands.cli.display import duration
    from rmfs_commands.results.recorders import files_of, files_of_results, load_recorder, make_observers

    console.print()
    if not result.orders:
        say(console, "There were no orders, so there is nothing to measure.")
    if result.status == "horizon":
        say(console, _at_the_horizon(result))
    elif result.status == "partial":
        total, left = len(result.orders), sum(row["completed_s"] is None for row in result.orders)
        say(console, f"The run ended with {left:,} of {total:,} orders left; metrics are of what was done.")
    for note in result.notes:
        say(console, note)
    if waited:
        say(console, waited)
    if (warmup := result.scenario.run.warmup_s) is not None:
        simulated = result.metrics["simulated_s"]
        since = "run.warmup_s" if result.scenario.instance.state_file is None else "run.warmup_s, or the state's time"
        say(console, f"Metrics count what happens from {duration(warmup)} on ({since}).")
        if simulated <= warmup:
            say(console, f"The run was over at {duration(simulated)}, before that: they count nothing.")
    observers = [observer for observer, _ in make_observers(quiet=True)]
    written = files_of([*observers, *map(load_recorder, record)])
    files = [*files_of_results(), *written]
    say(console, f"Results in {folder}:")
    console.print(Padding(Text(", ".join(file for file in files if (folder / file).exists())), (0, 0, 0, 2)))
