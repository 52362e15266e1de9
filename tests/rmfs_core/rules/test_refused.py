"""What is wrong with a rule, said in one sentence. (Messages are compared in full.)"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rmfs_core import InputError
from rmfs_core.rules import RuleSet
from rmfs_core.scenario.model import RuleChoice, RulesSection

Install = Callable[..., None]

MINE = """
@define
class Mine:
    weight: int = 1
    share: float = field(default=0.5, validator=validators.ge(0))
    names: tuple[str, ...] = ()
    mode: str = field(default="slow")
    rest: float | None = None
    pair: tuple[int, str] = (1, "a")

    @mode.validator
    def _check_mode(self, attribute, value):
        if value not in ("slow", "fast"):
            raise ValueError('expected "slow" or "fast"')

    def __attrs_post_init__(self):
        if self.weight == 13:
            raise ValueError("expected a weight that is lucky, found 13")

    @hookimpl
    def assign_orders(self, warehouse):
        return []
"""


def refusal(folder: str | Path = ".", *, allow_inline: bool = True, **choices: RuleChoice | None) -> str:
    """Return the message with which a rule set is refused: the sequential rules, some replaced."""
    rules = RulesSection(**({"poa": RuleChoice("pod-match"), "pps": RuleChoice("demand")} | choices))  # type: ignore[arg-type]
    with pytest.raises(InputError) as caught:
        RuleSet.load(rules, str(folder), allow_inline=allow_inline)
    return str(caught.value)


def test_unknown_rule() -> None:
    """The nearest names are offered, or all."""
    assert refusal(poa=RuleChoice("pod-mach")) == ('rules.poa: there is no rule "pod-mach" (did you mean `pod-match`?)')
    assert refusal(pr=RuleChoice("xyzzy")).startswith(
        'rules.pr: there is no rule "xyzzy"; expected one of `balanced`, '
    )
    assert refusal(filters=(RuleChoice("xyzzy"),)).startswith("rules.filters[0]: ")  # type: ignore[arg-type]


def test_wrong_role() -> None:
    """The message says which decision the rule does make."""
    assert refusal(poa=RuleChoice("nearest")) == (
        'rules.poa: rule "nearest" (rmfs 0.2.0.dev0) does not decide POA (hook `assign_orders`); '
        "class Nearest decides PR"
    )


def test_a_class_without_hooks(install: Install) -> None:
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


def test_misspelt_hook(install: Install) -> None:
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


def test_argument_that_the_hook_does_not_have(install: Install) -> None:
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


def test_not_an_attrs_class(install: Install) -> None:
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


@pytest.mark.parametrize(
    ("source", "target", "cause"),
    [
        ("import acme_nowhere", "Mine", "ModuleNotFoundError: No module named 'acme_nowhere'"),
        ("x = 1", "Mine", "AttributeError: module 'acme_rules' has no attribute 'Mine'"),
        ("x = = 1", "Mine", "SyntaxError: invalid syntax (acme_rules.py, line 3)"),
        ("raise SystemExit(4)", "Mine", "SystemExit: 4"),
    ],
)
def test_module_that_cannot_be_imported(install: Install, source: str, target: str, cause: str) -> None:
    """Rule, distribution and cause are named, whatever the module did."""
    install("acme", {"mine": f"acme_rules:{target}"}, acme_rules=source)
    assert refusal(poa=RuleChoice("mine")) == (
        f'rules.poa: rule "mine" (acme 1.0) cannot be imported from acme_rules:Mine: {cause}'
    )


def test_two_distributions_with_one_name_clash_only_when_it_is_selected(install: Install) -> None:
    """Both are named; a scenario that does not use the name runs."""
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=MINE)
    install("bolt", {"mine": "bolt_rules:Mine"}, bolt_rules=MINE)
    assert refusal(poa=RuleChoice("mine")) == (
        'rules.poa: rule "mine" is offered by more than one installed distribution: acme 1.0 and bolt 1.0; '
        "uninstall all but one"
    )
    RuleSet.load(RulesSection(poa=RuleChoice("pod-match"), pps=RuleChoice("demand")), ".")


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        (
            {"wieght": 1},
            '.wieght: rule "mine" (acme 1.0) has no parameter `wieght` (did you mean `weight`?); valid parameters are '
            "weight, share, names, mode, rest and pair",
        ),
        ({"weight": "1"}, '.weight: expected a whole number, found "1"'),  # a text is no number
        ({"weight": True}, ".weight: expected a whole number, found true"),  # nor is true
        ({"weight": 1.0}, ".weight: expected a whole number, found 1.0"),
        ({"share": "0.5"}, '.share: expected a number, found "0.5"'),
        ({"rest": "x"}, '.rest: expected a number or nothing, found "x"'),
        ({"names": ["a", 1]}, '.names: expected a list, each a text, found ["a", 1]'),
        ({"names": "ab"}, '.names: expected a list, each a text, found "ab"'),
        ({"pair": [1]}, ".pair: expected a list of a whole number and a text, found [1]"),
        ({"share": -1.0}, ".share: 'share' must be >= 0: -1.0"),  # a validator of attrs
        ({"mode": "idle"}, '.mode: expected "slow" or "fast", found "idle"'),  # the rule's own validator
        ({"weight": 13}, ': rule "mine" (acme 1.0): expected a weight that is lucky, found 13'),
    ],
)
def test_wrong_parameter(install: Install, parameters: dict[str, Any], message: str) -> None:
    """Place, what was found and what would be right."""
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=MINE)
    assert refusal(poa=RuleChoice("mine", parameters)) == f"rules.poa{message}"


def test_parameters_of_the_right_type_are_accepted(install: Install) -> None:
    """A whole number will do for a number, and a list for a tuple."""
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=MINE)
    choice = RuleChoice("mine", {"share": 1, "names": ["a"], "rest": 2, "mode": "fast", "pair": [2, "b"]})
    loaded = RuleSet.load(RulesSection(poa=choice, pps=RuleChoice("demand")), ".")
    assert loaded.poa is not None
    mine = loaded.poa.instance
    assert (mine.share, mine.names, mine.rest, mine.mode, mine.pair) == (1.0, ("a",), 2.0, "fast", (2, "b"))


def test_a_rule_without_parameters_says_so() -> None:
    """There is no list of valid names to give."""
    assert refusal(pp=RuleChoice("free-flow", {"speed": 1})) == (
        'rules.pp.speed: rule "free-flow" (rmfs 0.2.0.dev0) has no parameter `speed`; it has no parameters'
    )


def test_missing_parameter(install: Install) -> None:
    """A parameter without a default has to be given."""
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=MINE.replace("weight: int = 1", "weight: int"))
    assert refusal(poa=RuleChoice("mine")) == (
        'rules.poa.weight: rule "mine" (acme 1.0) needs the parameter `weight`, which is missing'
    )


def test_a_class_that_raises_at_construction(install: Install) -> None:
    """Any exception becomes the sentence, with its cause."""
    source = MINE.replace('raise ValueError("expected a weight that is lucky, found 13")', "{}['x']")
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=source)
    assert refusal(poa=RuleChoice("mine", {"weight": 13})) == (
        "rules.poa: rule \"mine\" (acme 1.0) cannot be created: KeyError: 'x'"
    )
