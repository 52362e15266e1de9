"""Discovery, selection and registration of rules, of a distribution or from a file beside the scenario."""

import gc
import inspect
import pickle
import sys
from collections.abc import Callable
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
import pytest
from attrs import define

import rmfs_core
from cases import cases
from rmfs_commands.testing import small_world
from rmfs_core import InputError, RunError, hookimpl
from rmfs_core.rules import RuleSet, with_objects
from rmfs_core.rules.sources import RuleSources, source_of
from rmfs_core.scenario.model import RuleChoice, RulesSection
from rmfs_core.warehouse import WarehouseView
from saying import said

POA = "    @hookimpl\n    def assign_orders(self, warehouse):\n        return [{answer}]\n"
Install = Callable[..., None]


def rules(**choices: Any) -> RulesSection:
    return RulesSection(**({"poa": RuleChoice("pod-match"), "pps": RuleChoice("demand")} | choices))


def load(**choices: Any) -> RuleSet:
    return RuleSet.load(rules(**choices), ".")


def test_a_rule_set_binds_each_role_to_its_rule() -> None:
    loaded = load(filters=())
    assert loaded.poa is not None
    bound = (loaded.poa, loaded.pps, loaded.pr, loaded.ta, loaded.pp)
    assert [rule.role for rule in bound] == ["poa", "pps", "pr", "ta", "pp"]
    assert [rule.name for rule in bound] == ["pod-match", "demand", "nearest", "balanced", "sipp"]
    assert loaded.pps.describe() == f'rule "demand" (rmfs {version("rmfs")})'
    assert loaded.pps.hook.name == "select_pods"
    assert (loaded.poa_pps, loaded.filters, loaded.observers, loaded.inline_files) == (None, (), (), ())


def test_what_took_part_is_named(install: Install) -> None:
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules="@define\nclass Mine:\n" + POA.format(answer=1))
    found = load(poa=RuleChoice("mine")).distributions
    assert set(found) == {"acme", "attrs", "numba", "numpy", "pluggy", "python", "rmfs", "simpy"}
    assert found["acme"] == "1.0"
    assert found["numpy"] == version("numpy")
    loaded = load(poa=None, pps=None, poa_pps=RuleChoice("integrated"))
    assert {"highspy", "mip"} <= set(loaded.distributions)
    assert "mip" not in load().distributions


def test_instances_are_shared_by_roles_not_by_rule_sets(install: Install) -> None:
    assert load().ta.instance is not load().ta.instance
    install("acme", {"both": "acme_rules:Both"}, acme_rules=BOTH)
    same = load(poa=RuleChoice("both", {"weight": 2}), pps=RuleChoice("both", {"weight": 2}))
    assert same.poa.instance is same.pps.instance
    assert (ask(same.poa), ask(same.pps, max_fetches=3)) == (["orders", 2], ["pods", 3])
    differs = load(poa=RuleChoice("both", {"weight": 2}), pps=RuleChoice("both"))
    assert differs.poa.instance is not differs.pps.instance
    assert ask(differs.poa) == differs.pm.hook.assign_orders(warehouse=None, rng=None) == ["orders", 2]


BOTH = """
@define
class Both:
    weight: int = 1
    @hookimpl
    def assign_orders(self, warehouse): return ["orders", self.weight]
    @hookimpl
    def select_pods(self, warehouse, max_fetches): return ["pods", max_fetches]
"""


def ask(rule: Any, **arguments: Any) -> Any:
    return rule.hook(warehouse=None, rng=None, **arguments)


def test_a_rule_may_observe_the_run_as_well(install: Install) -> None:
    source = "@define\nclass Mine:\n    seen: list = field(init=False, factory=list)\n" + POA.format(answer=1)
    source += "    @hookimpl\n    def on_event(self, event):\n        self.seen.append(event)\n"
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=source)
    loaded = load(poa=RuleChoice("mine"), observers=(RuleChoice("mine"),))
    loaded.pm.hook.on_event(event="tick")
    assert loaded.poa.instance.seen == ["tick"]
    assert loaded.observers[0].instance is loaded.poa.instance


def test_an_observer_object_can_be_registered() -> None:
    @define
    class Watch:
        seen: list[object]

        @hookimpl
        def on_event(self, event: object) -> None:
            self.seen.append(event)

        @hookimpl
        def assign_orders(self) -> list[str]:
            return ["from the observer"]

    loaded = load()
    first, second = Watch([]), Watch([])
    loaded.register_observer(first)
    loaded.register_observer(second)
    loaded.pm.hook.on_event(event=1)
    assert (first.seen, second.seen) == ([1], [1])
    view = WarehouseView(small_world({"o": ["x"]}, {"p": ["x"]}))
    answer = loaded.pm.hook.assign_orders(warehouse=view, rng=np.random.default_rng(1))
    assert [(given.order, given.station) for given in answer] == [(0, 0)]


