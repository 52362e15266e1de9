"""How a rule's name becomes a rule: of a distribution, or from a file beside the scenario."""

from __future__ import annotations

import gc
import inspect
import pickle
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import get_type_hints

import pytest

import rmfs_core
from rmfs_core import InputError, RunError
from rmfs_core.rules import RuleSet
from rmfs_core.rules.sources import RuleSources, source_of
from rmfs_core.scenario.model import RuleChoice, RulesSection

Install = Callable[..., None]
Refusal = Callable[..., str]

SOURCE = """
from __future__ import annotations
from attrs import define
from rmfs_core import hookimpl

@define
class MyRule:
    answer: str = "mine"

    @hookimpl
    def assign_orders(self, warehouse):
        return [self.answer]

    @hookimpl
    def select_pods(self, warehouse):
        return [self.answer]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a scenario's folder with a rule in it."""
    scenario = tmp_path / "scenario"
    (scenario / "rules").mkdir(parents=True)
    for file in ("my_rule.py", "rules/other.py", "../outside.py"):
        (scenario / file).write_text(SOURCE)
    return scenario


def load(folder: Path, poa: str, *, pps: str = "demand", allow_inline: bool = True) -> RuleSet:
    """Load a rule set with this rule for POA."""
    return RuleSet.load(RulesSection(poa=RuleChoice(poa), pps=RuleChoice(pps)), str(folder), allow_inline=allow_inline)


def test_a_rule_from_a_file_decides(folder: Path) -> None:
    """It is bound, named and reported, and nothing is left behind in the folder."""
    loaded = load(folder, "./my_rule.py:MyRule")
    assert loaded.poa is not None
    assert loaded.poa.hook(warehouse=None, rng=None) == ["mine"]
    assert loaded.poa.describe() == 'rule "./my_rule.py:MyRule" (my_rule.py inline)'
    assert loaded.inline_files == (str(folder / "my_rule.py"),)
    assert "my_rule.py" not in loaded.distributions
    assert sorted(file.name for file in folder.iterdir()) == ["my_rule.py", "rules"]


def test_a_file_is_loaded_once_per_rule_set_and_anew_for_the_next(folder: Path) -> None:
    """Two roles share the module; an edited file counts in the next run."""
    first = load(folder, "rules/other.py:MyRule", pps="./my_rule.py:MyRule")
    assert first.inline_files == (str(folder / "rules" / "other.py"), str(folder / "my_rule.py"))
    (folder / "my_rule.py").write_text(SOURCE.replace("mine", "edited"))
    second = load(folder, "./my_rule.py:MyRule", pps="./my_rule.py:MyRule")
    assert second.poa is not None
    assert second.pps is not None
    assert second.poa.instance is second.pps.instance
    assert second.poa.hook(warehouse=None, rng=None) == ["edited"]
    assert second.inline_files == (str(folder / "my_rule.py"),)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("./my_rule.py", 'expected "./file.py:Class" for a rule beside the scenario, found "./my_rule.py"'),
        ("./my_rule:MyRule", 'expected "./file.py:Class" for a rule beside the scenario, found "./my_rule:MyRule"'),
        ("./my_rule.py:MyRle", "{folder}/my_rule.py has no class `MyRle` (did you mean `MyRule`?)"),
        ("./none.py:MyRule", 'rule "./none.py:MyRule": cannot read {folder}/none.py: No such file or directory'),
        (
            "../outside.py:MyRule",
            'rule "../outside.py:MyRule" is outside {folder}; move its file there',
        ),
        ("/none.py:MyRule", 'rule "/none.py:MyRule": cannot read /none.py: No such file or directory'),
    ],
)
def test_refused_names(folder: Path, name: str, message: str) -> None:
    """Each says what would be right."""
    with pytest.raises(InputError) as caught:
        load(folder, name)
    assert str(caught.value) == f"rules.poa: {message.format(folder=folder)}"


def test_an_absolute_path_leads_out_of_the_folder(folder: Path) -> None:
    """What a scenario that was changed on the command line names is that file, wherever the scenario is."""
    loaded = load(folder, f"{folder.parent}/outside.py:MyRule")
    assert loaded.inline_files == (str(folder.parent / "outside.py"),)


