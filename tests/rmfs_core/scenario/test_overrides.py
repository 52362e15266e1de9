"""`--set`: values from the command line."""

from __future__ import annotations

import pytest

from rmfs_core.errors import InputError
from rmfs_core.scenario import RuleChoice, load_scenario

WRONG = [
    # no equals sign
    (["seed"], "--set seed: expected key=value, such as instance.orders=50"),
    # no key
    (["=3"], "--set =3: expected key=value, such as instance.orders=50"),
    # an empty part of a key
    (["instance..orders=3"], "--set instance..orders=3: expected key=value, such as instance.orders=50"),
    # a misspelt key
    (["robots.cuont=3"], "--set robots.cuont=3: unknown key; did you mean `count`?"),
    # a wrong type, a value out of range
    (["robots.count=many"], '--set robots.count=many: expected a whole number, found "many"'),
    (["robots.count=0"], "--set robots.count=0: expected a whole number >= 1, found 0"),
    # a whole table, wrong inside
    (["robots={count=0}"], "--set robots={count=0}, robots.count: expected a whole number >= 1, found 0"),
    # a key below a value
    (["seed.x=2"], "--set seed.x=2: `seed` has no keys of its own, it is 1"),
    # an unknown rule
    (["rules.poa=pod-mach"], "--set rules.poa=pod-mach: there is no rule `pod-mach`; did you mean `pod-match`?"),
    # the wrong one of two is the last
    (["robots.count=2", "robots.count=0"], "--set robots.count=0: expected a whole number >= 1, found 0"),
    # taking out a key that no scenario has
    (["robots.cuont="], "--set robots.cuont=: unknown key `cuont`; did you mean `count`?"),
    # values that do not go together
    (["rules.pps="], "--set rules.pps=, rules: expected `poa` and `pps`, or `poa_pps`"),
    # a line break does not smuggle a second key in
    (["seed=1\nx=2"], '--set seed=1\nx=2: expected a whole number, found "1\\nx=2"'),
]


@pytest.mark.parametrize(("overrides", "message"), WRONG)
def test_a_wrong_override_is_one_sentence(overrides: list[str], message: str) -> None:
    """A mistake in an override is named like one in a file, with the override as its place."""
    with pytest.raises(InputError) as caught:
        load_scenario("paper-250", overrides)
    assert str(caught.value) == message


def test_values_are_toml_or_plain_text() -> None:
    """Numbers, lists and texts with or without quotes are understood."""
    scenario = load_scenario(
        "paper-250",
        [
            "instance.orders=50",
            "stations.item_capacity=[1, 2, 3, 4]",
            "rules.poa=first-come",
            'rules.pps="nearest-pod"',
        ],
    )
    assert scenario.instance.orders == 50
    assert scenario.stations.item_capacity == (1, 2, 3, 4)
    assert scenario.rules.poa == RuleChoice("first-come")
    assert scenario.rules.pps == RuleChoice("nearest-pod")


def test_a_parameter_is_added_to_a_rule_given_by_name() -> None:
    """`rules.poa.x=1` keeps the rule of `poa = "pod-match"`; `rules.poa.rule=...` keeps parameters."""
    scenario = load_scenario("paper-250", ["rules.poa.x=1", "rules.pps.y=2", "rules.pps.rule=nearest-pod"])
    assert scenario.rules.poa == RuleChoice("pod-match", {"x": 1})
    assert scenario.rules.pps == RuleChoice("nearest-pod", {"y": 2})


def test_an_empty_value_takes_a_key_out() -> None:
    """Two rules make room for a joint one; a key that is not there may be taken out as well."""
    scenario = load_scenario("paper-250", ["rules.poa=", "rules.pps=", "rules.poa_pps=demand", "run.until_s="])
    assert scenario.rules.poa is None
    assert scenario.rules.poa_pps == RuleChoice("demand")
    assert load_scenario("paper-250", ["robots.count="]).robots.count == 8
    assert load_scenario("examples/poisson", ["instance.arrivals="]).instance.arrivals.process == "start"


def test_sections_that_the_file_lacks_are_made() -> None:
    """An override may set a key of a section that the file does not have."""
    assert load_scenario("examples/small", ["run.until_s=100"]).run.until_s == 100.0
