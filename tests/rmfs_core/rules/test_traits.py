"""What a rule's class declares besides its decisions."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from attrs import evolve

from rmfs_commands.testing import small_instance
from rmfs_core.errors import InputError
from rmfs_core.events import Event, OrderCompleted
from rmfs_core.info import RunInfo
from rmfs_core.rules.traits import RuleTraits
from rmfs_core.scenario.model import BatterySection, RobotsSection, RuleChoice, StationsSection

EVENTS = "a tuple of classes of events, or a mapping from these to lists of functions"
NEEDED = "a tuple of 'unlimited stock', 'item capacity' or 'no batteries'"

Refusal = Callable[..., str]

PATHS = """
from attrs import define
from rmfs_core import hookimpl

@define
class Mine:
    reserves = "paths"

    @hookimpl
    def plan_path(self):
        pass
"""


def test_what_is_left_out_has_its_default() -> None:
    """A plain rule needs nothing, splits nothing and reserves nothing; None is as good as left out."""
    assert RuleTraits.of(object(), "here", "it") == RuleTraits()
    assert RuleTraits.of(SimpleNamespace(reserves=None, packing_capacity=None), "here", "it") == RuleTraits()


def test_what_is_declared_is_read() -> None:
    """From the instance, so that a parameter can be one."""
    declared: dict[str, Any] = {
        "needs": ("unlimited stock",),
        "libraries": ("highspy",),
        "splits_over_time": True,
        "packing_capacity": 0,
        "reserves": "windows",
        "prepare": print,
        "hears": {OrderCompleted: [print]},
    }
    assert RuleTraits.of(SimpleNamespace(**declared), "here", "it") == RuleTraits(**declared)


def test_roles_may_be_given_as_texts() -> None:
    """Whoever asks for a role's label finds it."""
    (role,) = RuleTraits.of(SimpleNamespace(decides=("pps",)), "here", "it").decides
    assert (role.label, role.hook) == ("PPS", "select_pods")


@pytest.mark.parametrize(
    ("trait", "value", "expected"),
    [
        ("needs", "unlimited stock", NEEDED),  # a text is no tuple of them
        ("needs", ("luck",), NEEDED),
        ("libraries", ["highspy"], "a tuple of installed distributions' names"),
        ("libraries", (1,), "a tuple of installed distributions' names"),
        ("libraries", ("no-such-distribution",), "a tuple of installed distributions' names"),
        ("libraries", ("",), "a tuple of installed distributions' names"),
        ("decides", ("poa", "prices"), "a tuple of roles"),
        ("splits_over_time", 1, "True or False"),
        ("packing_capacity", -1, "a whole number >= 0, or None"),
        ("packing_capacity", True, "a whole number >= 0, or None"),
        ("reserves", "paths", "'full paths', 'windows', 'fleet' or None"),
        ("prepare", "warm up", "a method"),
        ("hears", 5, EVENTS),
        ("hears", OrderCompleted, EVENTS),  # a class is no tuple of them
        ("hears", ("OrderCompleted",), EVENTS),
        ("hears", (int,), EVENTS),
        ("hears", (Event,), EVENTS),  # nothing that happens is just an event
        ("hears", {OrderCompleted: 3}, EVENTS),
        ("hears", {OrderCompleted: [3]}, EVENTS),
        ("hears", {int: [print]}, EVENTS),
    ],
)
def test_a_wrong_declaration_is_refused(trait: str, value: object, expected: str) -> None:
    """Place and rule are named, with what was found and what would be right."""
    with pytest.raises(InputError) as caught:
        RuleTraits.of(SimpleNamespace(**{trait: value}), "rules.pp", 'rule "mine" (acme 1.0)')
    assert str(caught.value) == f'rules.pp: rule "mine" (acme 1.0) has {trait} = {value!r}; expected {expected}'


def test_a_scenarios_rule_is_held_to_them(refusal: Refusal, tmp_path: Any) -> None:
    """A misspelt attribute is named when rules are loaded, not in the middle of a run."""
    (tmp_path / "mine.py").write_text(PATHS)
    assert refusal(tmp_path, pp=RuleChoice("./mine.py:Mine")) == (
        "rules.pp: rule \"./mine.py:Mine\" (mine.py inline) has reserves = 'paths'; "
        "expected 'full paths', 'windows', 'fleet' or None"
    )


def test_what_a_rule_needs_is_held_against_the_scenario(tiny: RunInfo) -> None:
    """The end of a sentence says what is lacking, in the rule's own order."""
    finite, endless = small_instance({"1": ["a"]}, {"p": {"a": 1}}), small_instance({"1": ["a"]}, {"p": ["a"]})
    by_orders = evolve(tiny.scenario, stations=StationsSection(order_capacity=3))
    stock = "pods whose SKUs never run out, but the instance has finite stock"
    items = "stations that count items, but the scenario sets `stations.order_capacity`"
    both = RuleTraits(needs=("item capacity", "unlimited stock"))
    assert both.lacks(tiny.scenario, endless) == []
    assert both.lacks(tiny.scenario, finite) == [stock]
    assert both.lacks(by_orders, finite) == [items, stock]
    assert RuleTraits().lacks(by_orders, finite) == []
    charged = evolve(tiny.scenario, robots=RobotsSection(battery=BatterySection()))
    without = RuleTraits(needs=("no batteries",))
    assert without.lacks(tiny.scenario, finite) == []
    assert without.lacks(charged, finite) == [
        "robots without batteries, as it sends none to a charger, but the scenario sets `robots.battery`"
    ]


def test_a_trait_that_cannot_be_read_or_compared_is_one_sentence() -> None:
    """Whatever it is."""

    class Raising:
        needs = property(lambda self: 1 / 0)

    with pytest.raises(InputError, match=r"^here: it has needs = ZeroDivisionError\('division by zero'\); expected a "):
        RuleTraits.of(Raising(), "here", "it")
    with pytest.raises(InputError, match=r"^here: it has reserves = array\(\[\[1, 2\], \[3, 4\]\]\); expected "):
        RuleTraits.of(SimpleNamespace(reserves=np.array([[1, 2], [3, 4]])), "here", "it")
