"""The name of a new rule or command: how it is spelled, what is called after it, and whether it is free."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rmfs_commands.kit.names import COMMAND, NewRule
from rmfs_core import InputError
from rmfs_core.roles import Role


@pytest.mark.parametrize(
    ("name", "role", "kind", "module", "target"),
    [
        ("fine-rule", Role.POA, "rule", "fine_rule", "FineRule"),
        ("k2-opt", Role.PP, "rule", "k2_opt", "K2Opt"),
        ("x", Role.OBSERVER, "rule", "x", "X"),
        ("fine-tool", COMMAND, "command", "fine_tool", "fine_tool"),
    ],
)
def test_what_is_called_after_it(name: str, role: Role | str, kind: str, module: str, target: str) -> None:
    """Its module, and its class; a command is a function."""
    rule = NewRule(name, role)
    assert (rule.kind, rule.module, rule.target, rule.place) == (kind, module, target, f'{kind} name "{name}"')
    rule.check_free()


def test_a_role_may_be_given_by_its_key() -> None:
    """As the command line has it."""
    assert NewRule("x", "poa_pps").role is Role.POA_PPS
    assert NewRule("x", COMMAND).role == COMMAND


@pytest.mark.parametrize(
    ("name", "such_as"),
    [
        ("My_Rule", "my-rule"),
        ("two words", "two-words"),
        ("2opt", "my-rule"),  # a package cannot begin with a digit
        ("a--b", "a-b"),
        ("-a-", "a"),
        ("-", "my-rule"),
        ("", "my-rule"),
        ("../up", "up"),
        ("größte", "gr-te"),
        ("a\n", "a"),
    ],
)
def test_a_name_is_spelled_as_a_folder_is(name: str, such_as: str) -> None:
    """Small letters, digits and hyphens; the sentence shows what would do."""
    expected = "expected small letters, digits and single hyphens, beginning with a letter, such as"
    with pytest.raises(InputError) as caught:
        NewRule(name, Role.POA)
    assert caught.value.problem == f'{expected} "{such_as}"'


@pytest.mark.parametrize(
    ("name", "role", "problem"),
    [
        ("demand", Role.POA, r"a rule of that name is installed \(rmfs "),
        ("compare", COMMAND, r"a command of that name is installed \(rmfs "),
        ("numpy", Role.POA, r"a distribution of that name is installed \(numpy "),
        ("rmfs", Role.POA, r"a distribution of that name is installed \(rmfs "),
        ("lambda", Role.POA, "`lambda` is a word of the Python language"),
        ("true", Role.POA, "`True` is a word of the Python language"),  # its class would be called so
        ("queue", Role.POA, "there is a module `queue`"),
        ("rmfs-core", Role.POA, "there is a module `rmfs_core`"),
    ],
)
def test_a_name_that_is_taken_is_refused(name: str, role: Role | str, problem: str) -> None:
    """By a rule or command, a distribution, the language, or a module."""
    with pytest.raises(InputError, match=problem):
        NewRule(name, role).check_free()


def test_rules_and_commands_have_names_of_their_own() -> None:
    """A command may have a rule's name, and a rule a command's."""
    NewRule("demand", COMMAND).check_free()
    NewRule("compare", Role.POA).check_free()


def test_a_third_partys_rule_has_its_name_for_itself(install: Callable[..., None]) -> None:
    """Names of rules from other distributions are taken, too."""
    install("acme", {"clever": "acme_rules:Clever"})
    with pytest.raises(InputError, match=r"a rule of that name is installed \(acme 1.0\)"):
        NewRule("clever", "poa").check_free()
