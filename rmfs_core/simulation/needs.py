"""What a rule may rely on: a scenario that lacks it is refused before the run."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from rmfs_core.errors import InputError
from rmfs_core.scenario.model import Scenario
from rmfs_core.world import Instance

if TYPE_CHECKING:
    from rmfs_core.rules import RuleSet

NEEDS: dict[str, tuple[Callable[[Scenario, Instance], bool], str]] = {
    "unlimited stock": (
        lambda _, instance: instance.unlimited_stock,
        "pods whose SKUs never run out, but the instance has finite stock",
    ),
    "item capacity": (
        lambda scenario, _: scenario.stations.order_capacity is None,
        "stations that count items, but the scenario sets `stations.order_capacity`",
    ),
}
"""What a rule's class attribute ``needs`` may name: the test, and the end of the sentence when it fails."""


def check_needs(rules: RuleSet, scenario: Scenario, instance: Instance) -> None:
    """Raise `InputError` when a selected rule needs what the scenario does not have."""
    deciding = (rules.poa, rules.pps, rules.poa_pps, rules.pr, rules.ta, rules.pp, *rules.filters)
    for rule in deciding:
        if rule is None:
            continue
        place = "rules.filters" if rule.role == "filter" else f"rules.{rule.role}"
        lacks = unmet_need(type(rule.instance), scenario, instance, f"{place}: {rule.describe()}")
        if lacks is not None:
            raise InputError(place, f"{rule.describe()} needs {lacks}")


def unmet_need(rule: type, scenario: Scenario, instance: Instance, name: str) -> str | None:
    """Return what a rule's class needs and a scenario does not have, as the end of a sentence; None when it has all.

    Raises `InputError` for a need that does not exist; ``name`` is what the message calls the rule.
    """
    for need in getattr(rule, "needs", ()):
        if need not in NEEDS:
            raise InputError(name, f"needs {need!r}; known are {', '.join(map(repr, NEEDS))}")
        met, sentence = NEEDS[need]
        if not met(scenario, instance):
            return sentence
    return None
