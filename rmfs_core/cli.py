"""The command line: a group whose commands are the entry points of ``rmfs.commands``."""

from __future__ import annotations

import os
import sys
from importlib.metadata import EntryPoint

import click

from rmfs_core import entrypoints
from rmfs_core.errors import InputError, RmfsError
from rmfs_core.wording import nearest

CLOSED_PIPE = 141
"""Exit code where the reader of the output has closed it (`rmfs run ... | head`): a shell's for SIGPIPE."""


class Commands(click.Group):
    """A group that imports a command when it is looked up; one that cannot be imported costs the others nothing."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands; nothing is imported."""
        return list(self._offers(ctx))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return a command; in place of one that cannot be had, one that says why when it is called."""
        if cmd_name not in (known := self._offers(ctx)):
            return None
        try:
            return _load(known[cmd_name])
        except InputError as error:
            return _Unusable(cmd_name, error)

    def _offers(self, ctx: click.Context) -> dict[str, tuple[EntryPoint, ...]]:
        """Return the entry points; what is installed is looked through once a call, for it takes its time."""
        found: dict[str, tuple[EntryPoint, ...]] | None = ctx.meta.get(__name__)
        if found is None:
            found = ctx.meta[__name__] = entrypoints.offers(entrypoints.COMMANDS)
        return found

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that the first word names."""
        names = self.list_commands(ctx)
        if args and not args[0].startswith("-") and args[0] not in names:
            raise click.UsageError(f'there is no command "{args[0]}"{nearest(args[0], names)}', ctx)
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> object:
        """Call the command; end quietly when whoever reads its output goes away."""
        try:
            result: object = super().invoke(ctx)
            sys.stdout.flush()  # what is left would be written when nobody can catch an error any more
        except (BrokenPipeError, SystemExit) as end:  # rich makes the one of the other
            if not isinstance(end, BrokenPipeError) and not isinstance(end.__context__, BrokenPipeError):
                raise
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise click.exceptions.Exit(CLOSED_PIPE) from None
        return result


class _Unusable(click.Command):
    """Stands for a command that cannot be had; takes any arguments."""

    def __init__(self, name: str, error: InputError) -> None:
        super().__init__(
            name,
            short_help=f"(not usable: {error.problem})",
            add_help_option=False,
            context_settings={"ignore_unknown_options": True, "allow_extra_args": True},
        )
        self._error = error

    def invoke(self, ctx: click.Context) -> None:  # noqa: ARG002
        """Say why."""
        raise self._error


def _load(entries: tuple[EntryPoint, ...]) -> click.Command:
    place = f"rmfs {entries[0].name}"
    command = entrypoints.load(entries, place, "command")
    if not isinstance(command, click.Command):
        described = entrypoints.describe("command", entries[0].name, *entrypoints.origin(entries[0]))
        raise InputError(place, f"{described} is {type(command).__name__}; expected a click.Command")
    return command


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="rmfs")
def rmfs() -> None:
    """Simulate robotic mobile fulfillment systems with interchangeable decision rules."""


def main(arguments: list[str] | None = None) -> None:
    """Entry point of ``rmfs``.

    Exit codes: 0 done, 1 a run failed, 2 the input is wrong, 130 interrupted, 141 whoever read the output went away.
    """
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
