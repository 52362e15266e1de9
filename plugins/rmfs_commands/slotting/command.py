"""``rmfs slot``: which SKUs stand on which pods, and where the pods stand, by a history of orders."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import click

from rmfs_commands.cli.completion import SetCommand
from rmfs_commands.cli.notes import notes_console
from rmfs_commands.cli.options import (
    WholeNumberRange,
    dask_option,
    jobs_option,
    json_option,
    no_inline_option,
    quiet_option,
    runs_out_option,
    scenario_argument,
    scenario_name,
    seed_option,
    set_option,
)
from rmfs_commands.cli.screen import output_console, print_json, say

PLACEMENTS = ("random", "popularity", "co-purchase", "clusters")


@click.command(cls=SetCommand, short_help="Place SKUs on pods by a history of orders, judged on later days.")
@scenario_argument
@click.option(
    "--history",
    metavar="ORDERS",
    type=click.Path(path_type=Path),
    help="File of earlier orders, with the columns of the scenario's `instance.orders_file`.",
)
@click.option(
    "--history-until",
    metavar="TIME",
    help="Learn from the scenario's orders that arrive earlier, and judge on those that arrive later: a time in ISO "
    "8601, or seconds from time 0.",
)
@click.option(
    "--placement",
    "placements",
    multiple=True,
    type=click.Choice(PLACEMENTS),
    help="Placement to make; may be repeated. The best in the history is improved by local search. [default: all]",
)
@click.option(
    "--steps",
    type=WholeNumberRange(0, 10_000_000),
    default=100_000,
    show_default=True,
    metavar="N",
    help="Exchanges that the local search tries.",
)
@click.option(
    "--moves",
    type=WholeNumberRange(0, 1_000),
    default=0,
    show_default=True,
    metavar="N",
    help="Find the N changes of the pods as they are that pay soonest for their driving and handling.",
)
@click.option(
    "--rules",
    "rules",
    multiple=True,
    metavar="RULE",
    help="Rules to judge with: `own`, those of the scenario, or a rule for both POA and PPS; may be repeated. "
    "[default: own, and pod-index]",
)
@click.option(
    "--days",
    type=WholeNumberRange(1, 1_000),
    default=10,
    show_default=True,
    metavar="N",
    help="Later days to judge on, the first ones.",
)
@click.option(
    "--seeds",
    type=WholeNumberRange(1, 1_000),
    default=1,
    show_default=True,
    metavar="N",
    help="Runs of each day, from the scenario's seed on. With fewer than three days, intervals are over seeds.",
)
@set_option
@seed_option
@jobs_option
@dask_option
@runs_out_option("answer", "rmfs-runs/slot-<name of the scenario>")
@no_inline_option
@json_option
@quiet_option
def slot(
    scenario: str,
    history: Path | None,
    history_until: str | None,
    placements: tuple[str, ...],
    steps: int,
    moves: int,
    rules: tuple[str, ...],
    days: int,
    seeds: int,
    overrides: tuple[str, ...],
    seed: int | None,
    jobs: int | None,
    dask: str | None,
    out: Path | None,
    no_inline_rules: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Place the SKUs of SCENARIO on its pods by a history of orders: `--history-until 2024-03-20`.

    Pods, the number of SKUs on each, its space, and the items of each SKU stay as they are. Placements are made and
    chosen by the history alone; then each later day is run with each of them, and compared with the pods as they are.
    The answer is printed and written to DIR: pods.csv with the chosen placement, a section for the scenario
    (slotted.toml), report.html and answer.json. Finished runs are kept in DIR/runs.
    """
    from rmfs_commands.cli.checking import load_checked
    from rmfs_commands.cli.compiling import compile_searches
    from rmfs_commands.experiments.running import open_workers
    from rmfs_commands.sizing.notices import Notices
    from rmfs_commands.slotting import answer
    from rmfs_commands.slotting.judging import OWN, VISITS, judge
    from rmfs_commands.slotting.making import make_placements
    from rmfs_commands.slotting.past import read_past
    from rmfs_core.errors import InputError
    from rmfs_core.scenario import located

    if (history is None) == (history_until is None):
        raise click.UsageError("expected --history ORDERS or --history-until TIME, one of them")
    loaded = load_checked(scenario, overrides, seed)
    notes, name = notes_console(quiet=quiet), scenario_name(scenario)
    with located(loaded):
        past = read_past(loaded, history, history_until, days)
    made = make_placements(
        loaded, past, tuple(dict.fromkeys(placements)) or PLACEMENTS, steps, moves, lambda told: say(notes, told)
    )
    judged_with = tuple(dict.fromkeys(rules)) or ((OWN,) if loaded.rules.poa_pps is not None else (OWN, "pod-index"))
    folder = out or Path("rmfs-runs") / f"slot-{name}"
    compile_searches(notes, loaded)
    try:
        with closing(open_workers(jobs, dask)) as workers:
            judged = judge(
                loaded,
                name,
                past,
                made.pods,
                judged_with,
                seeds,
                folder,
                workers=workers,
                watcher=Notices(notes),
                metrics=(VISITS, "turnover_s" if loaded.packing is None else "packed_s"),
                allow_inline_rules=not no_inline_rules,
            )
    except KeyboardInterrupt:
        say(notes, f"Finished runs are kept in {folder / 'runs'}; the same command goes on from there.")
        raise
    if len(judged.result.failed) == len(judged.result.rows):
        raise InputError(name, f"every run failed, the first with: {judged.result.failed[0]['error']}")
    found = answer.Answer(name, past, made, judged)
    files = answer.write(found, folder)
    if as_json:
        print_json(answer.content_of(found))
        return
    console = output_console(quiet=quiet)
    answer.show(console, found)
    say(console, f"\nIn {folder}: {', '.join(files)}, runs/")
    say(console, f"Run all days with them: rmfs run {scenario} --set instance.pods_file={folder / answer.PODS_FILE}")