def test_a_file_that_cannot_be_loaded(folder: Path) -> None:
    """The file and the cause are named."""
    (folder / "my_rule.py").write_text("raise ValueError('no luck')\n")
    with pytest.raises(InputError) as caught:
        load(folder, "./my_rule.py:MyRule")
    assert str(caught.value) == (
        f'rules.poa: rule "./my_rule.py:MyRule": {folder}/my_rule.py cannot be loaded: ValueError: no luck'
    )


def test_no_inline_rules(folder: Path) -> None:
    """With --no-inline-rules the file is not even opened."""
    (folder / "my_rule.py").write_text("raise SystemExit('was run')")
    with pytest.raises(InputError) as caught:
        load(folder, "./my_rule.py:MyRule", allow_inline=False)
    assert str(caught.value) == (
        'rules.poa: rule "./my_rule.py:MyRule" would load code from a file, which --no-inline-rules refuses'
    )


def test_unknown_rule(refusal: Refusal) -> None:
    """The nearest names are offered, or all."""
    assert refusal(poa=RuleChoice("pod-mach")) == ('rules.poa: there is no rule "pod-mach" (did you mean `pod-match`?)')
    assert refusal(pr=RuleChoice("xyzzy")).startswith(
        'rules.pr: there is no rule "xyzzy"; expected one of `all`, `alternating`, `assignment`, '
    )
    assert refusal(filters=(RuleChoice("xyzzy"),)).startswith("rules.filters[0]: ")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("source", "target", "cause"),
    [
        ("import acme_nowhere", "Mine", "ModuleNotFoundError: No module named 'acme_nowhere'"),
        ("x = 1", "Mine", "AttributeError: module 'acme_rules' has no attribute 'Mine'"),
        ("x = = 1", "Mine", "SyntaxError: invalid syntax (acme_rules.py, line 3)"),
        ("raise SystemExit(4)", "Mine", "SystemExit: 4"),
    ],
)
def test_module_that_cannot_be_imported(
    refusal: Refusal, install: Install, source: str, target: str, cause: str
) -> None:
    """Rule, distribution and cause are named, whatever the module did."""
    install("acme", {"mine": f"acme_rules:{target}"}, acme_rules=source)
    assert refusal(poa=RuleChoice("mine")) == (
        f'rules.poa: rule "mine" (acme 1.0) cannot be imported from acme_rules:Mine: {cause}'
    )


def test_two_distributions_with_one_name_clash_only_when_it_is_selected(refusal: Refusal, install: Install) -> None:
    """Both are named; a scenario that does not use the name runs."""
    install("acme", {"mine": "acme_rules:MyRule"}, acme_rules="")
    install("bolt", {"mine": "bolt_rules:MyRule"}, bolt_rules="")
    assert refusal(poa=RuleChoice("mine")) == (
        'rules.poa: rule "mine" is offered by acme 1.0 and bolt 1.0; expected one of them: `acme:mine` or `bolt:mine`'
    )
    RuleSet.load(RulesSection(poa=RuleChoice("pod-match"), pps=RuleChoice("demand")), ".")
    assert 'rule "mine" (bolt 1.0) cannot be imported' in refusal(poa=RuleChoice("bolt:mine"))


def test_a_module_that_makes_names_up(refusal: Refusal, tmp_path: Path) -> None:
    """What is not there is not asked for."""
    (tmp_path / "mine.py").write_text("def __getattr__(name):\n    raise RuntimeError(name)\n", encoding="utf-8")
    assert refusal(tmp_path, poa=RuleChoice("./mine.py:Mine")).endswith("mine.py has no class `Mine`")


def test_a_file_that_cannot_be_read_is_named(folder: Path) -> None:
    """One that is not there, and one under a name that no file can have."""
    for name, reason in (("./none.py:A", "No such file or directory"), ("./a\0b.py:A", "embedded null byte")):
        rules = RulesSection(poa=RuleChoice(name), pps=RuleChoice("demand"))
        with pytest.raises(InputError, match=f"cannot read .*: {reason}$"):
            RuleSet.load(rules, str(folder))


def test_an_object_of_an_installed_rule_is_named_as_in_a_scenario(install: Install) -> None:
    """However deep in the distribution its class is defined; a namesake of another package is itself."""
    source = "@define\nclass Mine:\n    @hookimpl\n    def assign_orders(self, warehouse):\n        return []\n"
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules="from acme_deep import Mine\n", acme_deep=source)
    import_module("acme_rules")
    deep = import_module("acme_deep").Mine()
    assert source_of(deep).describe() == 'rule "Mine" (acme_deep object)'
    install("other", {"theirs": "other_rules:Mine"}, other_rules=source)
    assert source_of(import_module("other_rules").Mine()).describe() == 'rule "theirs" (other 1.0)'
    assert source_of(import_module("rmfs_rules.sipp").Sipp()).describe().startswith('rule "sipp" (rmfs ')


