"""Which code counts for a run, and which does not."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rmfs_commands.experiments.sources import changed_since, sources_of, sources_of_generator
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import Scenario, load_scenario

RULE = """
import {imported}
from attrs import define
from rmfs_core import hookimpl

@define
class Mine:
    @hookimpl
    def choose_storage_location(self, warehouse):
        return min(warehouse.free_storage_locations)
"""


def sources(scenario: Scenario) -> dict[str, str]:
    """Return the digests of what takes part in a scenario's runs."""
    return sources_of(RuleSet.load(scenario.rules, scenario.folder), scenario)


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a folder on the import path: a distribution with a rule, in a package that imports two others."""
    path = tmp_path / "path"
    (path / "thing-1.0.dist-info").mkdir(parents=True)
    (path / "thing-1.0.dist-info" / "METADATA").write_text("Metadata-Version: 2.1\nName: thing\nVersion: 1.0\n")
    (path / "thing-1.0.dist-info" / "entry_points.txt").write_text(
        "[rmfs.rules]\nthing = spaces.thing_rules.rule:Mine\n"
    )
    for folder in ("spaces/thing_rules/deep", "thing_tools", "thing_other"):
        (path / folder).mkdir(parents=True)
    (path / "spaces" / "thing_rules" / "__init__.py").write_text("import json, thing_tools as tools\n")
    (path / "spaces" / "thing_rules" / "rule.py").write_text(RULE.format(imported="attrs"))
    (path / "spaces" / "thing_rules" / "deep" / "table.csv").write_text("1\n")
    (path / "thing_tools" / "__init__.py").write_text("def f():\n    from thing_single import one\n")
    (path / "thing_single.py").write_text("one = 1\n")
    (path / "thing_other" / "__init__.py").write_text("two = 2\n")
    monkeypatch.syspath_prepend(path)
    yield path
    for name in [name for name in sys.modules if name.startswith(("thing_", "spaces"))]:
        del sys.modules[name]


def test_what_the_selected_rules_import_counts(path: Path, folder: Path) -> None:
    """The kernel, rules and observers of every run, and what they import from anywhere but installed libraries."""
    found = sources(load_scenario(folder / "tiny.toml", ["rules.pr=thing"]))
    assert {"rmfs_core", "rmfs_rules.helpers", "rmfs_commands.details", "rmfs_commands.instances"} <= found.keys()
    assert {"rmfs_rules.pod_match", "rmfs_rules.demand"} <= found.keys()
    assert {"spaces.thing_rules", "thing_tools", "thing_single"} <= found.keys()
    assert found.keys().isdisjoint(
        {"thing_other", "attrs", "json", "numpy", "rmfs_rules.sipp", "rmfs_commands.testing"}
    )
    assert all(digest.startswith("sha256:") for digest in found.values())


@pytest.mark.parametrize(
    ("file", "package"),
    [
        ("spaces/thing_rules/rule.py", "spaces.thing_rules"),
        ("spaces/thing_rules/deep/table.csv", "spaces.thing_rules"),
        ("spaces/thing_rules/deep/new.py", "spaces.thing_rules"),
        ("thing_tools/__init__.py", "thing_tools"),
        ("thing_single.py", "thing_single"),
        ("thing_other/__init__.py", None),
        ("spaces/thing_rules/__pycache__/rule.cpython-311.pyc", None),
        ("spaces/thing_rules/.rule.py.swp", None),
    ],
)
def test_a_changed_file_changes_its_package_alone(path: Path, folder: Path, file: str, package: str | None) -> None:
    """Also data, and files that are new; what is compiled or hidden is no source."""
    scenario = load_scenario(folder / "tiny.toml", ["rules.pr=thing"])
    before = sources(scenario)
    (path / file).parent.mkdir(exist_ok=True)
    with (path / file).open("a", encoding="utf-8") as stream:
        stream.write("\n")
    after = sources(scenario)
    assert {name for name in after if after[name] != before[name]} == ({package} if package else set())
    assert after.keys() == before.keys()


def test_a_rule_that_another_asks_counts(path: Path, folder: Path) -> None:
    """As if the scenario named it: with what its distribution imports."""
    cases = '[{ rule = "thing", before_s = 9 }, { rule = "nearest" }]'
    found = sources(load_scenario(folder / "tiny.toml", ["rules.pr=switch", f"rules.pr.cases={cases}"]))
    assert {
        "rmfs_rules.switch",
        "rmfs_rules.nearest",
        "spaces.thing_rules",
        "thing_tools",
        "thing_single",
    } <= found.keys()


def test_the_selected_generator_counts_alone(install: Callable[..., None], folder: Path) -> None:
    """Another one that is installed changes nothing; with orders from a file there is none."""
    before = sources(load_scenario(folder / "tiny.toml"))
    modules = {"acme_days": "import acme_tools\ndef days(): ...\n", "acme_tools": "x = 1\n"}
    install("acme", {"acme-days": "acme_days:days"}, "rmfs.instances", **modules)
    assert sources(load_scenario(folder / "tiny.toml")) == before
    chosen = load_scenario(folder / "tiny.toml", ["instance.generator=acme-days"])
    assert sources(chosen).keys() - before.keys() == {"acme_days", "acme_tools"}
    assert before.keys() - sources(chosen).keys() == {"rmfs_commands.instances"}
    assert sources_of_generator(chosen).keys() == {"acme_days", "acme_tools", "rmfs_core"}
    assert sources_of_generator(load_scenario("examples/from-csv")) == {}
    assert "rmfs_commands.instances" not in sources(load_scenario("examples/from-csv"))


def test_what_the_file_of_a_rule_imports_counts(path: Path, folder: Path) -> None:
    """The file itself is known by its digest among the versions."""
    (folder / "mine.py").write_text(RULE.format(imported="thing_other"), encoding="utf-8")
    found = sources(load_scenario(folder / "tiny.toml", [f"rules.pr={folder}/mine.py:Mine"]))
    assert "thing_other" in found


def test_a_process_has_the_code_it_has_imported(path: Path) -> None:
    """A worker that has computed runs before does not take a newer file for what it runs."""
    assert changed_since({"thing_single": "sha256:0"}) == ["thing_single"]
    (path / "thing_tools" / "__init__.py").write_text("three = 3\n")
    scenario = load_scenario("examples/small")
    rules = RuleSet.load(scenario.rules, scenario.folder)
    assert changed_since(sources_of(rules, scenario)) == []
