"""``rmfs serve``: decisions for other programs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from rmfs_commands.cli import completion
from rmfs_commands.cli.options import DECIDING, NumberRange, WholeNumberRange, decides_option, no_inline_option
from rmfs_commands.cli.screen import tell
from rmfs_commands.cli.streams import keep_output, own_input
from rmfs_core.roles import Role

if TYPE_CHECKING:
    import socket


def _check_lines(*options: str) -> None:
    """Refuse options of the service over HTTP, which would be ignored in silence."""
    ctx = click.get_current_context()
    for name in options:
        if ctx.get_parameter_source(name) is not ParameterSource.DEFAULT:
            raise click.UsageError(f"--{name.replace('_', '-')} is for HTTP; expected it without --stdio.", ctx)


def _check_kind(stdio: bool) -> None:
    """Refuse options that do not go together: those of rules and of halls."""
    ctx = click.get_current_context()
    given = {name for name in ctx.params if ctx.get_parameter_source(name) is not ParameterSource.DEFAULT}
    if not given & {"rules", "halls"}:
        raise click.UsageError("Missing option '--rule' or '--hall'.", ctx)
    kind, others = (
        ("--hall", ("rules", "settings", "decides")) if "halls" in given else ("--rule", ("journal", "dead_s"))
    )
    for name in others:
        if name in given:
            option = {"rules": "rule", "settings": "set", "dead_s": "dead-s"}.get(name, name)
            raise click.UsageError(f"found --{option} with {kind}; expected one without the other.", ctx)
    if "halls" in given and not stdio and "journal" not in given:
        raise click.UsageError("--hall over HTTP needs --journal: a folder from which halls start again.", ctx)


@click.command(short_help="Answer states with decisions, over HTTP.")
@click.option(
    "--rule",
    "rules",
    multiple=True,
    metavar="RULE",
    shell_complete=completion.rules,
    help="Rule to ask: a name, ./file.py:Class, or a table such as '{ rule = \"random\", ... }'. Repeatable: then "
    "requests say which one they ask.",
)
@click.option(
    "--hall",
    "halls",
    multiple=True,
    metavar="NAME=SCENARIO",
    help="Hall to run in a session, in place of rules: facts come in, commands go out. Repeatable.",
)
@click.option(
    "--journal",
    metavar="FOLDER",
    help="Folder with a journal of each hall, from which it starts again where it was. [default: in memory only]",
)
@click.option(
    "--dead-s",
    type=NumberRange(0.001, 1e9),
    metavar="SECONDS",
    help="Time without a fact after which a robot or picker of a hall is reported as overdue. [default: never]",
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="PARAMETER=VALUE",
    help="Set a parameter of the rule; a file that it names is looked up in the current folder. Repeatable.",
)
@decides_option(DECIDING, help="Decision to ask of a rule that decides several things. [default: what the state says]")
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen at.")
@click.option(
    "--port",
    type=WholeNumberRange(0, 65535),
    default=8750,
    show_default=True,
    help="Port to listen at; 0 is any free one.",
)
@click.option(
    "--stdio",
    is_flag=True,
    help="Read one request per line from standard input, and write one answer per line to standard output.",
)
@click.option(
    "--limit-s",
    type=NumberRange(0.1, 86_400),
    default=30.0,
    show_default=True,
    metavar="SECONDS",
    help="Time for a decision, and to wait for its turn. Not with --stdio.",
)
@click.option(
    "--max-mb",
    type=NumberRange(0.001, 190),
    default=16.0,
    show_default=True,
    metavar="MB",
    help="Largest request.",
)
@no_inline_option
def serve(
    rules: tuple[str, ...],
    halls: tuple[str, ...],
    journal: str | None,
    dead_s: float | None,
    settings: tuple[str, ...],
    decides: Role | None,
    host: str,
    port: int,
    stdio: bool,
    limit_s: float,
    max_mb: float,
    no_inline_rules: bool,
) -> None:
    """Answer decision states, as `rmfs decide` does, with rules that stay loaded; or run halls in sessions.

    POST a state to /decide; /docs shows the rest. The service is for programs on this machine unless --host says
    otherwise. Ctrl-C or SIGTERM ends it.
    """
    import sys

    most_bytes = int(max_mb * 1e6)
    _check_kind(stdio)
    if stdio:
        _check_lines("host", "port", "limit_s")
        from rmfs_commands.serve.halls import Halls
        from rmfs_commands.serve.lines import serve_lines
        from rmfs_commands.serve.service import Service

        answers = keep_output()
        service: Service | Halls
        if halls:
            service = Halls.of(halls, journal, dead_s, not no_inline_rules)
        else:
            service = Service.of(rules, settings, decides, not no_inline_rules)
        serve_lines(service, own_input(), answers, most_bytes)
        return

    from functools import partial

    from rmfs_commands.serve.hall_processes import HallProcesses
    from rmfs_commands.serve.process import RuleProcess
    from rmfs_core.errors import InputError

    try:
        from rmfs_commands.serve import app, hall_app, server
    except ModuleNotFoundError as error:
        raise InputError("serve", f"needs further packages; expected `pip install 'rmfs[serve]'` ({error})") from error

    def ready(listening: socket.socket) -> None:
        tell(f"Serving {', '.join(process.names)} at {server.url_of(listening)}; Ctrl-C ends it.")
        if not server.is_loopback(listening):
            note = "Note: other machines reach this address; there is neither a password nor encryption."
            tell(note, err=True)
        sys.stdout.flush()

    process: RuleProcess | HallProcesses
    if halls:
        assert journal is not None
        process = HallProcesses(halls, journal, dead_s, not no_inline_rules, limit_s)
        server.serve(process, hall_app.HallApp(process, most_bytes).within, host, port, ready)
    else:
        process = RuleProcess(rules, settings, decides and decides.label, not no_inline_rules, limit_s)
        server.serve(process, partial(app.app_of, process, most_bytes), host, port, ready)
