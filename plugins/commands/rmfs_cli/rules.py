"""`rmfs rules`: what is installed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rmfs_cli import completion
from rmfs_cli.options import json_option
from rmfs_cli.screen import print_json, table_console

if TYPE_CHECKING:
    from rich.console import Console

    from rmfs_cli.description import RuleDescription

WIDE = 120
"""From this many columns on there is room for a table."""

PIPE_WIDTH = 200
"""Columns of the table where the output is no terminal."""


@click.command()
@click.argument("name", required=False, shell_complete=completion.rules)
@json_option
def rules(name: str | None, as_json: bool) -> None:
    """List the installed rules, or show everything about the rule NAME.

    Scenario files select rules by these names: what they decide, their parameters with defaults and units, and the
    reference.
    """
    from rmfs_cli.description import installed_rules

    found = installed_rules()
    if name is not None:
        found = _only(name, found)
    if as_json:
        print_json(found)
    elif name is not None:
        for rule in found:
            _print_details(rule)
    else:
        console = table_console(PIPE_WIDTH)
        (_print_table if console.width >= WIDE else _print_list)(console, found)
    for rule in found:
        if rule.error is not None:
            click.echo(f"Rule {rule.name} ({rule.distribution} {rule.version}) cannot be used: {rule.error}", err=True)


def _only(name: str, found: list[RuleDescription]) -> list[RuleDescription]:
    from rmfs_core.errors import InputError
    from rmfs_core.wording import did_you_mean

    chosen = [rule for rule in found if rule.name == name]
    if not chosen:
        names = {rule.name for rule in found}
        raise InputError("rmfs rules", f'unknown rule "{name}"{did_you_mean(name, names)}; `rmfs rules` lists all')
    return chosen


def _print_table(console: Console, found: list[RuleDescription]) -> None:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, header_style="bold cyan", pad_edge=False)
    table.add_column("Rule", no_wrap=True, style="bold")
    table.add_column("Decides", no_wrap=True)
    table.add_column("From", no_wrap=True, style="dim")
    table.add_column("Parameters", overflow="fold", min_width=12)
    table.add_column("What it does", min_width=20)
    table.add_column("Reference", style="dim", no_wrap=True)
    for rule in found:
        what = Text(rule.summary) if rule.error is None else Text(rule.error, style="red")
        table.add_row(
            Text(rule.name),
            Text("\n".join(rule.decides)),
            Text(f"{rule.distribution} {rule.version}"),
            Text("\n".join(parameter.shown() for parameter in rule.parameters)),
            what,
            Text(rule.short_references()),
        )
    console.print(table)


def _print_list(console: Console, found: list[RuleDescription]) -> None:
    """Print what the table has, but the references: each rule's name on a line of its own, the rest below it."""
    from rich.padding import Padding
    from rich.text import Text

    for rule in found:
        head = Text.assemble((rule.name, "bold"), f"  {', '.join(rule.decides)}")
        console.print(head.append(f"  {rule.distribution} {rule.version}", style="dim"))
        what = Text(rule.summary) if rule.error is None else Text(rule.error, style="red")
        for text in (what, *(Text(parameter.shown()) for parameter in rule.parameters)):
            console.print(Padding(text, (0, 0, 0, 4)))
    console.print(Text("`rmfs rules NAME` shows parameters, formula and reference of a rule.", style="dim"))


def _print_details(rule: RuleDescription) -> None:
    from rich.text import Text

    console = table_console(PIPE_WIDTH)
    head = Text.assemble((rule.name, "bold"), f"  decides {', '.join(rule.decides) or '?'}; ")
    console.print(head + Text(f"from {rule.distribution} {rule.version}", style="dim"))
    console.print()
    console.print(Text(rule.doc))
    if rule.parameters:
        console.print()
        console.print(Text("In a scenario", style="bold cyan"))
        for parameter in rule.parameters:
            console.print(Text(f"  {parameter.shown()}  # {parameter.type}. {parameter.doc}".rstrip(" .#")))
