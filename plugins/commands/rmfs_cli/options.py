"""Options that several commands have in common."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

import click

from rmfs_cli import completion
from rmfs_core.roles import Role

F = TypeVar("F", bound=Callable[..., Any])

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
    "(`instance.orders_file=my.csv`, `rules.pps=./my.py:MyRule`, those of rules' parameters) are looked up in the "
    "current folder. `rules.poa_pps` takes the place of `rules.poa` and `rules.pps`, and the other way round. Nothing "
    "after the `=`, or None, takes a key out. Repeatable.",
)


class NumberRange(click.FloatRange):
    """Range of numbers; click's takes `nan`, which is neither above nor below any."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number."""
        found: float = super().convert(value, param, ctx)
        if math.isnan(found):
            self.fail(f"{value!r} is not a number.", param, ctx)
        return found


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


json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON for machines, and nothing else.")

no_inline_option = click.option(
    "--no-inline-rules",
    is_flag=True,
    callback=lambda _ctx, _param, value: value or bool(os.environ.get("RMFS_NO_INLINE_RULES")),
    help="Refuse rules from files, as RMFS_NO_INLINE_RULES=1 in the environment does.",
)

seed_option = click.option("--seed", type=click.IntRange(min=0), metavar="N", help="Replace the scenario's seed.")

jobs_option = click.option(
    "--jobs",
    "-j",
    type=click.IntRange(min=1),
    metavar="N",
    help="Runs at a time. [default: one for each core; with --dask two for each thread of the cluster]",
)

dask_option = click.option("--dask", metavar="ADDRESS", help="Run on the workers of a Dask scheduler: tcp://host:8786.")

quiet_option = click.option("--quiet", "-q", is_flag=True, help="Print nothing but errors.")


def runs_out_option(what: str, default: str) -> Callable[[F], F]:
    """Return ``--out`` of commands that keep finished runs: what else goes there, and where that is by default."""
    said = f"Folder for finished runs and the {what}. [default: {default}]"
    return click.option("--out", type=OutPath(), metavar="DIR", help=said)
