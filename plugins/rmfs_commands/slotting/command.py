"""``rmfs slot``: which SKUs stand on which pods, and where the pods stand, by a history of orders."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

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

if TYPE_CHECKING:
    from rmfs_commands.slotting.past import Past
    from rmfs_core.scenario import Scenario

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
    from rmfs_commands.slotting.changes import Floor, best_changes
    from rmfs_commands.slotting.judging import OWN, VISITS, judge, pods_csv
    from rmfs_commands.slotting.past import read_past
    from rmfs_commands.slotting.placing import NOW, Placer, Stock, cells_of, driving_s, located
    from rmfs_core.errors import InputError
    from rmfs_core.scenario import located as located_in
    from rmfs_core.world import make_layout

    if (history is None) == (history_until is None):
        raise click.UsageError("expected --history ORDERS or --history-until TIME, one of them")
    loaded = load_checked(scenario, overrides, seed)
    notes, name = notes_console(quiet=quiet), scenario_name(scenario)
    with located_in(loaded):
        past = read_past(loaded, history, history_until, days)
        layout = make_layout(loaded)
    judged_with = rules or ((OWN,) if loaded.rules.poa_pps is not None else (OWN, "pod-index"))
    seconds = driving_s(loaded, layout)
    visit_s = 2 * float(seconds.mean() + float(loaded.robots.lift_s))
    batch = _batch(loaded, past, visit_s, len(layout.stations) - layout.replenishing)
    stock = Stock.of(past, loaded)
    placer = Placer(past, stock, batch, loaded.seed)
    made, left = [placer.now()], []
    for one in placements or PLACEMENTS:
        say(notes, f"Placing: {one}.")
        found = placer.made(one)
        if found is None:
            left.append(f"Placement {one} is left out: it does not fit into `instance.pod_capacity`.")
        else:
            made.append(found)
    say(notes, f"Improving the best by local search: {steps:,} exchanges.")
    made.append(placer.improved(min(made, key=lambda one: one.held_back), steps))
    chosen = min(made, key=lambda one: one.held_back)
    if past.strange:
        left.append(f"SKUs of the history that stand on no pod: {past.strange:,}, left out.")
    if unknown := sum(sku.lines == 0 for sku in past.skus()):
        left.append(f"SKUs on pods without history: {unknown:,} of {len(past.skus()):,}, placed anywhere.")
    places = {one.name: located(past.instance.pods, placer.visits(one), layout, seconds) for one in made[1:]}
    places[NOW] = cells_of(past.instance.pods, layout)
    changes = []
    if moves:
        say(notes, f"Looking for {moves} changes.")
        stays = loaded.rules.pr is not None and loaded.rules.pr.rule == "fixed"
        floor = Floor(layout, seconds, visit_s, float(loaded.stations.handle_s), stays)
        moved, changes, cells = best_changes(placer, floor, moves, loaded.seed)
        made.append(moved)
        places[moved.name] = cells
        if len(changes) < moves:
            left.append(f"Only {len(changes)} changes save visits in the history.")
    texts = {one.name: pods_csv(past, one.contents, places[one.name], layout) for one in made}
    folder = out or Path("rmfs-runs") / f"slot-{name}"
    compile_searches(notes, loaded)
    try:
        with closing(open_workers(jobs, dask)) as workers:
            judged = judge(
                loaded,
                name,
                past,
                texts,
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
    found_all = answer.Answer(name, past, batch, made, chosen, changes, judged, left)
    files = answer.write(found_all, texts[chosen.name], folder)
    if as_json:
        print_json(answer.content_of(found_all))
        return
    console = output_console(quiet=quiet)
    answer.show(console, found_all)
    say(console, f"\nIn {folder}: {', '.join(files)}, runs/")
    say(console, f"Run a day with them: rmfs run {scenario} --set instance.pods_file={folder / answer.PODS_FILE}")


def _batch(scenario: Scenario, past: Past, visit_s: float, stations: int) -> int:
    """Return how many orders of the history a picking station has at a time, in the hours in which most arrive.

    By Little's law: arrivals times the time of an order, a visit and its items, longer by the load of the picker; at
    most the station's capacity.
    """
    given = scenario.stations.order_capacity
    most = _mean(scenario.stations.item_capacity) / past.quantities if given is None else _mean(given)
    rate = past.orders_per_hour / 3600 / stations
    work_s = past.quantities * float(scenario.stations.handle_s)
    return max(1, round(min(most, rate * (visit_s + work_s) / max(1 - rate * work_s, 0.01))))


def _mean(given: int | tuple[int, ...]) -> float:
    numbers = given if isinstance(given, tuple) else (given,)
    return sum(numbers) / len(numbers)
