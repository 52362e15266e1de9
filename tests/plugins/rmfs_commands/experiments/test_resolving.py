"""Scenarios of runs: a base, what axes and rule sets change, and where files are looked up."""

import tomllib
from pathlib import Path

import pytest
from attrs import evolve

from rmfs_commands.experiments.resolving import resolve
from rmfs_core.errors import InputError
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import Scenario, load_scenario, scenario_from_dict


@pytest.fixture
def tiny(folder: Path) -> Scenario:
    """Return the tiny scenario."""
    return load_scenario(folder / "tiny.toml")


def test_joint_rules_take_the_place_of_separate_ones(tiny: Scenario) -> None:
    """A joint rule takes POA and PPS out; naming these again takes the joint rule out."""
    joint = resolve(tiny, {"rules.poa_pps": "integrated"}, ".", "test")
    assert (joint.rules.poa, joint.rules.pps) == (None, None)
    back = resolve(joint, {"rules.poa": "first-come", "rules.pps.rule": "demand"}, ".", "test")
    assert back.rules.poa_pps is None


def test_single_parameters_of_the_bases_rule_can_be_set(tiny: Scenario) -> None:
    """A key below a rule keeps the rule; the rule's name keeps no parameter."""
    one = resolve(tiny, {"rules.ta": {"rule": "balanced", "reallocation_s": 5.0, "help_others": False}}, ".", "test")
    two = resolve(one, {"rules.ta.reallocation_s": 7.0}, ".", "test")
    assert dict(two.rules.ta.parameters) == {"reallocation_s": 7.0, "help_others": False}
    assert not resolve(two, {"rules.ta": "balanced"}, ".", "test").rules.ta.parameters


def test_rules_beside_the_experiment_work_with_a_scenario_elsewhere(folder: Path) -> None:
    """A file that the experiment names is looked up in the experiment's folder."""
    shipped = load_scenario("examples/small")
    resolved = resolve(shipped, {"rules.pr": "./bad.py:Raising"}, str(folder), "test")
    assert resolved.folder == str(folder)


def test_files_in_two_folders_are_refused(folder: Path) -> None:
    """A scenario has one folder: orders of a shipped one and a rule beside the experiment do not go together."""
    shipped = load_scenario("examples/from-csv")
    with pytest.raises(InputError, match=r"names files in .* and in "):
        resolve(shipped, {"rules.pr": "./bad.py:Raising"}, str(folder), "test")


def test_keys_that_would_be_ignored_are_refused() -> None:
    """The number of orders to generate has no meaning beside a file of orders."""
    with pytest.raises(InputError, match=r"instance.orders: has no meaning beside `instance.orders_file`"):
        resolve(load_scenario("examples/from-csv"), {"instance.orders": 3}, ".", "test")


def test_files_of_parameters_are_where_they_are_named(folder: Path) -> None:
    """Those of the base beside it, though the scenario's folder is another one; what changes name beside these."""
    (folder / "base").mkdir()
    (folder / "w.txt").write_text("2", encoding="utf-8")
    data = tomllib.loads((folder / "tiny.toml").read_text("utf-8"))
    data["rules"]["observers"] = [{"rule": "seen", "file": "w.txt"}]
    base = scenario_from_dict(data, str(folder / "base"))
    reading = {"rules.pr": {"rule": "./bad.py:Reading", "weights": "w.txt"}}
    scenario = resolve(base, reading, str(folder), "test")
    assert scenario.folder == str(folder)
    assert scenario.rules.observers[0].parameters["file"].there == str(folder / "base")
    loaded = RuleSet.load(evolve(scenario.rules, observers=()), scenario.folder)
    assert [(one.name, one.file) for one in loaded.files] == [("w.txt", folder / "w.txt")]
