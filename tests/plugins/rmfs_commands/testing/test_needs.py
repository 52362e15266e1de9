"""A rule that needs something, through all tools."""

from collections.abc import Callable

import pytest

import rmfs_core
from calling import refusal
from cases import cases
from rmfs_core import InputError

RULE = """
from rmfs_core.rule_helpers import send_pods

@define
class Eager:
    needs = ({need!r},)
    @hookimpl
    def select_pods(self, warehouse, max_fetches):
        return send_pods(warehouse, max_fetches, lambda station, pods, wanted: pods[0])

@define
class Keeps:
    needs = ({need!r},)
    @hookimpl
    def filter_backlog(self, orders): return orders
"""


@cases(
    "need key sentence",
    ("unlimited stock", "instance.items_per_sku=500", "needs pods whose SKUs never run out, but the instance has"),
    ("item capacity", "stations.order_capacity=6", "needs stations that count items, but the scenario sets"),
)
def test_a_scenario_that_lacks_it_is_refused(install: Callable[..., None], need: str, key: str, sentence: str) -> None:
    install("acme", {"eager": "acme_rules:Eager", "keeps": "acme_rules:Keeps"}, acme_rules=RULE.format(need=need))
    for choice in ("rules.pps=eager", 'rules.filters=["keeps"]'):
        name = choice.partition("=")[2].strip('[]"')
        with pytest.raises(InputError) as caught:
            rmfs_core.run("examples/small", overrides=[choice, key])
        assert str(caught.value).startswith(f'--set {choice}: rule "{name}" (acme 1.0)')
        assert sentence in str(caught.value)


@pytest.mark.parametrize("rule", ["stay", "rest-nearest", "rest-middle"])
def test_rules_that_send_nobody_to_chargers_are_refused_with_batteries(rule: str) -> None:
    with pytest.raises(
        InputError, match=f'^--set rules.idle={rule}: rule "{rule}" .* needs robots without batteries, as it sends'
    ):
        rmfs_core.run("examples/charging", overrides=[f"rules.idle={rule}"])


@cases(
    "trait sentence",
    (
        "needs = ('magic',)",
        "has needs = ('magic',); expected a tuple of 'unlimited stock', 'item capacity' or 'no batteries'",
    ),
    ("needs = 'unlimited stock'", "has needs = 'unlimited stock'; expected a tuple of 'unlimited stock', 'item"),
    ("libraries = ('numpy', 3)", "has libraries = ('numpy', 3); expected a tuple of installed distributions' names"),
    ("splits_over_time = 1", "has splits_over_time = 1; expected True or False"),
    ("packing_capacity = -1", "has packing_capacity = -1; expected a whole number >= 0, or None"),
    ("reserves = 'all'", "has reserves = 'all'; expected 'full paths', 'windows', 'fleet' or None"),
    ("prepare = 'fast'", "has prepare = 'fast'; expected a method"),
)
def test_a_trait_of_the_wrong_type_is_refused(install: Callable[..., None], trait: str, sentence: str) -> None:
    """When the rule is loaded, with one sentence that names it and says what would be right."""
    rule = f"@define\nclass Odd:\n    {trait}\n    @hookimpl\n    def select_pods(self):\n        return []\n"
    install("acme", {"odd": "acme_rules:Odd"}, acme_rules=rule)
    assert refusal(lambda: rmfs_core.run("examples/small", overrides=["rules.pps=odd"])).startswith(
        f'--set rules.pps=odd: rule "odd" (acme 1.0) {sentence}'
    )
