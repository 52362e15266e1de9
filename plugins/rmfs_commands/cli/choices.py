"""Rules as they are named on a command line: a name, or a table of name and parameters as in a scenario file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from attrs import evolve

from rmfs_commands.instances.overrides import parse_override, rule_name_from
from rmfs_commands.instances.toml_lines import read_toml
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import RuleChoice
from rmfs_core.scenario.source import Source
from rmfs_core.scenario.structuring import KeyProblem, structure_as


@contextmanager
def option_named(place: str, option: str, settings: Sequence[str] = ()) -> Iterator[None]:
    """Name what was typed in every InputError raised within at a rule's place.

    Parameters
    ----------
    place
        The rule's place; its parameters' are below it.
    option
        The option as typed: ``--rule demand``.
    settings
        Values typed for its parameters, after ``--set``.
    """
    try:
        yield
    except InputError as error:
        rule, _, parameter = error.place.removeprefix(place).partition(".")
        if rule or not error.place.startswith(place):
            raise
        typed = [text for text in settings if text.partition("=")[0].strip() == parameter]
        named = f"--set {typed[-1]}" if typed else ", ".join(filter(None, (option, parameter)))
        raise InputError(named, error.problem) from error


def parse_choice(text: str, place: str) -> RuleChoice:
    """Return the rule that ``demand`` or ``{ rule = "demand", parameter = 1 }`` names, seen from the current folder."""
    value: Any = text
    if text.lstrip().startswith("{"):
        try:
            value = read_toml(f"rule = {text}")["rule"]
        except ValueError as error:
            raise InputError(place, f"this is no valid TOML table: {error}") from None
    try:
        choice = structure_as(RuleChoice, value)
    except KeyProblem as problem:
        raise InputError(Source(place).place_of(problem.path), problem.problem) from None
    return evolve(choice, rule=rule_name_from(choice.rule, ".", "."))


def with_parameters(choice: RuleChoice, settings: Sequence[str]) -> RuleChoice:
    """Return a choice with parameters set: ``max_seconds=5`` each; nothing after the ``=``, or None, takes one out."""
    parameters = dict(choice.parameters)
    for text in settings:
        if "=" not in text:
            raise InputError(f"--set {text}", "expected parameter=value, such as max_seconds=5")
        override = parse_override(text)
        if len(override.path) != 1:
            raise InputError(override.place, "expected a parameter of the rule, such as max_seconds=5")
        parameters[override.path[0]] = override.value
    return evolve(choice, parameters={name: value for name, value in parameters.items() if value is not None})
