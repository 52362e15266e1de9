"""Command ``rmfs the-rule``."""

from __future__ import annotations

import click


@click.command(name="the-rule")
@click.argument("scenario", metavar="SCENARIO")
@click.option("--seeds", type=click.IntRange(min=1), default=3, show_default=True, metavar="N", help="Seeds 1 to N.")
@click.option("--metric", default="makespan_s", show_default=True, metavar="NAME", help="A metric of result.json.")
def the_rule(scenario: str, seeds: int, metric: str) -> None:
    """Run SCENARIO, a file or the name of a shipped one, with several seeds, and print a metric of each run."""
    import rmfs  # here, because `rmfs --help` imports every command and shall stay fast

    for seed in range(1, seeds + 1):
        result = rmfs.run(scenario, seed=seed)
        if result.interrupted:
            raise click.Abort
        if metric not in result.metrics:
            raise rmfs.InputError("--metric", f"expected one of {', '.join(result.metrics)}; found {metric}")
        click.echo(f"seed {seed}: {metric} {result.metrics[metric]}")
