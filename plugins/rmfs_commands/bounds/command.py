"""`rmfs bound`: what no run of a scenario can beat."""

from __future__ import annotations

import click

from rmfs_commands.cli.completion import SetCommand
from rmfs_commands.cli.options import json_option, scenario_argument, seed_option, set_option
from rmfs_commands.cli.screen import new_table, output_console, print_json


@click.command(cls=SetCommand, short_help="Say what no rules can beat.")
@scenario_argument
@set_option
@seed_option
@json_option
def bound(scenario: str, overrides: tuple[str, ...], seed: int | None, as_json: bool) -> None:
    """Print bounds that no run of SCENARIO can beat, whatever its rules: visits, distance, turn-over, makespan.

    The bounds hold for runs that complete all orders. Nothing is simulated; what decides in SCENARIO does not count,
    except for rules.move.
    """
    import attrs

    from rmfs_commands.bounds import bounds_of
    from rmfs_commands.cli.checking import load_checked
    from rmfs_commands.cli.compiling import compiling_announced
    from rmfs_commands.cli.notes import notes_console
    from rmfs_commands.details.catalogue import DETAILS, METRICS, PACKING
    from rmfs_commands.results.figures import show

    loaded = load_checked(scenario, overrides, seed)
    notes = notes_console()
    if notes.is_terminal:
        notes.print("Proving bounds ...")
    with compiling_announced(notes):
        bounds = bounds_of(loaded)
    if not bounds:
        cancelled = "an order may be cancelled (`cancelled_s`), and no rules need to serve it"
        begun = "the run begins in a state (`instance.state_file`), and they are of time 0"
        notes.print(f"No bounds: {cancelled if loaded.instance.state_file is None else begun}.")
    if as_json:
        print_json({"scenario": scenario, "seed": loaded.seed, "bounds": [attrs.asdict(one) for one in bounds]})
        return
    described = {metric.name: metric for group in (*METRICS.values(), DETAILS, PACKING) for metric in group}
    table = new_table()
    table.add_column("Metric", no_wrap=True)
    table.add_column("At least", justify="right", no_wrap=True)
    table.add_column("Proof")
    for one in bounds:
        metric = described[one.metric]
        finer = attrs.evolve(metric, digits=metric.digits + 1)
        unit = f" {metric.unit}" if metric.unit and one.value is not None else ""
        label = "Distance with a pod" if metric.label.startswith(" ") else metric.label
        table.add_row(label, f"{show(finer, one.value)}{unit}", one.proof)
    if bounds:
        output_console().print(table)
