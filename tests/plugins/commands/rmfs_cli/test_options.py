"""Options that several commands have in common mean the same in each."""

from __future__ import annotations

import click
import pytest
from click.testing import CliRunner

from rmfs_cli.options import dask_option, jobs_option, json_option, scenario_argument, seed_option, set_option


@click.command()
@scenario_argument
@set_option
@seed_option
@jobs_option
@dask_option
@json_option
def command(**given: object) -> None:
    """Print what was given."""
    for name, value in sorted(given.items()):
        click.echo(f"{name}={value}")


def given(*arguments: str) -> dict[str, str]:
    """Return what the command was given, as texts."""
    done = CliRunner().invoke(command, arguments)
    assert done.exit_code == 0, done.output
    return dict(line.split("=", 1) for line in done.output.splitlines())


def test_what_is_left_out() -> None:
    """Nothing is replaced, and people are written for."""
    assert given("paper-250") == {
        "scenario": "paper-250",
        "overrides": "()",
        "seed": "None",
        "jobs": "None",
        "dask": "None",
        "as_json": "False",
    }


def test_what_is_given() -> None:
    """`--set` may be repeated, and keeps its order."""
    options = ("--set", "a.b=1", "--set", "c=", "--seed", "0", "-j", "2", "--dask", "tcp://host:1", "--json")
    assert given("x.toml", *options) == {
        "scenario": "x.toml",
        "overrides": "('a.b=1', 'c=')",
        "seed": "0",
        "jobs": "2",
        "dask": "tcp://host:1",
        "as_json": "True",
    }


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ((), "Missing argument 'SCENARIO'"),
        (("x", "--seed", "-1"), "-1 is not in the range x>=0"),
        (("x", "--jobs", "0"), "0 is not in the range x>=1"),
        (("x", "--seed", "one"), "'one' is not a valid integer"),
    ],
)
def test_what_is_wrong_is_said(arguments: tuple[str, ...], problem: str) -> None:
    """Exit code 2."""
    done = CliRunner().invoke(command, arguments)
    assert done.exit_code == 2
    assert problem in done.output
