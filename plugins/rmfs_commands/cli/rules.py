"""`rmfs rules`: what is installed."""

from __future__ import annotations

import re
from textwrap import wrap
from typing import TYPE_CHECKING

import click

from rmfs_commands.cli import completion
from rmfs_commands.cli.options import json_option, no_inline_option
from rmfs_commands.cli.screen import new_table, output_console, print_json, tell

if TYPE_CHECKING:
    from rich.console import Console

    from rmfs_commands.cli.description import RuleDescription

WIDE = 120
"""From this many columns on a table fits."""


@click.command(short_help="List the rules, or show everything about one.")
@click.argument("name", required=False, shell_complete=completion.rules)
@no_inline_option
@json_option
def rules(name: str | None, no_inline_rules: bool, as_json: bool) -> None:
    """List the installed rules, or show everything about the rule NAME, or that of a file: ./my_rule.py:MyRule.

    Scenario files select rules by these names: what they decide, their parameters with defaults and units, and the
    reference.
    """
    from rmfs_commands.cli.description import installed_rules, rule_of_file
    from rmfs_core.scenario.rulenames import is_inline

    if name is not None and is_inline(name):
        found = [rule_of_file(name, allow_inline=not no_inline_rules)]
    else:
        found = installed_rules()
        if name is not None:
            found = _only(name, found)
    if as_json:
        print_json(found)
    elif name is not None:
        for rule in found:
            _print_details(rule)
    else:
        console = output_console()
        (_print_table if console.width >= WIDE else _print_list)(console, found)
    for rule in found:
        if rule.error is not None:
            tell(f"Rule {rule.name} ({rule.distribution} {rule.version}) cannot be used: {rule.error}", err=True)


def _only(name: str, found: list[RuleDescription]) -> list[RuleDescription]:
    from rmfs_core.errors import InputError
    from rmfs_core.wording import did_you_mean

    chosen = [rule for rule in found if rule.name == name]
    if not chosen:
        names = {rule.name for rule in found}
        raise InputError("rmfs rules", f'unknown rule "{name}"{did_you_mean(name, names)}; `rmfs rules` lists all')
    return chosen


def _print_table(console: Console, found: list[RuleDescription]) -> None:
    from rich.text import Text

    table = new_table()
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

    console = output_console()
    head = Text.assemble((rule.name, "bold"), f"  decides {', '.join(rule.decides) or '?'}; ")
    console.print(head + Text(f"from {rule.distribution} {rule.version}", style="dim"))
    console.print()
    # What its section "Parameters" says is told below, as a scenario has it.
    doc = re.sub(r"^Parameters\n-+\n(.*\n)*?(?=\S.*\n-+\n|\Z)", "", f"{rule.doc}\n", flags=re.MULTILINE)
    for line in reflowed(doc.rstrip(), console.width):
        console.print(Text(line), soft_wrap=True)
    if rule.parameters:
        console.print()
        console.print(Text("In a scenario", style="bold cyan"))
    for parameter in rule.parameters:
        unit = f", in {parameter.unit}" if parameter.unit and f"({parameter.unit})" not in parameter.doc else ""
        about = f"{parameter.type}{unit}. {parameter.doc}".rstrip(" .").replace("``", "`")
        lines = [f"  {parameter.in_scenario()}  # {about}"]
        if len(lines[0]) > console.width:
            lines = [f"  {parameter.in_scenario()}", *_filled(about, console.width, "    # ")]
        for line in lines:
            console.print(Text(line), soft_wrap=True)


def reflowed(doc: str, width: int) -> list[str]:
    """Return the lines of a docstring for a width: prose that is wider is filled anew, all else stays as it is."""
    lines: list[str] = []
    block: list[str] = []

    def finish() -> None:
        if any(len(line) > width for line in block):
            lines.extend(_filled(" ".join(map(str.strip, block)), width, " " * _indent(block[0])))
        else:
            lines.extend(block)
        block.clear()

    for line in [*doc.replace("``", "`").split("\n"), ""]:
        heading = line.startswith("---")
        if not line.strip() or heading or (block and _indent(line) != _indent(block[0])):
            finish()
        if not line.strip() or heading:
            lines.append(line)
        else:
            block.append(line)
    return lines[:-1]


def _filled(text: str, width: int, before: str) -> list[str]:
    """Return a text in lines that begin in the same way; names, numbers and addresses are not broken."""
    lines = wrap(text, max(width - len(before), 1), break_long_words=False, break_on_hyphens=False)
    return [before + line for line in lines]


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())
