"""``rmfs decide``: what a rule decides in a state of the warehouse."""

from __future__ import annotations

import click

from rmfs_commands.cli import completion
from rmfs_commands.cli.options import DECIDING, WholeNumberRange, decides_option, no_inline_option
from rmfs_commands.cli.screen import print_json
from rmfs_commands.cli.streams import keep_output, own_input
from rmfs_core.roles import Role


def _print_schema(ctx: click.Context, _parameter: click.Parameter, wanted: bool) -> None:
    if not wanted:
        return
    from rmfs_commands.results.files import to_json
    from rmfs_commands.states import state_schema

    click.echo(to_json(state_schema(), indent=2))
    ctx.exit()


@click.command(short_help="Ask a rule what it decides in a state.")
@click.argument("state", metavar="STATE.json", type=click.Path(allow_dash=True))
@click.option(
    "--rule",
    "name",
    required=True,
    metavar="RULE",
    shell_complete=completion.rules,
    help="Rule to ask: a name, or ./file.py:Class.",
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="PARAMETER=VALUE",
    help="Set a parameter of the rule; a file that it names is looked up in the current folder. Repeatable.",
)
@decides_option(DECIDING, help="Decision to ask of a rule that decides several things.")
@click.option("--seed", type=WholeNumberRange(min=0), metavar="N", help="Seed of the rule's random generator.")
@no_inline_option
@click.option(
    "--schema",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_schema,
    help="Print the JSON Schema of states and exit.",
)
def decide(
    state: str, name: str, settings: tuple[str, ...], decides: Role | None, seed: int | None, no_inline_rules: bool
) -> None:
    """Ask a rule what it decides in the state of STATE.json, and print its decision as JSON. Nothing is simulated.
    `-` reads the state from standard input.

    `rmfs explain DIR --period N --state FILE` writes a state of a recorded run; other programs write their own.
    `outcome` is what the decision comes to: orders and items assigned, new pod visits, capacity left unused at the
    stations, and open requests that no pod at the stations or on its way there has an item for. `due` has the orders
    decided on that have a due time: when, their priority, and what is left until then (negative: late).
    """
    import attrs

    from rmfs_commands.cli.choices import option_named, parse_choice, with_parameters
    from rmfs_commands.states import Decider, read_state, state_from_dict
    from rmfs_commands.states.state_json import MOST_BYTES, parse_json

    keep_output()
    from_input = state in ("-", "/dev/stdin")
    source = "standard input" if from_input else state
    if from_input:
        given = state_from_dict(parse_json(own_input().read(MOST_BYTES + 1), source), source)
    else:
        given = read_state(state)
    if seed is not None:
        given = attrs.evolve(given, seed=seed, random=None)
    choice = with_parameters(parse_choice(name, f"--rule {name}"), settings)
    with option_named("rule", f"--rule {name}", settings):
        decider = Decider(choice, decides=decides, allow_inline=not no_inline_rules)
        answer = decider.decide(given, source)
    print_json(answer.to_dict())
