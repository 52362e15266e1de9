"""The vocabulary of what rules decide."""

from __future__ import annotations

import attrs
import pytest

from rmfs_core.roles import Role
from rmfs_core.rules.hooks import ARGUMENTS
from rmfs_core.scenario.model import RulesSection


def test_every_role_has_its_key_its_hook_and_its_label() -> None:
    """The keys are those of a scenario's section of rules, the hooks exist, and labels lead back to their roles.

    One key of the section names no rule: it says whether orders wait for stock.
    """
    keys = [field.name for field in attrs.fields(RulesSection)]
    keys.remove("wait_for_stock")
    assert [role.key for role in Role] == keys
    assert {role.hook for role in Role} <= ARGUMENTS.keys()
    assert [role.key for role in Role if role.many] == ["filters", "observers"]
    assert [Role.labelled(role.label) for role in Role] == list(Role)
    assert (f"{Role.POA_PPS}", Role.POA_PPS.label, Role("poa_pps")) == ("poa_pps", "POA+PPS", Role.POA_PPS)
    with pytest.raises(ValueError, match="no role is called 'poa'"):
        Role.labelled("poa")


def test_a_joint_rule_excludes_the_two_it_stands_for() -> None:
    """And either of them excludes a joint rule; other roles exclude nothing."""
    excludes = {role: role.excludes for role in Role if role.excludes}
    assert excludes == {
        Role.POA: (Role.POA_PPS,),
        Role.PPS: (Role.POA_PPS,),
        Role.POA_PPS: (Role.POA, Role.PPS),
        Role.ROA: (Role.ROA_RPS,),
        Role.RPS: (Role.ROA_RPS,),
        Role.ROA_RPS: (Role.ROA, Role.RPS),
    }
