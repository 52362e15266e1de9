"""The command line. Each command lives in a module of its own and imports what it needs when it runs."""

from __future__ import annotations

import importlib
import sys

import click

from rmfs_core.errors import RmfsError

COMMANDS = {
    "run": "rmfs_core.cli.run:run",
    "compare": "rmfs_core.cli.compare:compare",
    "reproduce": "rmfs_core.cli.reproduce:reproduce",
    "rules": "rmfs_core.cli.rules:rules",
    "new-rule": "rmfs_core.cli.new_rule:new_rule",
    "scenario": "rmfs_core.cli.scenario:scenario",
    "generate": "rmfs_core.cli.generate:generate",
    "plan": "rmfs_core.cli.plan:plan",
    "validate": "rmfs_core.cli.validate:validate",
    "explain": "rmfs_core.cli.explain:explain",
    "decide": "rmfs_core.cli.decide:decide",
    "bench": "rmfs_core.cli.bench:bench",
}


class LazyGroup(click.Group):
    """A group that imports a command's module when the command is looked up."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        """Names of all commands, in the order in which a new user meets them."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        """Import and return a command."""
        if cmd_name not in COMMANDS:
            return None
        module, attribute = COMMANDS[cmd_name].split(":")
        command: click.Command = getattr(importlib.import_module(module), attribute)
        return command


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="rmfs")
def rmfs() -> None:
    """Simulate robotic mobile fulfillment systems with interchangeable decision rules."""


def main(arguments: list[str] | None = None) -> None:
    """Entry point of ``rmfs``. Exit codes: 0 done, 1 a run failed, 2 the input is wrong, 130 interrupted."""
    try:
        # Outside its standalone mode click returns the code of `ctx.exit` (and a command's value otherwise).
        code = rmfs.main(arguments, standalone_mode=False)
        if isinstance(code, int) and code:
            sys.exit(code)
    except click.ClickException as error:
        error.show()
        sys.exit(2)
    except RmfsError as error:
        click.echo(f"Error: {error}", err=True)
        sys.exit(error.exit_code)
    except (KeyboardInterrupt, click.Abort):
        click.echo("Interrupted.", err=True)
        sys.exit(130)
