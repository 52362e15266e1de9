"""Versions, seeds and scenarios that repeat an experiment: experiment.json."""

from __future__ import annotations

from typing import Any

from rmfs_commands.experiments.keys import digest_of, rules_of
from rmfs_commands.experiments.running import ExperimentResult
from rmfs_core.scenario import scenario_to_dict


def rules_digests(result: ExperimentResult) -> dict[str, list[str]]:
    """Return the digests of the rules of each rule set; several where axes change its rules."""
    found: dict[str, dict[str, None]] = {}
    for (_, rule_set), scenario in result.scenarios.items():
        found.setdefault(rule_set, {})[digest_of(rules_of(scenario))] = None
    return {rule_set: list(digests) for rule_set, digests in found.items()}


def repeating(result: ExperimentResult) -> dict[str, Any]:
    """Return versions, seeds, and the scenario of each instance and rule set, with every key and the digest of rules.

    Files that scenarios name are told by name alone; their digests are part of the key of each run, and those of the
    files that rules name part of the digest of rules.
    """
    experiment = result.experiment
    return {
        "experiment": experiment.name,
        "description": experiment.description,
        "seeds": list(experiment.seeds),
        "baseline": experiment.baseline,
        "metrics": list(experiment.metrics),
        "versions": result.versions,
        "scenarios": [
            {
                "instance": instance,
                "rule_set": rule_set,
                "rules_sha256": digest_of(rules_of(scenario)),
                "scenario": {key: value for key, value in scenario_to_dict(scenario).items() if key != "seed"},
            }
            for (instance, rule_set), scenario in result.scenarios.items()
        ],
    }
