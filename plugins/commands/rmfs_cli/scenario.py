"""`rmfs scenario`: check, show and list scenario files."""

from __future__ import annotations

import click

from rmfs_cli.options import scenario_argument, seed_option, set_option


@click.group()
def scenario() -> None:
    """Check, show and list scenario files."""


@scenario.command()
@scenario_argument
@set_option
@seed_option
@click.option("--no-inline-rules", is_flag=True, help="Refuse rules from files beside the scenario.")
def check(scenario: str, overrides: tuple[str, ...], seed: int | None, no_inline_rules: bool) -> None:
    """Say what is wrong with SCENARIO, without running it.

    Everything a run needs is made: orders and pods, the layout, the rules with their parameters.
    """
    from rmfs_core.rules import RuleSet
    from rmfs_core.scenario import load_scenario, located
    from rmfs_core.simulation.engine import Simulation
    from rmfs_core.world import make_instance, make_layout

    loaded = load_scenario(scenario, overrides, seed)
    with located(loaded):
        rules = RuleSet.load(loaded.rules, loaded.folder, allow_inline=not no_inline_rules)
        for file in rules.inline_files:
            click.echo(f"Loaded code from {file}.", err=True)
        instance = make_instance(loaded)
        layout = make_layout(loaded)
        Simulation(loaded, instance, layout, rules)
    items = sum(order.items for order in instance.orders)
    click.echo(
        f"{scenario} is valid: {len(instance.orders)} orders of {items} items, {len(instance.skus)} SKUs, "
        f"{len(instance.pods)} pods, {len(layout.stations)} stations, {loaded.robots.count} robots."
    )


@scenario.command()
@scenario_argument
@set_option
@seed_option
def show(scenario: str, overrides: tuple[str, ...], seed: int | None) -> None:
    """Print SCENARIO as TOML with every key, defaults included."""
    from rmfs_core.scenario import load_scenario, to_toml

    click.echo(to_toml(load_scenario(scenario, overrides, seed)), nl=False)


@scenario.command()
def schema() -> None:
    """Print the JSON Schema of scenario files, for editors."""
    import json

    from rmfs_core.scenario import scenario_schema

    click.echo(json.dumps(scenario_schema(), indent=2))


@scenario.command(name="list")
def list_() -> None:
    """List the scenarios that come with the package."""
    from rmfs_core.scenario import shipped_scenarios
    from rmfs_core.scenario.reading import summary

    shipped = shipped_scenarios()
    width = max(map(len, shipped), default=0)
    for name, file in shipped.items():
        click.echo(f"{name:{width}}  {summary(file)}".rstrip())
