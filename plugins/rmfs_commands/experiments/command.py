"""``rmfs compare``: run an experiment and compare its rule sets."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from rmfs_commands.cli.completion import experiments
from rmfs_commands.cli.notes import notes_console
from rmfs_commands.cli.options import runs_options
from rmfs_commands.cli.screen import output_console, print_json, say
from rmfs_commands.cli.shipped import print_shipped

if TYPE_CHECKING:
    from rich.console import Console

RUNS_FOLDER = "runs"


@click.command(short_help="Run an experiment and compare its rule sets.")
@click.argument("what", metavar="[EXPERIMENT | RUN RUN]", nargs=-1, shell_complete=experiments)
@click.option(
    "--bounds", is_flag=True, help="Show how far each rule set is from what no rules can beat (`rmfs bound`)."
)
@click.option(
    "--quick", is_flag=True, help="Run two seeds of the first value of each axis: a look before hours of runs."
)
@click.option("--baseline", metavar="NAME", help="Rule set to compare with, instead of the experiment's.")
@click.option(
    "--width",
    "width_cm",
    type=click.FloatRange(4, 60),
    default=7.7,
    show_default=True,
    metavar="CM",
    help="Width of the plots, with letters of 8 pt; the default is one column of a two-column page.",
)
@click.option("--list", "list_them", is_flag=True, help="List the experiments that come with the package.")
@runs_options("report", "rmfs-runs/<name of the experiment>")
def compare(
    what: tuple[str, ...],
    jobs: int | None,
    dask: str | None,
    out: Path | None,
    bounds: bool,
    quick: bool,
    baseline: str | None,
    width_cm: float,
    list_them: bool,
    no_inline_rules: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Run EXPERIMENT, a file or the name of a shipped one (small-rules), and compare its rule sets.

    Every finished run is kept in DIR/runs, so that an interrupted experiment goes on where it stopped; a run whose
    scenario, files or code changed is computed anew. The comparison is printed and written to DIR: report.html,
    summary.csv, runs.parquet, plots, tables, and what repeats it (experiment.json). Exit code 1 when a run failed; the
    others are finished and compared.

    Of two folders with runs, RUN RUN, it prints the metrics next to each other, and in what the runs differ.
    """
    import attrs

    from rmfs_commands.cli.compiling import compile_searches
    from rmfs_commands.experiments import load_experiment, run_experiment, shipped_experiments
    from rmfs_commands.experiments.compare import BOUND
    from rmfs_commands.experiments.progress import experiment_display
    from rmfs_commands.experiments.report import REPORT_FILE, print_comparison, write_report
    from rmfs_core.errors import RunError
    from rmfs_core.scenario import load_scenario

    if list_them:
        print_shipped(shipped_experiments(), as_json)
        return
    if len(what) == 2:
        _compare_two(what, as_json=as_json, quiet=quiet)
        return
    whole = load_experiment(_one_of(what))
    whole = whole if baseline is None else attrs.evolve(whole, baseline=baseline)
    loaded = whole.quick() if quick else whole
    folder = out or Path("rmfs-runs") / loaded.name
    notes = notes_console(quiet=quiet)
    for file in () if no_inline_rules else loaded.rule_files():
        say(notes, f"Loading code from {file}.")
    compile_searches(notes, load_scenario("examples/small"))
    try:
        result = run_experiment(
            loaded,
            store=folder / RUNS_FOLDER,
            jobs=jobs,
            dask=dask,
            watcher=experiment_display(notes, loaded.name),
            allow_inline_rules=not no_inline_rules,
            bounds=bounds,
        )
    except KeyboardInterrupt:
        say(notes, f"Finished runs are kept in {folder / RUNS_FOLDER}; the same command goes on from there.")
        raise
    if not result.computed:
        say(notes, f"{loaded.name}: all {len(result.rows):,} runs are stored already")
    if bounds and not any(name.startswith(BOUND) and row[name] is not None for row in result.rows for name in row):
        why = "runs that end at run.until_s, fail or begin in a state have none, nor have orders that may be cancelled"
        say(notes, f"No bounds: {why}.")
    comparison = result.comparison()
    write_report(result, comparison, folder, width_cm)
    if as_json:
        about = {
            "experiment": loaded.name,
            "folder": str(folder),
            "runs": len(result.rows),
            "failed": len(result.failed),
        }
        print_json({**about, **attrs.asdict(comparison)})
    else:
        console = output_console(quiet=quiet)
        print_comparison(console, result, comparison)
        _conclude(console, folder)
    if result.failed:
        raise RunError(
            f"{len(result.failed)} of {len(result.rows)} runs failed; {folder / REPORT_FILE} has their errors."
        )


def _one_of(what: tuple[str, ...]) -> str:
    if len(what) != 1:
        raise click.UsageError("expected an experiment, a file or one of `rmfs compare --list`; or two folders of runs")
    return what[0]


def _compare_two(runs: tuple[str, ...], *, as_json: bool, quiet: bool) -> None:
    """Print two finished runs next to each other."""
    from rmfs_commands.experiments.report.two_runs import compare_runs

    context = click.get_current_context()
    given = {name for name in context.params if context.get_parameter_source(name) is ParameterSource.COMMANDLINE}
    if given - {"what", "as_json", "quiet"}:
        raise click.UsageError("expected no options but --json and --quiet with two runs")
    first, second = runs
    found = compare_runs(first, second)
    if as_json:
        print_json(found.to_dict())
    else:
        found.show(output_console(quiet=quiet))


def _conclude(console: Console, folder: Path) -> None:
    """Say where the files are."""
    from rmfs_commands.experiments import report

    files = (report.REPORT_FILE, report.SUMMARY_FILE, report.PARQUET_FILE, report.REPEATING_FILE)
    console.print()
    say(console, f"Report in {folder}:")
    say(console, f"  {', '.join(files)}, {report.PLOTS_FOLDER}/, {report.TABLES_FOLDER}/, {RUNS_FOLDER}/")
