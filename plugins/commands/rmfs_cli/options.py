"""Options that several commands have in common."""

from __future__ import annotations

import click

scenario_argument = click.argument("scenario", metavar="SCENARIO")
"""A file, or the name of a shipped scenario."""

set_option = click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Replace a value of the scenario, such as `instance.orders=50` or `rules.poa=first-come`. "
    "Nothing after the `=` takes a key out: `--set rules.poa= --set rules.pps= --set rules.poa_pps=...`. Repeatable.",
)

seed_option = click.option("--seed", type=click.IntRange(min=0), metavar="N", help="Replace the scenario's seed.")

jobs_option = click.option(
    "--jobs",
    "-j",
    type=click.IntRange(min=1),
    metavar="N",
    help="Runs at a time. [default: one for each core; with --dask two for each thread of the cluster]",
)

dask_option = click.option("--dask", metavar="ADDRESS", help="Run on the workers of a Dask scheduler: tcp://host:8786.")