def test_an_observer_object_is_checked_like_a_rule() -> None:
    class Misspelt:
        @hookimpl
        def on_evnt(self, event: object) -> None: ...

    class Listens:
        hears = ("OrderCompleted",)
        on_event = hookimpl(lambda self, event: None)

    class Watch:
        @hookimpl
        def measured(self, run: object) -> None: ...

    misspelt = r"class Misspelt implements a hook `on_evnt`, .* \(did you mean `on_event`\?\);"
    for observer, problem in (
        (Misspelt(), misspelt),
        (Watch(), "class Watch: hook `measured` has no argument `run`; it has none$"),
        (object(), "it implements no observer hook"),
        (Listens(), r"it has hears = \('OrderCompleted',\); expected a tuple of"),
    ):
        with pytest.raises(InputError, match=f"^observer {type(observer).__name__}: {problem}"):
            load().register_observer(observer)


@define
class Both:
    """A rule for orders and pods that is also told what happens, and leaves orders out."""

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView) -> list[Any]:
        return []

    @hookimpl
    def select_pods(self, warehouse: WarehouseView) -> list[Any]:
        return []

    @hookimpl
    def filter_backlog(self, warehouse: WarehouseView) -> list[int]:
        return []


def test_objects_are_the_rules_themselves() -> None:
    both, one, other = Both(), Both(), Both()
    objects = {"poa": both, "pps": both, "filters": [one, other]}
    loaded = RuleSet.load(with_objects(rules(), objects), ".", objects=objects)
    assert loaded.poa.instance is loaded.pps.instance is both
    assert all(rule.instance is given for rule, given in zip(loaded.filters, (one, other), strict=True))
    assert loaded.distributions["Both"] == f"object of {__name__}"
    paired = rules(pr=RuleChoice("fixed"))
    joint = with_objects(paired, {"poa_pps": Both()})
    assert (joint.poa, joint.pps, joint.poa_pps, joint.pr) == (None, None, RuleChoice("Both"), RuleChoice("fixed"))
    again = with_objects(joint, {"poa": Both(), "pps": Both()})
    assert (again.poa, again.pps, again.poa_pps) == (RuleChoice("Both"), RuleChoice("Both"), None)
    assert with_objects(paired, {}) is paired


