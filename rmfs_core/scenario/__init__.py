"""Scenario files: what a run consists of, read, checked, changed from the command line, and written again."""

from rmfs_core.scenario.model import (
    Arrivals,
    InstanceSection,
    LayoutSection,
    RobotsSection,
    RuleChoice,
    RulesSection,
    RunSection,
    Scenario,
    StationsSection,
)
from rmfs_core.scenario.reading import load_scenario, located, scenario_from_dict, shipped_scenarios
from rmfs_core.scenario.writing import scenario_to_dict

__all__ = [
    "Arrivals",
    "InstanceSection",
    "LayoutSection",
    "RobotsSection",
    "RuleChoice",
    "RulesSection",
    "RunSection",
    "Scenario",
    "StationsSection",
    "load_scenario",
    "located",
    "scenario_from_dict",
    "scenario_to_dict",
    "shipped_scenarios",
]
