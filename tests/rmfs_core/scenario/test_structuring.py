"""Tables to classes: values as they are written, and the path to what is wrong."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from attrs import define

from rmfs_core.scenario.model import (
    Arrivals,
    InstanceSection,
    RobotsSection,
    RuleChoice,
    RulesSection,
    Scenario,
    StationsSection,
    key,
)
from rmfs_core.scenario.structuring import (
    KeyProblem,
    fields_of,
    section_class,
    strict_converter,
    structure,
    structure_as,
)

RULES = {"poa": "pod-match", "pps": "demand"}


def test_a_scenario_is_made_from_tables() -> None:
    """Lists become tuples, whole numbers numbers, names of rules choices; what is left out has its default."""
    scenario = structure(
        {
            "seed": 3,
            "robots": {"lift_s": 2},
            "stations": {"item_capacity": [2, 3]},
            "rules": {"poa": {"rule": "mine", "weight": 2, "deep": {"a": [1]}}, "pps": "demand", "filters": ["x"]},
        }
    )
    assert scenario == Scenario(
        seed=3,
        robots=RobotsSection(lift_s=2.0),
        stations=StationsSection(item_capacity=(2, 3)),
        rules=RulesSection(
            poa=RuleChoice("mine", {"weight": 2, "deep": {"a": [1]}}),
            pps=RuleChoice("demand"),
            filters=(RuleChoice("x"),),
        ),
    )
    assert isinstance(scenario.robots.lift_s, float)


@pytest.mark.parametrize(
    ("data", "path", "problem"),
    [
        ({"rules": RULES, "sed": 1}, ("sed",), "unknown key (did you mean `seed`?)"),
        ({"rules": RULES, "folder": "x"}, ("folder",), "unknown key; expected one of "),  # no key of the file
        ({"rules": RULES, "seed": True}, ("seed",), "expected a whole number, found true"),
        ({"rules": RULES, "seed": None}, ("seed",), "expected a whole number, found null"),
        (
            {"rules": RULES, "robots": {"lift_s": float("nan")}},
            ("robots", "lift_s"),
            "expected a finite number, found nan",
        ),
        ({"rules": RULES, "robots": {"lift_s": True}}, ("robots", "lift_s"), "expected a number, found true"),
        ({"rules": RULES, "robots": []}, ("robots",), "expected a table, found []"),
        (
            {"rules": RULES, "stations": {"item_capacity": [1, "2"]}},
            ("stations", "item_capacity", 1),
            'expected a whole number, found "2"',
        ),
        (
            {"rules": RULES, "instance": {"pods_at_stations": {"1": ["a", 2]}}},
            ("instance", "pods_at_stations", "1", 1),
            "expected a text in quotes, found 2",
        ),
        (
            {"rules": RULES, "instance": {"arrivals": {"process": "poisson"}}},
            ("instance", "arrivals"),
            'expected `orders_per_hour` with process "poisson", and only there',
        ),
        ({"rules": {**RULES, "filters": ["a", {}]}}, ("rules", "filters", 1), "expected a key `rule` with the name"),
        ({"rules": {**RULES, "pr": ""}}, ("rules", "pr"), "expected the name of a rule or a table"),
        ({"rules": {**RULES, "pr": {"rule": 3}}}, ("rules", "pr", "rule"), "expected a text in quotes, found 3"),
        ({}, ("rules",), "this part is missing"),
        # the first in the order of the file, whatever the order of the class
        ({"robots": {"lift_s": -1}, "seed": -1, "rules": {}}, ("robots", "lift_s"), "expected a number from 0"),
        ({"seed": -1, "robots": {"lift_s": -1}, "rules": {}}, ("seed",), "expected a whole number >= 0, found -1"),
    ],
)
def test_what_is_wrong_has_its_path(data: dict[str, Any], path: tuple[str | int, ...], problem: str) -> None:
    """The path leads through tables and lists to the value."""
    with pytest.raises(KeyProblem) as caught:
        structure(data)
    assert caught.value.path == path
    assert caught.value.problem.startswith(problem)


def test_a_problem_can_be_seen_from_one_level_up() -> None:
    """Whoever structures a part says where the part is."""
    seen = KeyProblem("wrong", ("count",)).under("robots").under(2)
    assert (seen.problem, seen.path) == ("wrong", (2, "robots", "count"))


def test_any_class_with_documented_keys_is_structured_alike() -> None:
    """Experiment files and state files are read by the same converter."""

    @define
    class Shelf:
        width: int = key("Width")
        arrivals: Arrivals = key("Arrivals", factory=Arrivals)  # noqa: RUF009 - as in the sections

    assert structure_as(Shelf, {"width": 3}) == Shelf(3, Arrivals())
    with pytest.raises(KeyProblem) as caught:
        structure_as(Shelf, {"width": 3, "arrivals": {"process": "strat"}})
    assert caught.value.path == ("arrivals", "process")


def test_what_a_section_holds_is_known() -> None:
    """A table's class for a table, None for a value."""
    assert section_class(Scenario, "robots") is RobotsSection
    assert section_class(InstanceSection, "arrivals") is Arrivals
    assert section_class(RulesSection, "poa") is RuleChoice
    assert section_class(Scenario, "seed") is None
    assert section_class(InstanceSection, "pods_at_stations") is None
    assert {"folder", "source"}.isdisjoint(fields_of(Scenario))
    assert list(fields_of(Arrivals)) == ["process", "orders_per_hour", "profile", "backlog"]


STRICT = strict_converter()


@pytest.mark.parametrize(
    ("kind", "value", "expected"),
    [
        (int, 3, 3),
        (float, 3, 3.0),
        (float | None, None, None),
        (int | tuple[int, ...], [1, 2], (1, 2)),
        (int | str, "3", "3"),
        (str | int, 3, 3),
        (float | int, 3, 3),  # as it is written, not what comes first
        (tuple[int, str], [1, "a"], (1, "a")),
        (list[tuple[int, ...]], [[1], []], [(1,), ()]),
        (Mapping[str, int | None], {"a": None}, {"a": None}),
    ],
)
def test_values_are_taken_as_they_are_written(kind: Any, value: object, expected: object) -> None:
    """Only a whole number for a number, and a list for a tuple, are made what the type says."""
    found = STRICT.structure(value, kind)
    assert found == expected
    assert type(found) is type(expected)


@pytest.mark.parametrize(
    ("kind", "value", "problem"),
    [
        (int, "3", 'expected a whole number, found "3"'),
        (int, 3.0, "expected a whole number, found 3.0"),
        (bool, 1, "expected true or false, found 1"),
        (str, 1, "expected a text in quotes, found 1"),
        (float | None, "x", 'expected a number, found "x"'),
        (int | tuple[int, ...], ["x"], 'expected a whole number, found "x"'),
        (tuple[int, ...], {"a": 1}, "expected a list, found { a = 1 }"),
        (Mapping[str, int], [], "expected a table, found []"),
    ],
)
def test_nothing_is_converted_in_silence(kind: Any, value: object, problem: str) -> None:
    """A text is no number, and 1 is not true."""
    with pytest.raises(KeyProblem) as caught:
        STRICT.structure(value, kind)
    assert caught.value.problem == problem
