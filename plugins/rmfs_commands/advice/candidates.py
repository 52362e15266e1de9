"""The rule sets that are tried, and the experiment that compares them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from rmfs_commands.cli.serving import SERVING
from rmfs_commands.experiments import Base, Experiment, RuleSetChoice
from rmfs_commands.experiments.experiment_file import label_of
from rmfs_commands.experiments.resolving import resolve
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import Scenario
from rmfs_core.scenario.model import RuleChoice

Changes = Mapping[str, Any]

WHOLE: tuple[Changes, ...] = (
    SERVING,
    {"rules.poa": "pod-match", "rules.pps": "completes"},
    {"rules.poa": "common-lines", "rules.pps": "completes"},
    {"rules.poa": "near-best-pod", "rules.pps": "completes"},
    {"rules.poa": "workload", "rules.pps": "lexicographic"},
)
"""Candidates that keep orders whole."""
SPLITTING: tuple[Changes, ...] = ({"rules.poa_pps": "pod-index", "rules.ta": "nearest-robot"},)
"""Candidates that split orders."""
COST = "cost_per_order"
"""The metric of what an order costs."""
OWN = " (now)"
"""Behind the name of the scenario's own rule set."""


def lets_split(scenario: Scenario, rules: RuleSet) -> bool:
    """Whether a scenario lets orders be split: it has packing stations, or its own joint rule splits orders."""
    joint = scenario.rules.poa_pps is not None
    return scenario.packing is not None or (joint and not rules.deciding[0].traits.whole_orders)


def advice_experiment(
    scenario: Scenario,
    name: str,
    seeds: tuple[int, ...],
    *,
    split: bool,
    more: tuple[str, ...] = (),
    more_place: str | None = None,
) -> Experiment:
    """Return the experiment that compares a scenario's own rules with the candidates.

    Parameters
    ----------
    scenario
        The scenario that is run.
    name
        Its name in messages.
    seeds
        One run of each rule set for each.
    split
        Whether candidates that split orders are among them.
    more
        Metrics besides visits and times; that of costs is among them where the scenario names costs.
    more_place
        Their name in messages.
    """
    own = _orders_and_pods(scenario)
    baseline = _name({"rule": one.rule, **one.parameters} for one in own if one is not None) + OWN
    tried = [*WHOLE, *(SPLITTING if split else ())]
    others = [
        RuleSetChoice(_name(choice for key, choice in one.items() if key != "rules.ta"), one)
        for one in tried
        if _orders_and_pods(resolve(scenario, one, scenario.folder, name)) != own
    ]
    packed = scenario.packing is not None
    times = ("packed_s", "packed_p95_s") if packed else ("turnover_s", "turnover_p95_s")
    costs = () if scenario.costs is None else (COST,)
    return Experiment(
        name=f"advise-{name}",
        description=f"Which rule set serves {name} best?",
        bases=(Base(name, scenario),),
        rule_sets=(RuleSetChoice(baseline), *others),
        seeds=seeds,
        baseline=baseline,
        metrics=tuple(dict.fromkeys(("psv_per_order", *times, *costs, *more))),
        fronts=(("psv_per_order", times[0]),),
        folder=scenario.folder,
        place=name,
        metrics_place=more_place,
    )


def _orders_and_pods(scenario: Scenario) -> tuple[RuleChoice | None, ...]:
    """Return the rules that decide on orders and pods."""
    return scenario.rules.poa, scenario.rules.pps, scenario.rules.poa_pps


def _name(choices: Iterable[Any]) -> str:
    return " + ".join(map(label_of, choices))
