"""What the commands that take a scenario have in common."""

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
