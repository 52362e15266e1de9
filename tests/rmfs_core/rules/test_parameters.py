"""A rule's parameters: what is refused, in one sentence. (Messages are compared in full.)"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rmfs_core.rules import RuleSet
from rmfs_core.scenario.model import RuleChoice, RulesSection

Install = Callable[..., None]
Refusal = Callable[..., str]

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
def test_wrong_parameter(refusal: Refusal, install: Install, parameters: dict[str, Any], message: str) -> None:
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


def test_a_rule_without_parameters_says_so(refusal: Refusal) -> None:
    """There is no list of valid names to give."""
    assert refusal(pp=RuleChoice("free-flow", {"speed": 1})) == (
        'rules.pp.speed: rule "free-flow" (rmfs 0.2.0.dev0) has no parameter `speed`; it has no parameters'
    )


def test_missing_parameter(refusal: Refusal, install: Install) -> None:
    """A parameter without a default has to be given."""
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=MINE.replace("weight: int = 1", "weight: int"))
    assert refusal(poa=RuleChoice("mine")) == (
        'rules.poa.weight: rule "mine" (acme 1.0) needs the parameter `weight`, which is missing'
    )


def test_a_class_that_raises_at_construction(refusal: Refusal, install: Install) -> None:
    """Any exception becomes the sentence, with its cause."""
    source = MINE.replace('raise ValueError("expected a weight that is lucky, found 13")', "{}['x']")
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=source)
    assert refusal(poa=RuleChoice("mine", {"weight": 13})) == (
        "rules.poa: rule \"mine\" (acme 1.0) cannot be created: KeyError: 'x'"
    )
