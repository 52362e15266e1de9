"""Which hooks a class implements, and what is said of one that does so wrongly. (Messages are compared in full.)"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from installed import RMFS
from rmfs_core import InputError, hookimpl
from rmfs_core.roles import Role
from rmfs_core.rules.hooks import ARGUMENTS, OBSERVER_HOOKS, WAKE, check_hooks, decided, marked_methods, roles_of
from rmfs_core.scenario.model import RuleChoice

Install = Callable[..., None]
Refusal = Callable[..., str]


def test_wrong_role(refusal: Refusal) -> None:
    """The message says which decision the rule does make."""
    assert refusal(poa=RuleChoice("nearest")) == (
        f'rules.poa: rule "nearest" ({RMFS}) does not decide POA (hook `assign_orders`); class Nearest decides PR'
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
        "`assign_orders`, `assign_orders_and_pods` or `assign_bundles`?); the hooks are assign_orders, select_pods, "
        "assign_orders_and_pods, choose_storage_location, assign_tasks, plan_path, plan_paths, "
        "assign_bundles, select_replenishment_pods, assign_bundles_and_pods, activate_stations, idle_robots, "
        "move_pods, filter_backlog, wake_at, run_started, on_event, rule_asked, rule_answered, measured and run_ended"
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
    others = {
        Role.FILTER: {"filters": (bad,)},
        Role.POA_PPS: {"poa": None, "pps": None, "poa_pps": bad},
        Role.ROA: {"roa": bad, "rps": RuleChoice("emptiest-pod")},
        Role.RPS: {"roa": RuleChoice("first-bundle"), "rps": bad},
    }
    text = refusal(tmp_path, **others.get(role, {role.key: bad}))
    assert "Bad" in text
    assert f"{role.hook}x" in text
    assert role.hook in text.replace(f"{role.hook}x", "")


def test_a_hook_without_arguments_says_so() -> None:
    """There is no list of valid arguments to give."""

    class Watch:
        @hookimpl
        def measured(self, run: object) -> dict[str, float]:
            """Ask for what the hook does not have."""
            return {}

    with pytest.raises(InputError) as caught:
        check_hooks("observer Watch", Watch(), "Watch")
    assert str(caught.value) == ("observer Watch: class Watch: hook `measured` has no argument `run`; it has none")


class Several:
    """POA under another method's name, a filter, and an observer; `select_pods` is only a method."""

    @hookimpl(specname="assign_orders")
    def decide(self, warehouse: object, weight: int = 1) -> list[object]:
        """An argument with a default is the class's own affair."""
        return []

    @hookimpl
    def filter_backlog(self, orders: list[object]) -> list[object]:
        """Arguments may be left out."""
        return orders

    @hookimpl
    def run_ended(self) -> None:
        """Observe."""

    def select_pods(self) -> None:
        """Not marked."""


def test_hooks_are_found_by_their_mark() -> None:
    """By the name of the hook, wherever the method's own name differs; what is not marked is none."""
    assert marked_methods(Several) == {
        "assign_orders": "decide",
        "filter_backlog": "filter_backlog",
        "run_ended": "run_ended",
    }
    assert marked_methods(Several()) == marked_methods(Several)
    check_hooks("here", Several, "Several")
    check_hooks("here", Several(), "Several")


def test_roles_follow_from_hooks() -> None:
    """Any observer hook makes an observer; a class may play several roles, or none."""
    assert roles_of(Several) == (Role.POA, Role.FILTER, Role.OBSERVER)
    assert roles_of(object) == ()
    assert decided(roles_of(Several)) == "POA, filter and observer"
    assert decided(()) == "nothing (it implements no hook)"


def test_every_role_has_a_hook_that_exists() -> None:
    """And every hook belongs to a role, but for the one that any deciding rule may implement."""
    assert {hook for role in Role for hook in role.hooks} | OBSERVER_HOOKS | {WAKE} == set(ARGUMENTS)


@pytest.mark.parametrize("option", ["wrapper", "hookwrapper", "tryfirst", "trylast"])
def test_who_is_told_first_is_up_to_the_kernel(option: str, refusal: Refusal, install: Install) -> None:
    """An observer stands neither before the built-in metrics nor around the others."""
    source = f"@define\nclass Mine:\n    @hookimpl({option}=True)\n    def on_event(self, event):\n        yield\n"
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=source)
    assert refusal(observers=(RuleChoice("mine"),)) == (
        f"rules.observers[0]: class Mine: `on_event` is marked with {option}; expected @hookimpl alone"
    )


def test_a_property_that_raises_is_no_hook() -> None:
    """It is the observer's own affair."""

    class Mine:
        dear = property(lambda self: 1 / 0)

        @hookimpl
        def on_event(self) -> None:
            pass

    assert marked_methods(Mine()) == {"on_event": "on_event"}
