"""Options that several commands have in common."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

import click

from rmfs_commands.cli import completion
from rmfs_commands.cli.streams import keep_output, no_input
from rmfs_core.roles import Role

F = TypeVar("F", bound=Callable[..., Any])

DECIDING = tuple(role for role in Role if role not in (Role.PP, Role.FILTER, Role.OBSERVER))
"""The decisions that can be asked of a state."""

scenario_argument = click.argument("scenario", metavar="SCENARIO", shell_complete=completion.scenarios)
"""A file, or the name of a shipped scenario."""


def scenario_name(scenario: str) -> str:
    """Return what a run of a scenario is called: the name of its file, or of the folder of a ``scenario.toml``."""
    file = Path(scenario)
    return (file.absolute().parent.name if file.name == "scenario.toml" else "") or file.stem


set_option = click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    shell_complete=completion.overrides,
    help="Replace a value of the scenario, such as `instance.orders=50` or `rules.poa=first-come`. Files "
    "(`instance.orders_file=my.csv`, `rules.pps=./my.py:MyRule`, those of parameters) are looked up in the current "
    "folder. `rules.poa_pps` replaces `rules.poa` and `rules.pps`, and the other way round. Nothing after "
    "the `=`, or None, takes a key out. Repeatable.",
)


class NumberRange(click.FloatRange):
    """Range of numbers; click's takes `nan`, which is neither above nor below any."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number."""
        try:
            found: float = super().convert(value, param, ctx)
        except click.BadParameter:
            found = math.nan
        if math.isnan(found):
            self.fail(_expected("number", self, value), param, ctx)
        return found


class WholeNumberRange(click.IntRange):
    """Range of whole numbers."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the number."""
        try:
            found: int = super().convert(value, param, ctx)
        except click.BadParameter:
            self.fail(_expected("whole number", self, value), param, ctx)
        return found


def _expected(what: str, range_: click.IntRange | click.FloatRange, value: object) -> str:
    """Say which numbers are right, and what was found."""
    least, most = range_.min, range_.max
    if least is not None and most is not None and not (range_.min_open or range_.max_open):
        limits = [f"from {least:,} to {most:,}"]
    else:
        limits = [] if least is None else [f"{'>' if range_.min_open else '>='} {least:,}"]
        limits += [] if most is None else [f"{'<' if range_.max_open else '<='} {most:,}"]
    return f"expected a {what} {' and '.join(limits)}".rstrip() + f", found {value}"


class OutPath(click.Path):
    """A file or folder to write to; click takes no name at all for the current folder."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path."""
        if value == "":
            self.fail("expected a name, found nothing.", param, ctx)
        return super().convert(value, param, ctx)


def decides_option(roles: Iterable[Role], **attributes: Any) -> Callable[[F], F]:
    """Return the option ``--decides``, which names a role as people do; the command is handed the role, or None."""

    def role_of(_ctx: click.Context, _param: click.Parameter, label: str | None) -> Role | None:
        return None if label is None else Role.labelled(label)

    return click.option("--decides", type=click.Choice([role.label for role in roles]), callback=role_of, **attributes)


def _keep_output(_ctx: click.Context, _param: click.Parameter, wanted: bool) -> bool:
    if wanted:
        keep_output()
    return wanted


def _guard_rules(ctx: click.Context, _param: click.Parameter, refused: bool) -> bool:
    """Say whether rules from files are refused; whatever rules there are, they have no standard input to read."""
    ctx.with_resource(no_input())
    return refused or bool(os.environ.get("RMFS_NO_INLINE_RULES"))


json_option = click.option(
    "--json",
    "as_json",
    is_flag=True,
    is_eager=True,
    callback=_keep_output,
    help="Print JSON for machines, and nothing else.",
)

no_inline_option = click.option(
    "--no-inline-rules",
    is_flag=True,
    callback=_guard_rules,
    help="Refuse rules from files, as RMFS_NO_INLINE_RULES=1 in the environment does.",
)

seed_option = click.option("--seed", type=WholeNumberRange(min=0), metavar="N", help="Replace the scenario's seed.")

jobs_option = click.option(
    "--jobs",
    "-j",
    type=WholeNumberRange(min=1),
    metavar="N",
    help="Runs at a time. [default: one for each core; with --dask two for each thread of the cluster]",
)

dask_option = click.option("--dask", metavar="ADDRESS", help="Run on the workers of a Dask scheduler: tcp://host:8786.")

quiet_option = click.option("--quiet", "-q", is_flag=True, help="Print nothing but errors.")


def runs_out_option(what: str, default: str) -> Callable[[F], F]:
    """Return ``--out`` of commands that keep finished runs: what else goes there, and where that is by default."""
    said = f"Folder for finished runs and the {what}. [default: {default}]"
    return click.option("--out", type=OutPath(), metavar="DIR", help=said)


def runs_options(what: str, default: str) -> Callable[[F], F]:
    """Return all options of commands that keep finished runs, ``--jobs`` to ``--quiet``; as `runs_out_option`."""
    return _all(jobs_option, dask_option, runs_out_option(what, default), no_inline_option, json_option, quiet_option)


def search_options(command: str) -> Callable[[F], F]:
    """Return these, ``--set`` and ``--seed``, for a command that answers by runs of one scenario."""
    return _all(set_option, seed_option, runs_options("answer", f"rmfs-runs/{command}-<name of the scenario>"))


def _all(*options: Callable[[F], F]) -> Callable[[F], F]:
    def added(command: F) -> F:
        for option in reversed(options):
            command = option(command)
        return command

    return added
