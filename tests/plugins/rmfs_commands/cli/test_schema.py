"""The JSON Schema that editors use."""

from __future__ import annotations

import tomllib

import pytest
from jsonschema import Draft202012Validator

from rmfs_commands.cli.schema import scenario_schema
from rmfs_core.scenario import load_scenario, scenario_to_dict, shipped_scenarios

WRONG = [
    {"robots": {"cuont": 1}},  # unknown key
    {"robots": {"count": 0}},  # out of range
    {"robots": {"count": "2"}},  # wrong type
    {"layout": {"pod_fill": 0}},  # exclusive minimum
    {"instance": {"arrivals": {"process": "poison"}}},  # not one of the words
    {"rules": {"poa": {"x": 1}}},  # a rule's table without the rule
    {"stations": {"item_capacity": ["x"]}},  # within a list
]


def test_the_schema_is_a_schema() -> None:
    """The schema itself follows draft 2020-12."""
    Draft202012Validator.check_schema(scenario_schema())


@pytest.mark.parametrize("name", shipped_scenarios())
def test_shipped_scenarios_follow_it(name: str) -> None:
    """Shipped files are right as they stand, and with every default spelt out."""
    validator = Draft202012Validator(scenario_schema())
    validator.validate(tomllib.loads(shipped_scenarios()[name].read_text(encoding="utf-8")))
    validator.validate(scenario_to_dict(load_scenario(name)))


@pytest.mark.parametrize("change", WRONG)
def test_mistakes_are_marked(change: dict[str, object]) -> None:
    """What reading refuses within one value, the schema refuses too."""
    rules = {"poa": "pod-match", "pps": "demand"}
    assert not Draft202012Validator(scenario_schema()).is_valid({"rules": rules, **change})


def test_keys_are_described() -> None:
    """A key has its meaning, unit, default and range."""
    pick_s = scenario_schema()["properties"]["stations"]["properties"]["pick_s"]
    assert pick_s == {
        "type": "number",
        "description": "Time of picking a unit: holds the picker, the pod and its robot (s)",
        "minimum": 0.001,
        "maximum": 3600,
        "default": 7.0,
    }
