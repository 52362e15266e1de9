"""A rule that is asked outside a run: found by its name, in the role that it shall play."""

from __future__ import annotations

from pathlib import Path

import pytest

from rmfs_commands.cli.single_rule import load_rule
from rmfs_core.errors import InputError
from rmfs_core.roles import Role
from rmfs_core.rules.sources import RuleSources
from rmfs_core.scenario import RuleChoice

RANDOM = RuleChoice("random")
RULE = """
import attrs
from rmfs_core import hookimpl

@attrs.define
class Mine:
    @hookimpl
    def filter_backlog(self, orders):
        return orders
"""


def test_the_role_that_may_be_played_is_the_rules() -> None:
    """Of those that a rule can play, the one that is asked for; parameters are the choice's."""
    rule = load_rule(RuleChoice("pod-index", {"near": 0.5}), (Role.POA_PPS, Role.POA, Role.PP))
    assert (rule.role, rule.name, rule.instance.near) == (Role.POA_PPS, "pod-index", 0.5)


def test_a_rule_that_can_play_several_wants_a_preference() -> None:
    """One sentence without it."""
    assert load_rule(RANDOM, tuple(Role), preferred=Role.PPS).role is Role.PPS
    with pytest.raises(InputError, match=r"^here: rule \"random\" .* say which of them is asked \(`decides`\)$"):
        load_rule(RANDOM, tuple(Role), place="here")


def test_a_rule_for_something_else_is_refused() -> None:
    """With what it decides, and what was wanted."""
    with pytest.raises(InputError, match=r"decides PP; expected a rule for POA or PPS$"):
        load_rule(RuleChoice("sipp"), (Role.POA, Role.PPS))


def test_a_file_is_loaded_once_for_several_calls(tmp_path: Path) -> None:
    """Where the calls share the sources; else each time anew."""
    (tmp_path / "mine.py").write_text(RULE, encoding="utf-8")
    choice, sources = RuleChoice("./mine.py:Mine"), RuleSources(str(tmp_path))
    first, second = (load_rule(choice, (Role.FILTER,), sources=sources) for _ in range(2))
    alone = load_rule(choice, (Role.FILTER,), folder=str(tmp_path))
    assert type(first.instance) is type(second.instance) is not type(alone.instance)
