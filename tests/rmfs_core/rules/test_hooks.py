"""Which hooks a class implements, and what is said of one that does so wrongly. (Messages are compared in full.)"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rmfs_core.roles import Role
from rmfs_core.scenario.model import RuleChoice

Install = Callable[..., None]
Refusal = Callable[..., str]


def test_wrong_role(refusal: Refusal) -> None:
    """The message says which decision the rule does make."""
    assert refusal(poa=RuleChoice("nearest")) == (
        'rules.poa: rule "nearest" (rmfs 0.2.0.dev0) does not decide POA (hook `assign_orders`); '
        "class Nearest decides PR"
    )


def test_a_class_without_hooks(refusal: Refusal, install: Install) -> None:
    """A method that only lacks its decorator is pointed out."""
    unmarked = "@define\nclass Unmarked:\n    def assign_orders(self, warehouse):\n        return []\n"
    install(
        "acme",
        {"unmarked": "acme_rules:Unmarked", "nothing": "acme_rules:Nothing"},
        acme_rules=unmarked + "@define\nclass Nothing:\n    pass\n",
    )
    assert refusal(poa=RuleChoice("unmarked")) == (
        'rules.poa: rule "unmarked" (acme 1.0) has a method `assign_orders` that lacks the @hookimpl decorator'
    )
    assert refusal(poa=RuleChoice("nothing")) == (
        'rules.poa: rule "nothing" (acme 1.0) does not decide POA (hook `assign_orders`); '
        "class Nothing decides nothing (it implements no hook)"
    )


def test_misspelt_hook(refusal: Refusal, install: Install) -> None:
    """Class and nearest hook are named."""
    install(
        "acme",
        {"mine": "acme_rules:Mine"},
        acme_rules="@define\nclass Mine:\n    @hookimpl\n    def asign_orders(self, warehouse):\n        return []\n",
    )
    assert refusal(poa=RuleChoice("mine")) == (
        "rules.poa: class Mine implements a hook `asign_orders`, which does not exist (did you mean "
        "`assign_orders` or `assign_orders_and_pods`?); the hooks are assign_orders, select_pods, "
        "assign_orders_and_pods, choose_storage_location, assign_tasks, plan_path, filter_backlog, run_started, "
        "on_event, rule_asked, rule_answered, measured and run_ended"
    )


def test_argument_that_the_hook_does_not_have(refusal: Refusal, install: Install) -> None:
    """Class, hook and the valid arguments are named."""
    install(
        "acme",
        {"mine": "acme_rules:Mine"},
        acme_rules="@define\nclass Mine:\n    @hookimpl\n    def assign_orders(self, warehose):\n        return []\n",
    )
    assert refusal(poa=RuleChoice("mine")) == (
        "rules.poa: class Mine: hook `assign_orders` has no argument `warehose` (did you mean `warehouse`?); "
        "valid arguments are warehouse and rng"
    )


def test_not_an_attrs_class(refusal: Refusal, install: Install) -> None:
    """Parameters come from attrs fields, so nothing else will do."""
    install(
        "acme",
        {"plain": "acme_rules:Plain", "number": "acme_rules:NUMBER"},
        acme_rules="class Plain:\n    pass\n\nNUMBER = 5\n",
    )
    assert refusal(poa=RuleChoice("plain")) == (
        'rules.poa: rule "plain" (acme 1.0) is no attrs class: expected a class decorated with @attrs.define, '
        "found class Plain"
    )
    assert refusal(poa=RuleChoice("number")) == (
        'rules.poa: rule "number" (acme 1.0) is no attrs class: expected a class decorated with @attrs.define, found 5'
    )


@pytest.mark.parametrize("role", [role for role in Role if role is not Role.OBSERVER])
def test_a_misspelt_hook_is_refused_before_the_run(refusal: Refusal, tmp_path: Path, role: Role) -> None:
    """A method marked as hook that no hook has the name of: the error names the class and the nearest hook."""
    (tmp_path / "bad.py").write_text(
        "from attrs import define\nfrom rmfs_core import hookimpl\n@define\nclass Bad:\n"
        f"    @hookimpl\n    def {role.hook}x(self, warehouse): return []\n",
        encoding="utf-8",
    )
    bad = RuleChoice("./bad.py:Bad")
    others = {Role.FILTER: {"filters": (bad,)}, Role.POA_PPS: {"poa": None, "pps": None, "poa_pps": bad}}
    text = refusal(tmp_path, **others.get(role, {role.key: bad}))
    assert "Bad" in text
    assert f"{role.hook}x" in text
    assert role.hook in text.replace(f"{role.hook}x", "")