KNOWING = """
from __future__ import annotations
import inspect
import pickle
import typing
from dataclasses import dataclass

from attrs import define
from rmfs_core import OrderAssignment, hookimpl

@define
class Level:
    least: Number

@define
class Mine:
    level: Level

    @hookimpl
    def assign_orders(self, warehouse):
        @dataclass
        class Late:
            level: Level
        assert isinstance(self.level, Level)
        assert typing.get_type_hints(Mine) == {"level": Level}
        assert "Number" in inspect.getsource(Level)
        assert pickle.loads(pickle.dumps(self)) == self
        order = warehouse.backlog[0]
        station = next(one for one in warehouse.stations if warehouse.fits(order, one))
        return [OrderAssignment(order.id, station.id)][: self.level.least]
"""


def modules_of_files() -> set[str]:
    """Return the names of the modules that files of rules were loaded as."""
    return {name for name in sys.modules if name.startswith("rmfs_inline_")}


def scenario_in(folder: Path, number: str, least: str) -> Path:
    """Write a scenario with a rule of a file, whose parameter has a type of that file; return the scenario's file."""
    folder.mkdir()
    (folder / "mine.py").write_text(f"{KNOWING}\nNumber = {number}\n")
    (folder / "it.toml").write_text(
        '[instance]\norders = 5\n[rules]\npps = "demand"\n'
        f'poa = {{ rule = "./mine.py:Mine", level = {{ least = {least} }} }}\n'
    )
    return folder / "it.toml"


def test_a_run_leaves_no_module_behind(tmp_path: Path) -> None:
    """While it is there typing, inspect and pickle find it; then it is gone, also after a run that failed."""
    before = modules_of_files()
    assert rmfs_core.run(scenario_in(tmp_path / "right", "int", "1")).status == "complete"
    assert modules_of_files() == before
    with pytest.raises(RunError, match="slice indices must be integers"):
        rmfs_core.run(scenario_in(tmp_path / "failing", "str", '"x"'))
    assert modules_of_files() == before
    with pytest.raises(InputError, match="expected Level"):
        rmfs_core.run(scenario_in(tmp_path / "refused", "int", '"x"'))
    assert modules_of_files() == before
    with pytest.raises(InputError, match=r"instance\.orders_file"):
        rmfs_core.run(scenario_in(tmp_path / "lacking", "int", "1"), overrides=["instance.orders_file=none.csv"])
    assert modules_of_files() == before


@pytest.mark.parametrize("source", ["raise ValueError", "raise KeyboardInterrupt"])
def test_a_file_that_cannot_be_loaded_leaves_no_module_behind(folder: Path, source: str) -> None:
    """Whatever stopped it."""
    before = modules_of_files()
    (folder / "my_rule.py").write_text(source)
    with pytest.raises((InputError, KeyboardInterrupt)):
        load(folder, "./my_rule.py:MyRule")
    assert modules_of_files() == before


def test_two_scenarios_do_not_see_each_others_file(tmp_path: Path) -> None:
    """Files of one name, and one file that was edited between two rule sets: each class has the types of its own."""
    whole, text = (scenario_in(tmp_path / name, name, "1").parent for name in ("int", "str"))
    sources = [RuleSources(str(folder)) for folder in (whole, text, whole)]
    first = sources[0].find("./mine.py:Mine", "place").target
    other = sources[1].find("./mine.py:Mine", "place").target
    (whole / "mine.py").write_text((text / "mine.py").read_text())
    edited = sources[2].find("./mine.py:Mine", "place").target
    levels = [inspect.getmodule(rule).Level for rule in (first, other, edited)]  # type: ignore[arg-type, union-attr]
    assert [get_type_hints(level)["least"] for level in levels] == [int, str, str]
    assert [pickle.loads(pickle.dumps(level)) for level in levels] == levels


def test_a_module_stays_as_long_as_its_rule(folder: Path) -> None:
    """Who has a rule without a run need not close anything."""
    before = modules_of_files()
    source = RuleSources(str(folder)).find("./my_rule.py:MyRule", "place")
    assert len(modules_of_files() - before) == 1
    del source
    gc.collect()
    assert modules_of_files() == before