@cases(
    "objects message",
    ([Both()], '^argument rules: expected rules by what they decide, such as {"poa": MyRule\\(\\)}, found '),
    (Both(), '^argument rules: .* such as {"poa": MyRule\\(\\)}, found Both\\(\\)'),
    ({"paa": Both()}, "^argument rules: unknown key 'paa' \\(did you mean `poa`"),
    ({"observers": [Both()]}, "^argument rules: unknown key 'observers'"),  # `run` has an argument for these
    ({"poa": Both}, "^argument rules.poa: expected an object of a rule's class, such as MyRule.., found <class"),
    ({"poa": "demand"}, "^argument rules.poa: expected an object .*, found 'demand'$"),
    ({"poa": object()}, '^argument rules.poa: rule "object" .* is no attrs class'),
    ({"pr": Both()}, '^argument rules.pr: rule "Both" .* does not decide PR .*; class Both decides POA, PPS and'),
    ({"filters": Both()}, "^argument rules.filters: expected a list of rules, found Both"),
    ({"filters": [Both(), None]}, r"^argument rules.filters\[1\]: expected an object .*, found None$"),
    ({"poa": Both(), "poa_pps": Both()}, "^argument rules: expected either `poa_pps` or `poa` and `pps`, found"),
)
def test_what_is_no_rule_is_refused_as_in_a_scenario(objects: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        RuleSet.load(with_objects(rules(), objects), ".", objects=objects)


SOURCE = """
from __future__ import annotations
from attrs import define
from rmfs_core import hookimpl
@define
class MyRule:
    answer: str = "mine"
    @hookimpl
    def assign_orders(self, warehouse): return [self.answer]
    @hookimpl
    def select_pods(self, warehouse): return [self.answer]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    scenario = tmp_path / "scenario"
    (scenario / "rules").mkdir(parents=True)
    for file in ("my_rule.py", "rules/other.py", "../outside.py"):
        (scenario / file).write_text(SOURCE)
    return scenario


def load_from(folder: Path, poa: str, *, pps: str = "demand", allow_inline: bool = True) -> RuleSet:
    return RuleSet.load(RulesSection(poa=RuleChoice(poa), pps=RuleChoice(pps)), str(folder), allow_inline=allow_inline)


def test_a_rule_from_a_file(folder: Path) -> None:
    loaded = load_from(folder, "./my_rule.py:MyRule")
    assert loaded.poa.hook(warehouse=None, rng=None) == ["mine"]
    assert loaded.poa.describe() == 'rule "./my_rule.py:MyRule" (my_rule.py inline)'
    assert loaded.inline_files == (str(folder / "my_rule.py"),)
    assert "my_rule.py" not in loaded.distributions
    assert sorted(file.name for file in folder.iterdir()) == ["my_rule.py", "rules"]
    loaded = load_from(folder, f"{folder.parent}/outside.py:MyRule")
    assert loaded.inline_files == (str(folder.parent / "outside.py"),)
    (folder / "my_rule.py").write_text("raise ValueError('no luck')\n")
    assert said(InputError, load_from, folder, "./my_rule.py:MyRule") == (
        f'rules.poa: rule "./my_rule.py:MyRule": {folder}/my_rule.py cannot be loaded: ValueError: no luck'
    )
    (folder / "near.py").touch()
    for source in ("import near", "from near.more import x", "from . import near", "from .near import x"):
        (folder / "my_rule.py").write_text(source)
        assert said(InputError, load_from, folder, "./my_rule.py:MyRule").endswith(
            "; it imports what is installed, and no file next to it: put them into a package (`rmfs new-rule`)"
        )
    (folder / "my_rule.py").write_text("import far")
    assert said(InputError, load_from, folder, "./my_rule.py:MyRule").endswith("No module named 'far'")
    (folder / "my_rule.py").write_text("raise SystemExit('was run')")
    assert said(InputError, load_from, folder, "./my_rule.py:MyRule", allow_inline=False) == (
        'rules.poa: rule "./my_rule.py:MyRule" would load code from a file, which --no-inline-rules refuses'
    )


def test_a_file_is_loaded_once_per_rule_set_and_anew_for_the_next(folder: Path) -> None:
    first = load_from(folder, "rules/other.py:MyRule", pps="./my_rule.py:MyRule")
    assert first.inline_files == (str(folder / "rules" / "other.py"), str(folder / "my_rule.py"))
    (folder / "my_rule.py").write_text(SOURCE.replace("mine", "edited"))
    second = load_from(folder, "./my_rule.py:MyRule", pps="./my_rule.py:MyRule")
    assert second.poa.instance is second.pps.instance
    assert second.poa.hook(warehouse=None, rng=None) == ["edited"]
    assert second.inline_files == (str(folder / "my_rule.py"),)


@cases(
    "name message",
    ("./my_rule.py:MyRle", "{folder}/my_rule.py has no class `MyRle` (did you mean `MyRule`?)"),
    ("./a:b.py:MyRule", 'rule "./a:b.py:MyRule": cannot read {folder}/a:b.py: No such file or directory'),
    ("./a\0b.py:A", 'rule "./a\0b.py:A": cannot read {folder}/a\0b.py: embedded null byte'),
    ("../outside.py:MyRule", 'rule "../outside.py:MyRule" is outside {folder}; move its file there'),
    ("/none.py:MyRule", 'rule "/none.py:MyRule": cannot read /none.py: No such file or directory'),
)
def test_refused_names(folder: Path, name: str, message: str) -> None:
    assert said(InputError, load_from, folder, name) == f"rules.poa: {message.format(folder=folder)}"


def test_what_is_no_rule(tmp_path: Path) -> None:
    assert said(InputError, load, pr=RuleChoice("xyzzy")).startswith(
        'rules.pr: there is no rule "xyzzy"; expected one of `all`, `alternating`, `assignment`, '
    )
    assert said(InputError, load, filters=(RuleChoice("xyzzy"),)).startswith("rules.filters[0]: ")
    (tmp_path / "mine.py").write_text("def __getattr__(name):\n    raise RuntimeError(name)\n", encoding="utf-8")
    assert said(InputError, load_from, tmp_path, "./mine.py:Mine").endswith("mine.py has no class `Mine`")


def test_an_object_of_an_installed_rule_is_named_as_in_a_scenario(install: Install) -> None:
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
    before = modules_of_files()
    (folder / "my_rule.py").write_text(source)
    with pytest.raises((InputError, KeyboardInterrupt)):
        load_from(folder, "./my_rule.py:MyRule")
    assert modules_of_files() == before


def test_two_scenarios_do_not_see_each_others_file(tmp_path: Path) -> None:
    whole, text = (scenario_in(tmp_path / name, name, "1").parent for name in ("int", "str"))
    sources = [RuleSources(str(folder)) for folder in (whole, text, whole)]
    first = sources[0].find("./mine.py:Mine", "place").target
    other = sources[1].find("./mine.py:Mine", "place").target
    (whole / "mine.py").write_text((text / "mine.py").read_text())
    edited = sources[2].find("./mine.py:Mine", "place").target
    levels = [inspect.getmodule(rule).Level for rule in (first, other, edited)]
    assert [get_type_hints(level)["least"] for level in levels] == [int, str, str]
    assert [pickle.loads(pickle.dumps(level)) for level in levels] == levels


def test_a_module_stays_as_long_as_its_rule(folder: Path) -> None:
    """Who has a rule without a run need not close anything."""
    gc.collect()  # what other tests have left
    before = modules_of_files()
    source = RuleSources(str(folder)).find("./my_rule.py:MyRule", "place")
    assert len(modules_of_files() - before) == 1
    del source
    gc.collect()
    assert modules_of_files() == before
