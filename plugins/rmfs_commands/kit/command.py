"""`rmfs new-rule`: a distribution of one's own, to start a rule, an observer or a command from."""

from __future__ import annotations

import shlex

import click

from rmfs_commands.cli.screen import tell
from rmfs_commands.kit.kinds import KINDS
from rmfs_core.roles import Role


@click.command(name="new-rule", short_help="Write a distribution with a rule of your own.")
@click.argument("name", metavar="NAME")
@click.option(
    "--decides",
    required=True,
    type=click.Choice([*(role.label for role in Role), *KINDS]),
    help=f"Kind of decision. {'; '.join(f'{role.label}: {role.what}' for role in Role)}; generator: orders, SKUs and "
    "pods; layout: the grid; command: called as `rmfs NAME`.",
)
@click.option("--into", default=".", metavar="DIR", help="Folder in which the folder NAME is made. [default: this one]")
def new_rule(name: str, decides: str, into: str) -> None:
    """Write a distribution with a rule of your own to the new folder NAME.

    It has a working rule, observer or command of the kind you name, to be changed, with its tests and a README. NAME is
    what scenarios call the rule: small letters, digits and hyphens.
    """
    from rmfs_commands.kit import NewRule, project_files, trying, write_project

    rule = NewRule(name, decides if decides in KINDS else Role.labelled(decides))
    folder = write_project(rule, into)
    tell(f"Wrote {folder}: {', '.join(project_files(rule))}.")
    tell("Next:")
    path = shlex.quote(str(folder if folder.is_absolute() else f"./{folder}"))
    tell(f"  pip install -e {path}")
    tell(f"  {trying(rule)}")
    tell(f"Its README says how to test it: {folder / 'README.md'}")
