"""Scenario keys as an experiment file writes them."""

from __future__ import annotations

import pytest

from rmfs_commands.experiments.changes import changes_of
from rmfs_core.scenario.structuring import KeyProblem


@pytest.mark.parametrize(
    ("table", "changes"),
    [
        ({}, {}),
        ({"robots": {"count": 4}}, {"robots.count": 4}),
        ({"robots.count": 4}, {"robots.count": 4}),
        (
            {"instance": {"orders": 5, "arrivals.process": "poisson"}},
            {"instance.orders": 5, "instance.arrivals.process": "poisson"},
        ),
        ({"rules": {"poa": "first-come", "filters": ["a"]}}, {"rules.poa": "first-come", "rules.filters": ["a"]}),
        (
            {"rules": {"ta": {"rule": "balanced", "reallocation_s": 5}}},
            {"rules.ta": {"rule": "balanced", "reallocation_s": 5}},
        ),
        ({"rules.ta.reallocation_s": 5}, {"rules.ta.reallocation_s": 5}),
        ({"rules": {"ta": {"reallocation_s": 5}}}, {"rules.ta.reallocation_s": 5}),
        ({"rules": {"poa_pps": None}}, {"rules.poa_pps": None}),
    ],
)
def test_nested_and_dotted_keys_are_the_same(table: dict[str, object], changes: dict[str, object]) -> None:
    """A rule with parameters is one value; parameters alone are keys below their rule, whatever they are called."""
    assert changes_of(table) == changes


@pytest.mark.parametrize(
    ("table", "problem", "path"),
    [
        ({"robot.count": 4}, "unknown key (did you mean `robots`?)", ("robot",)),
        ({"robots": {"cont": 4}}, "unknown key (did you mean `count`?)", ("robots", "cont")),
        ({"seed": 4}, "unknown key", ("seed",)),
        ({"robots.count": 4, "robots": {"count": 5}}, "is there twice", ("robots", "count")),
    ],
)
def test_a_key_that_no_scenario_has_is_named(table: dict[str, object], problem: str, path: tuple[str, ...]) -> None:
    """With its path; seeds are the experiment's own, and a key is set once."""
    with pytest.raises(KeyProblem) as caught:
        changes_of(table)
    assert caught.value.problem.startswith(problem)
    assert caught.value.path == path
