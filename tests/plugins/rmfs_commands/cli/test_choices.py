"""Rules as they are named on a command line."""

from __future__ import annotations

import pytest

from rmfs_commands.cli.choices import option_named, parse_choice, with_parameters
from rmfs_core import InputError
from rmfs_core.scenario import RuleChoice


def test_choices() -> None:
    """A name, or a TOML table; parameters are set and taken out."""
    assert parse_choice("demand", "x") == RuleChoice("demand")
    table = parse_choice('{ rule = "integrated", gap = 0.1, threads = 2 }', "x")
    assert table == RuleChoice("integrated", {"gap": 0.1, "threads": 2})
    assert with_parameters(table, ["gap=", "threads=1"]) == RuleChoice("integrated", {"threads": 1})
    for wrong, problem in (
        ("{ rule = ", "no valid TOML"),
        ("{ gap = 1 }", "expected a key `rule`"),
        ("", "the name of"),
    ):
        with pytest.raises(InputError, match=problem):
            parse_choice(wrong, "x")
    for wrong, problem in (("a.b=1", "expected a parameter of the rule"), ("gap", "expected parameter=value")):
        with pytest.raises(InputError, match=problem):
            with_parameters(table, [wrong])


@pytest.mark.parametrize(
    ("place", "named"),
    [
        ("rule", "--rule mine"),
        ("rule.x", "--set x = 2"),
        ("rule.y", "--rule mine, y"),
        ("rules", "rules"),
        ("state.json", "state.json"),
    ],
)
def test_an_error_names_what_was_typed(place: str, named: str) -> None:
    """The option of the rule or of its parameter, the last where it was set twice; other places stay as they are."""
    with pytest.raises(InputError) as caught, option_named("rule", "--rule mine", ["x=1", "x = 2"]):
        raise InputError(place, "wrong")
    assert str(caught.value) == f"{named}: wrong"
