"""The command line: a group whose commands are the entry points of ``rmfs.commands``."""

from __future__ import annotations

import atexit
import gc
import json
import os
import re
import sys
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EBADF, EIO, ENOSPC, EPIPE
from importlib.metadata import EntryPoint
from io import TextIOWrapper
from typing import Any, NamedTuple

import click

from rmfs_commands.cli import streams
from rmfs_commands.cli.interrupts import ignore_interrupts
from rmfs_commands.cli.screen import failure, visible_json
from rmfs_core import entrypoints
from rmfs_core.errors import InputError, RmfsError, is_interrupt
from rmfs_core.wording import nearest, one_line, sentence

CLOSED_PIPE = 141
"""Exit code where the reader of the output has closed it (`rmfs run ... | head`): a shell's for SIGPIPE."""
EXIT_CODES = (0, 1, 2, 130, CLOSED_PIPE)


class Commands(click.Group):
    """A group that imports a command when it is looked up; one that cannot be imported costs the others nothing."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands; nothing is imported."""
        return list(self._offers(ctx))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return a command; instead of one that cannot be had, one that says why when it is called."""
        if cmd_name not in (known := self._offers(ctx)):
            return None
        try:
            return _load(known[cmd_name])
        except InputError as error:
            return _unusable(cmd_name, error)

    def _offers(self, ctx: click.Context) -> dict[str, tuple[EntryPoint, ...]]:
        """Return the entry points; what is installed is looked through once a call, for it takes its time."""
        found: dict[str, tuple[EntryPoint, ...]] | None = ctx.meta.get(__name__)
        if found is None:
            found = ctx.meta[__name__] = entrypoints.offers(entrypoints.COMMANDS)
        return found

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that the first word names; one sentence, without usage, where there is none."""
        names = self.list_commands(ctx)
        if args and not args[0].startswith("-") and args[0] not in names:
            raise click.UsageError(f'there is no command "{args[0]}"{nearest(args[0], names)}')
        return super().resolve_command(ctx, args)

    def make_context(self, *arguments: Any, **options: Any) -> click.Context:
        """Read what was called; `--help` writes already."""
        with _writing():
            return super().make_context(*arguments, **options)

    def invoke(self, ctx: click.Context) -> None:
        """Call the command; what it raises that is not meant for the caller names it and its distribution."""
        try:
            with _writing():
                super().invoke(ctx)  # what it returns is no exit code
        except (click.ClickException, click.Abort, click.exceptions.Exit, RmfsError, SystemExit, KeyboardInterrupt):
            raise
        except BaseException as error:
            if is_interrupt(error):
                raise KeyboardInterrupt from error
            described, name = "rmfs", ctx.invoked_subcommand
            if name is not None:  # else it came before there was a command
                described = entrypoints.describe("command", name, *entrypoints.origin(self._offers(ctx)[name][0]))
            shown = "RMFS_TRACEBACK=1 in the environment shows where"
            raise RmfsError(f"{described} raised {one_line(error)}; {shown}") from error


@contextmanager
def _writing() -> Iterator[None]:
    """Raise `InputError` where the output cannot be written, because its reader is gone or a disk is full."""
    try:
        yield
    except (OSError, SystemExit) as end:  # rich makes the one of the other
        lost = end if isinstance(end, OSError) else end.__context__
        if not isinstance(lost, OSError) or lost.filename or lost.errno not in (EPIPE, ENOSPC, EBADF, EIO):
            raise
        with suppress(OSError):  # what is left in the buffer would be written at the end
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise InputError("output", f"cannot be written: {lost.strerror or lost}") from lost


def _unusable(name: str, error: InputError) -> click.Command:
    """Return what stands for a command that cannot be had: it takes any arguments, and says why."""

    def say_why() -> None:
        raise error

    settings = {"ignore_unknown_options": True, "allow_extra_args": True}
    short_help = f"(not usable: {error.problem})"
    return click.Command(name, settings, say_why, short_help=short_help, add_help_option=False)


def _load(entries: tuple[EntryPoint, ...]) -> click.Command:
    place = f"rmfs {entries[0].name}"
    with streams.kept_output():  # what a module prints as it is imported is no output of the command
        command = entrypoints.load(entries, place, "command")
    try:
        if isinstance(command, click.Command):
            command.get_short_help_str()  # for the list of all commands
            return command
        problem = f"is {type(command).__name__}; expected a click.Command"
    except Exception as error:
        problem = f"cannot say what it does: {one_line(error)}"
    described = entrypoints.describe("command", entries[0].name, *entrypoints.origin(entries[0]))
    raise InputError(place, f"{described} {problem}")


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="rmfs")
def rmfs() -> None:
    """Simulate robotic mobile fulfillment systems with interchangeable decision rules."""


