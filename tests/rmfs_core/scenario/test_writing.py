"""A scenario as TOML reads back as an equal scenario."""

from __future__ import annotations

import json
import tomllib
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_commands.cli.toml_scenario import to_toml
from rmfs_core.scenario import (
    Arrivals,
    InstanceSection,
    LayoutSection,
    RobotsSection,
    RuleChoice,
    RulesSection,
    RunSection,
    Scenario,
    StationsSection,
    load_scenario,
    scenario_from_dict,
    scenario_to_dict,
    shipped_scenarios,
)

TEXTS = st.text(st.characters(codec="utf-8"), max_size=8)
COUNTS = st.integers(1, 10**5)
TIMES = st.floats(0.001, 1e6)
VALUES = st.recursive(
    st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False) | TEXTS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3),
    max_leaves=6,
)
PARAMETERS = st.dictionaries(TEXTS.filter(lambda name: name != "rule"), VALUES, max_size=3)
RULES = st.builds(RuleChoice, TEXTS.filter(bool), PARAMETERS)
MANY_RULES = st.lists(RULES, max_size=2).map(tuple)
CAPACITIES = COUNTS | st.lists(COUNTS, min_size=1, max_size=3).map(tuple)

INSTANCES = st.builds(
    InstanceSection,
    orders=st.integers(0, 500),
    skus=st.integers(3, 100),
    items_per_sku=st.none() | COUNTS,
    arrivals=st.just(Arrivals()) | st.builds(Arrivals, st.just("poisson"), TIMES),
    pods_at_stations=st.dictionaries(TEXTS, st.lists(TEXTS, max_size=2).map(tuple), max_size=2),
) | st.builds(InstanceSection, orders_file=TEXTS, pods_file=TEXTS)
TWO_RULES = st.builds(RulesSection, poa=RULES, pps=RULES, pr=RULES, filters=MANY_RULES, observers=MANY_RULES)
SCENARIOS = st.builds(
    Scenario,
    rules=TWO_RULES | st.builds(RulesSection, poa_pps=RULES),
    seed=st.integers(0, 2**63 - 1),
    instance=INSTANCES,
    layout=st.builds(LayoutSection, block_rows=st.integers(1, 1000), pod_fill=st.floats(0.01, 1))
    | st.builds(LayoutSection, pod_fill=st.floats(0.01, 1), map_file=TEXTS),
    robots=st.builds(RobotsSection, count=COUNTS, top_speed_m_per_s=st.floats(0.001, 1000)),
    stations=st.builds(StationsSection, item_capacity=CAPACITIES, order_capacity=st.none() | CAPACITIES),
    run=st.builds(RunSection, until_s=st.none() | TIMES),
)


@settings(deadline=None)
@given(SCENARIOS, st.booleans())
def test_toml_reads_back_as_an_equal_scenario(scenario: Scenario, comments: bool) -> None:
    """Whatever is in a scenario survives being written and read, with and without comments."""
    assert scenario_from_dict(tomllib.loads(to_toml(scenario, comments=comments))) == scenario


@settings(deadline=None)
@given(SCENARIOS)
def test_tables_read_back_as_an_equal_scenario(scenario: Scenario) -> None:
    """The plain tables that go into a result's JSON do so too."""
    assert scenario_from_dict(json.loads(json.dumps(scenario_to_dict(scenario)))) == scenario


@pytest.mark.parametrize("name", shipped_scenarios())
def test_shipped_scenarios_read_back(name: str) -> None:
    """The resolved form of a shipped scenario is that scenario."""
    scenario = load_scenario(name)
    assert scenario_from_dict(tomllib.loads(to_toml(scenario))) == scenario


def test_every_key_is_written_with_its_meaning_and_unit() -> None:
    """Defaults are spelt out, keys without value left out, and a comment says what a key means."""
    text = to_toml(load_scenario("paper-250"))
    assert "# Time of picking a unit: holds the picker, the pod and its robot (s)\npick_s = 7.0\n" in text
    assert "hall_width = 5\n" in text
    assert "until_s" not in text


def test_rules_are_written_as_short_as_they_can_be() -> None:
    """A rule without parameters is its name."""
    tables: dict[str, Any] = scenario_to_dict(load_scenario("paper-250", ["rules.poa.x=1"]))
    assert tables["rules"]["poa"] == {"rule": "pod-match", "x": 1}
    assert tables["rules"]["pps"] == "demand"
