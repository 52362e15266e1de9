"""A rule's parameters: what is refused, in one sentence. (Messages are compared in full.)"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal, Optional

import pytest
from attrs import define, field

from installed import RMFS
from rmfs_core.errors import InputError
from rmfs_core.rules import RuleSet
from rmfs_core.rules.parameters import build, parameters_of, type_name, values_of
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
    rest: float | None = field(default=None, metadata={"infinite": True})
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
        ({"weight": 10**12}, ".weight: expected a whole number below 1e+12, found 1000000000000"),
        ({"share": float("inf")}, ".share: expected a number below 1e+12, found inf"),
        ({"share": 1e300}, ".share: expected a number below 1e+12, found 1e+300"),
        ({"rest": float("nan")}, ".rest: expected a number or nothing below 1e+12, found nan"),
        ({"weight": 1.0}, ".weight: expected a whole number, found 1.0"),
        ({"share": "0.5"}, '.share: expected a number, found "0.5"'),
        ({"rest": "x"}, '.rest: expected a number or nothing, found "x"'),
        ({"names": ["a", 1]}, '.names: expected a list, each a text, found ["a", 1]'),
        ({"names": "ab"}, '.names: expected a list, each a text, found "ab"'),
        ({"pair": [1]}, ".pair: expected a list of a whole number and a text, found [1]"),
        ({"share": -1.0}, ".share: expected a number >= 0, found -1.0"),  # a validator of attrs
        ({"mode": "idle"}, '.mode: expected "slow" or "fast", found "idle"'),  # the rule's own validator
        ({"weight": 13}, ': rule "mine" (acme 1.0): expected a weight that is lucky, found 13'),
    ],
)
def test_wrong_parameter(refusal: Refusal, install: Install, parameters: dict[str, Any], message: str) -> None:
    """Place, what was found and what would be right."""
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=MINE)
    assert refusal(poa=RuleChoice("mine", parameters)) == f"rules.poa{message}"


def test_parameters_of_the_right_type_are_accepted(install: Install) -> None:
    """A whole number will do for a number, and a list for a tuple; a number may be infinite that says so."""
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=MINE)
    choice = RuleChoice("mine", {"share": 1, "names": ["a"], "rest": float("inf"), "mode": "fast", "pair": [2, "b"]})
    loaded = RuleSet.load(RulesSection(poa=choice, pps=RuleChoice("demand")), ".")
    assert loaded.poa is not None
    mine = loaded.poa.instance
    assert (mine.share, mine.names, mine.rest, mine.mode, mine.pair) == (1.0, ("a",), float("inf"), "fast", (2, "b"))


def test_a_rule_without_parameters_says_so(refusal: Refusal) -> None:
    """There is no list of valid names to give."""
    assert refusal(pp=RuleChoice("free-flow", {"speed": 1})) == (
        f'rules.pp.speed: rule "free-flow" ({RMFS}) has no parameter `speed`; it has no parameters'
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


@define
class Shelf:
    """A rule's class with what scenarios can and cannot set."""

    width: int
    _depth: float = 2.5
    labels: list[str] = field(factory=list)
    found: int = field(init=False, default=0)
    anything: Any = None
    doubled: int = field(default=1, converter=lambda value: 2 * int(value))


def test_parameters_are_the_fields_that_init_takes() -> None:
    """By the name that the class is called with: without the underscore, and not what it makes itself."""
    assert list(parameters_of(Shelf)) == ["width", "depth", "labels", "anything", "doubled"]


def test_a_class_is_built_from_its_parameters() -> None:
    """Types are held, but for those that the class converts itself or leaves open."""
    shelf = build(Shelf, {"width": 3, "depth": 1, "anything": {"a": [1]}, "doubled": "4"}, "rules.pr", "rule")
    assert shelf == Shelf(width=3, depth=1.0, anything={"a": [1]}, doubled=4)
    assert "depth=1.0" in repr(shelf)
    assert build(Shelf, {"width": 1}, "p", "r").labels is not build(Shelf, {"width": 1}, "p", "r").labels


def test_an_objects_parameters_are_told_as_a_scenario_has_them() -> None:
    """Those that are not the class's defaults; of what no file can hold there is the type, the same in every run."""
    shelf = Shelf(3, depth=2.5, labels=["a"], anything={"by": len, "pair": (1, 2), "file": Path("a/b")})
    assert values_of(shelf) == {
        "width": 3,
        "labels": ["a"],
        "anything": {"by": "<builtin_function_or_method>", "pair": [1, 2], "file": "a/b"},
        "doubled": 2,
    }


def test_parameters_that_hold_themselves_are_told_as_types() -> None:
    """From some depth on, so that a run with them ends."""
    around: list[object] = []
    around.append(around)
    told = values_of(Shelf(3, anything=around))["anything"]
    for _ in range(20):
        [told] = [told] if told == "<list>" else told
    assert told == "<list>"


def test_what_is_unknown_is_said_before_what_is_missing() -> None:
    """A misspelt name is why the right one is missing."""
    with pytest.raises(InputError, match=r"^here\.widht: it has no parameter `widht` \(did you mean `width`\?\)"):
        build(Shelf, {"widht": 3}, "here", "it")
    with pytest.raises(InputError, match=r"^here\.width: it needs the parameter `width`, which is missing$"):
        build(Shelf, {"depth": 3.0}, "here", "it")


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        (int, "a whole number"),
        (float | None, "a number or nothing"),
        (Optional[str], "a text or nothing"),  # noqa: UP045 - the older spelling is another class
        (Literal["slow", 3], 'one of "slow", 3'),
        (list[bool], "a list, each true or false"),
        (tuple[int, ...], "a list, each a whole number"),
        (tuple[int, str], "a list of a whole number and a text"),
        (list[tuple[int, int]], "a list, each a list of a whole number and a whole number"),
        (Path | None, "the name of a file or nothing"),
        (Shelf, "Shelf"),
        (Any, "Any"),
    ],
)
def test_types_are_named_for_people(kind: Any, name: str) -> None:
    """As a message ends: expected ..."""
    assert type_name(kind) == name