class _Ending(NamedTuple):
    """How a call ended: its exit code, the sentence printed, and the error."""

    code: object = 0
    text: str | None = None
    error: RmfsError | None = None


def main(arguments: list[str] | None = None) -> None:
    """Entry point of ``rmfs``.

    Exit codes: 0 done, 1 a run failed, 2 the input is wrong, 130 interrupted, 141 the reader of the output went away;
    any other that a command ends with is 1.
    """
    gc.set_threshold(200_000, 20, 50)  # imports leave much that lives on: to look through it takes time,
    atexit.register(gc.freeze)  # also at the end
    streams.open_all()
    streams.begin()
    if isinstance(sys.stdout, TextIOWrapper):  # names of files need not be UTF-8
        sys.stdout.reconfigure(errors="backslashreplace")
    alone = arguments is None  # else Python goes on after the call
    if alone:
        warnings.showwarning = _show_warning
    try:
        ending = _called(arguments)
        if alone:
            ignore_interrupts()
    except KeyboardInterrupt:  # pressed again, or when all was done
        ending = INTERRUPTED
        if alone:
            ignore_interrupts()
    with suppress(OSError):  # who has closed the streams as well learns it by the exit code
        if ending.text:
            click.echo(ending.text, err=True)
    code = ending.code if ending.code in EXIT_CODES else 1
    with suppress(OSError):
        if ending.code not in (0, CLOSED_PIPE) and "--json" in _words(arguments) and not streams.answered():
            error = ending.error or RmfsError(ending.text or f"Ended with exit code {code}.")
            # Not by `print_json`: an interrupt may have come in the middle of what that imports.
            click.echo(visible_json(json.dumps(failure(error, code), indent=2, ensure_ascii=False)))
    if alone and streams.kept():
        streams.leave_output()
    if ending.code:
        sys.exit(code)


def _wrong_call(error: click.ClickException) -> _Ending:
    """Say how a command is called."""
    if isinstance(error, click.exceptions.NoArgsIsHelpError):
        with suppress(OSError):
            click.echo(error.format_message(), err=True)
        return _Ending(2, None, InputError("rmfs", "expected a command"))
    shown = click.UsageError(sentence(error.format_message()), getattr(error, "ctx", None))
    with suppress(OSError):
        shown.show()
    place = "rmfs" if shown.ctx is None else shown.ctx.command_path
    return _Ending(2, None, InputError(place, shown.message))


def _show_warning(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
    """Show what users have to know of as a note, without a line of code."""
    if issubclass(category, FutureWarning):
        with suppress(OSError):
            click.echo(sentence(f"Note: {message}"), err=True)
    else:
        _shown_by_python(message, category, *where, **more)


_shown_by_python = warnings.showwarning


def _called(arguments: list[str] | None) -> _Ending:
    """Call a command and return how it ended."""
    try:
        with _writing():
            # Outside its standalone mode click returns the code of `ctx.exit`.
            code: object = rmfs.main(arguments, standalone_mode=False) or 0
            sys.stdout.flush()  # what is left would be written when nobody can catch an error any more
            return _Ending(code)
    except SystemExit as end:
        return _Ending(1, end.code) if isinstance(end.code, str) else _Ending(end.code or 0)
    except click.ClickException as error:
        return _wrong_call(error)
    except RmfsError as error:
        if isinstance(error.__cause__, BrokenPipeError):
            return _Ending(CLOSED_PIPE)
        if clock := _CLOCK_FOR_NUMBER.search(error.problem):
            error.problem += f", which is {int(clock[1]) * 3600 + int(clock[2]) * 60} s after midnight"
        told = sentence(f"Error: {error}")
        if os.environ.get("RMFS_TRACEBACK"):
            told = "".join(traceback.format_exception(error))
        return _Ending(error.exit_code, told, error)
    except (KeyboardInterrupt, click.Abort):
        return INTERRUPTED


INTERRUPTED = _Ending(130, "Interrupted.")
_CLOCK_FOR_NUMBER = re.compile(r'expected a number, found "(\d\d?):(\d\d)"$', re.ASCII)


def _words(arguments: list[str] | None) -> list[str]:
    words = sys.argv[1:] if arguments is None else arguments
    return words[: words.index("--")] if "--" in words else words
