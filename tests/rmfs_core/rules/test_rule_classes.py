"""A rule's class: its hooks, parameters, files and what else it declares. (Messages are compared in full.)"""

import os
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from attrs import define, evolve, field

from cases import cases
from installed import RMFS
from rmfs_commands.testing import small_instance
from rmfs_core import InputError
from rmfs_core.events import Event, OrderCompleted
from rmfs_core.info import RunInfo
from rmfs_core.rules import RuleSet
from rmfs_core.rules.hooks import ARGUMENTS
from rmfs_core.rules.parameters import build, parameters_of, values_of
from rmfs_core.rules.parts import FileProblem, add_paths, find_file, made_in, parts_now, with_given
from rmfs_core.rules.traits import RuleTraits
from rmfs_core.scenario.model import BatterySection, RobotsSection, RuleChoice, RulesSection, StationsSection
from rmfs_core.scenario.rulenames import GivenText
from rmfs_core.wording import listed
from saying import said

Install = Callable[..., None]


def refusal(**choices: Any) -> str:
    rules = RulesSection(**({"poa": RuleChoice("pod-match"), "pps": RuleChoice("demand")} | choices))
    return said(InputError, RuleSet.load, rules, ".")


HOOK = "@define\nclass Mine:\n    @hookimpl\n    def {}:\n        return []\n"
NO_ATTRS = 'rule "mine" (acme 1.0) is no attrs class: expected a class decorated with @attrs.define, found'


@cases(
    "source problem",
    (
        HOOK.format("assign_orders(self, warehose)"),
        "class Mine: hook `assign_orders` has no argument `warehose` (did you mean `warehouse`?); "
        "valid arguments are warehouse and rng",
    ),
    ("class Mine:\n    pass\n", f"{NO_ATTRS} class Mine"),  # parameters come from attrs fields
    ("Mine = 5\n", f"{NO_ATTRS} 5"),
    (
        HOOK.format("assign_orders(self, warehouse)").replace("    @hookimpl\n", ""),
        'rule "mine" (acme 1.0) has a method `assign_orders` that lacks the @hookimpl decorator',
    ),
    (
        "@define\nclass Mine:\n    pass\n",
        'rule "mine" (acme 1.0) does not decide POA (hook `assign_orders`); '
        "class Mine decides nothing (it implements no hook)",
    ),
    (
        HOOK.format("asign_orders(self, warehouse)"),
        "class Mine implements a hook `asign_orders`, which does not exist (did you mean "
        f"`assign_orders`, `assign_orders_and_pods` or `assign_bundles`?); the hooks are {listed(ARGUMENTS)}",
    ),
)
def test_a_class_that_is_no_such_rule(install: Install, source: str, problem: str) -> None:
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=source)
    assert refusal(poa=RuleChoice("mine")) == f"rules.poa: {problem}"


@pytest.mark.parametrize("option", ["wrapper", "hookwrapper", "tryfirst", "trylast"])
def test_who_is_told_first_is_up_to_the_kernel(option: str, install: Install) -> None:
    source = f"@define\nclass Mine:\n    @hookimpl({option}=True)\n    def on_event(self, event):\n        yield\n"
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=source)
    assert refusal(observers=(RuleChoice("mine"),)) == (
        f"rules.observers[0]: class Mine: `on_event` is marked with {option}; expected @hookimpl alone"
    )


@pytest.mark.parametrize("body", ["def on_event(self, event): yield", "async def on_event(self, event): yield"])
def test_a_hook_returns(body: str, install: Install) -> None:
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=f"@define\nclass Mine:\n    @hookimpl\n    {body}\n")
    assert refusal(observers=(RuleChoice("mine"),)) == (
        "rules.observers[0]: class Mine: `on_event` yields or is async; expected a method that returns its answer"
    )


MINE = """
import typing
@define
class Mine:
    weight: int = 1
    share: float = field(default=0.5, validator=validators.ge(0))
    names: tuple[str, ...] = ()
    mode: str = field(default="slow")
    rest: float | None = field(default=None, metadata={"infinite": True})
    pair: tuple[int, str] = (1, "a")
    speed: typing.Literal["slow", 3] = 3
    grid: typing.Optional[list[tuple[bool, ...]]] = None
    @mode.validator
    def _check_mode(self, attribute, value):
        if value not in ("slow", "fast"):
            raise ValueError('expected "slow" or "fast"')
    def __attrs_post_init__(self):
        if self.weight == 13:
            raise ValueError("expected a weight that is lucky, found 13")
    @hookimpl
    def assign_orders(self, warehouse): return []
"""


@cases(
    "parameters message",
    (
        {"wieght": 1},
        '.wieght: rule "mine" (acme 1.0) has no parameter `wieght` (did you mean `weight`?); valid parameters are '
        "weight, share, names, mode, rest, pair, speed and grid",
    ),
    ({"weight": "1"}, '.weight: expected a whole number, found "1"'),  # a text is no number
    ({"weight": True}, ".weight: expected a whole number, found true"),  # nor is true
    ({"weight": 10**12}, ".weight: expected a whole number below 1e+12, found 1000000000000"),
    ({"share": float("inf")}, ".share: expected a number below 1e+12, found inf"),
    ({"share": 1e300}, ".share: expected a number below 1e+12, found 1e+300"),
    ({"rest": float("nan")}, ".rest: expected a number or nothing below 1e+12, found nan"),
    ({"weight": 1.0}, ".weight: expected a whole number, found 1.0"),
    ({"share": "0.5"}, '.share: expected a number, found "0.5"'),
    ({"rest": "x"}, '.rest: expected a number or nothing, found "x"'),
    ({"names": ["a", 1]}, '.names: expected a list, each a text, found ["a", 1]'),
    ({"names": "ab"}, '.names: expected a list, each a text, found "ab"'),
    ({"pair": [1]}, ".pair: expected a list of a whole number and a text, found [1]"),
    ({"speed": "fast"}, '.speed: expected one of "slow", 3, found "fast"'),
    ({"grid": 3}, ".grid: expected a list, each a list, each true or false or nothing, found 3"),
    ({"share": -1.0}, ".share: expected a number >= 0, found -1.0"),  # a validator of attrs
    ({"mode": "idle"}, '.mode: expected "slow" or "fast", found "idle"'),  # the rule's own validator
    ({"weight": 13}, ': rule "mine" (acme 1.0): expected a weight that is lucky, found 13'),
)
def test_wrong_parameter(install: Install, parameters: dict[str, Any], message: str) -> None:
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=MINE)
    assert refusal(poa=RuleChoice("mine", parameters)) == f"rules.poa{message}"


def test_parameters_of_the_right_type_are_accepted(install: Install) -> None:
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=MINE)
    given = {"share": 1, "names": ["a"], "rest": float("inf"), "mode": "fast", "pair": [2, "b"], "grid": [[True], []]}
    choice = RuleChoice("mine", given)
    loaded = RuleSet.load(RulesSection(poa=choice, pps=RuleChoice("demand")), ".")
    mine = loaded.poa.instance
    assert (type(mine.share), mine.grid) == (float, [(True,), ()])
    assert (mine.share, mine.names, mine.rest, mine.mode, mine.pair) == (1.0, ("a",), float("inf"), "fast", (2, "b"))


@pytest.mark.parametrize("cause", ["KeyError: 3", "SystemExit: 3", "BaseException: 3"])
def test_a_class_that_cannot_be_constructed(install: Install, cause: str) -> None:
    assert refusal(pp=RuleChoice("free-flow", {"speed": 1})) == (
        f'rules.pp.speed: rule "free-flow" ({RMFS}) has no parameter `speed`; it has no parameters'
    )
    raising = f"raise {cause.replace(': ', '(')})"
    source = MINE.replace('raise ValueError("expected a weight that is lucky, found 13")', raising)
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=source)
    assert refusal(poa=RuleChoice("mine", {"weight": 13})) == (
        f'rules.poa: rule "mine" (acme 1.0) cannot be created: {cause}'
    )


@define
class Shelf:
    width: int
    _depth: float = 2.5
    labels: list[str] = field(factory=list)
    found: int = field(init=False, default=0)
    anything: Any = None
    doubled: int = field(default=1, converter=lambda value: 2 * int(value))
    many: float | int = 0


def test_parameters_are_the_fields_that_init_takes() -> None:
    assert list(parameters_of(Shelf)) == ["width", "depth", "labels", "anything", "doubled", "many"]
    shelf = build(
        Shelf, {"width": 3, "depth": 1, "anything": {"a": [1]}, "doubled": "4", "many": 3}, "rules.pr", "rule"
    )
    assert shelf == Shelf(width=3, depth=1.0, anything={"a": [1]}, doubled=4, many=3)
    assert type(shelf.many) is int
    assert build(Shelf, {"width": 1}, "p", "r").labels is not build(Shelf, {"width": 1}, "p", "r").labels
    with pytest.raises(InputError, match=r"^here\.width: it needs the parameter `width`, which is missing$"):
        build(Shelf, {"depth": 3.0}, "here", "it")


def test_what_is_told_of_an_objects_parameters() -> None:
    shelf = Shelf(3, depth=2.5, labels=["a"], anything={"by": len, "pair": (1, 2), "file": Path("a/b")})
    assert values_of(shelf) == {
        "width": 3,
        "labels": ["a"],
        "anything": {"by": "<builtin_function_or_method>", "pair": [1, 2], "file": "a/b"},
        "doubled": 2,
    }
    around: list[object] = []
    around.append(around)
    told = values_of(Shelf(3, anything=around))["anything"]
    for _ in range(20):
        [told] = [told] if told == "<list>" else told
    assert told == "<list>"


@define
class Many:
    one: Path | None = None
    several: tuple[Path, ...] = ()
    either: str | Path = "no file"
    converted: Path = field(default=None, converter=lambda path: path and path.parent)
    default: Path = Path("default.bin")
    text: str = ""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "deep").mkdir()
    for name in ("default.bin", "a.bin", "b.bin", "deep/a.bin"):
        (tmp_path / name).write_text(name, encoding="utf-8")
    return tmp_path


def test_files_beside_the_scenario(folder: Path) -> None:
    values = {"one": "a.bin", "several": ["b.bin", "deep/a.bin"], "either": "a.bin", "converted": "b.bin", "text": "x"}
    with made_in(str(folder)) as parts:
        rule = build(Many, values, "rules.pr", "it")
    assert (rule.one, rule.several) == (folder / "a.bin", (folder / "b.bin", folder / "deep" / "a.bin"))
    assert (rule.either, rule.converted, rule.text) == (folder / "a.bin", folder, "x")
    assert rule.default == folder / "default.bin"
    assert sorted(one.name for one in parts.files) == ["a.bin", "a.bin", "b.bin", "b.bin", "deep/a.bin", "default.bin"]
    assert parts.files[-1].digest().startswith("sha256:")
    assert parts.classes == [Many]
    (folder / "deep" / "only.bin").write_text("", encoding="utf-8")
    with made_in(str(folder)) as parts:
        assert find_file(GivenText("only.bin", str(folder / "deep"))) == folder / "deep" / "only.bin"
    with made_in(str(folder / "deep")) as other:
        find_file(GivenText("a.bin", str(folder)))
    assert [one.name for one in (*parts.files, *other.files)] == ["deep/only.bin", str(folder / "a.bin")]
    given = GivenText("b", "/there")
    value = (RuleChoice("rule", {"x": [given, "c"], "y": 1}), "d")
    assert with_given(value, str.upper) == (RuleChoice("rule", {"x": ["B", "c"], "y": 1}), "d")


@cases(
    "values message",
    ({"one": "none.bin"}, "rules.pr.one: there is no file {folder}/none.bin"),
    ({"several": ["a.bin", "none.bin"]}, "rules.pr.several: there is no file {folder}/none.bin"),
    ({"either": "none.bin"}, "rules.pr.either: there is no file {folder}/none.bin"),
    ({"one": "deep"}, "rules.pr.one: expected a file, found a folder, {folder}/deep"),
    ({"one": "/dev/null"}, "rules.pr.one: expected a file, found a device, /dev/null"),
    ({"one": "x" * 5000}, "rules.pr.one: there is no file {folder}/xxx"),
    ({"one": 3}, "rules.pr.one: expected the name of a file or nothing, found 3"),
)
def test_what_is_no_file_is_refused(folder: Path, values: dict[str, Any], message: str) -> None:
    with made_in(str(folder)), pytest.raises(InputError) as caught:
        build(Many, values, "rules.pr", "it")
    expected = message.format(folder=folder)
    assert str(caught.value).startswith(expected)
    assert len(str(caught.value)) < len(expected) + 1000


def test_files_of_objects_and_outside_of_a_scenario(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    assert parts_now().folder == "."
    assert find_file("a.bin").samefile(folder / "a.bin")
    with pytest.raises(FileProblem):
        find_file("none.bin")
    with monkeypatch.context() as patch, pytest.raises(FileProblem, match="cannot be read: permission denied"):
        patch.setattr(os, "access", lambda *_: False)  # else the superuser may read any
        find_file("a.bin")
    monkeypatch.chdir(folder / "deep")
    with made_in(str(folder)) as parts:
        add_paths({"x": [Path("a.bin"), Path("none.bin"), 3]})
    assert [one.name for one in parts.files] == ["deep/a.bin"]


EVENTS = "a tuple of classes of events, or a mapping from these to lists of functions"
NEEDED = "a tuple of 'unlimited stock', 'item capacity' or 'no batteries'"


def test_traits_have_defaults() -> None:
    for rule in (object(), SimpleNamespace(reserves=None, packing_capacity=None)):
        assert RuleTraits.of(rule, "here", "it") == RuleTraits()
    (role,) = RuleTraits.of(SimpleNamespace(decides=("pps",)), "here", "it").decides
    assert (role.label, role.hook) == ("PPS", "select_pods")


def test_what_is_declared_is_read() -> None:
    """From the instance, so that a parameter can be one."""
    declared: dict[str, Any] = {
        "needs": ("unlimited stock",),
        "libraries": ("highspy",),
        "splits_over_time": True,
        "packing_capacity": 0,
        "reserves": "windows",
        "prepare": print,
        "hears": {OrderCompleted: [print]},
    }
    assert RuleTraits.of(SimpleNamespace(**declared), "here", "it") == RuleTraits(**declared)


@cases(
    "trait value expected",
    ("needs", "unlimited stock", NEEDED),  # a text is no tuple of them
    ("needs", ("luck",), NEEDED),
    ("libraries", ["highspy"], "a tuple of installed distributions' names"),
    ("libraries", (1,), "a tuple of installed distributions' names"),
    ("libraries", ("no-such-distribution",), "a tuple of installed distributions' names"),
    ("libraries", ("",), "a tuple of installed distributions' names"),
    ("decides", ("poa", "prices"), "a tuple of roles"),
    ("splits_over_time", 1, "True or False"),
    ("packing_capacity", -1, "a whole number >= 0, or None"),
    ("packing_capacity", True, "a whole number >= 0, or None"),
    ("reserves", "paths", "'fleet', 'full paths', 'windows' or None"),
    ("prepare", "warm up", "a method"),
    ("hears", 5, EVENTS),
    ("hears", OrderCompleted, EVENTS),  # a class is no tuple of them
    ("hears", ("OrderCompleted",), EVENTS),
    ("hears", (int,), EVENTS),
    ("hears", (Event,), EVENTS),  # nothing that happens is just an event
    ("hears", {OrderCompleted: 3}, EVENTS),
    ("hears", {OrderCompleted: [3]}, EVENTS),
    ("hears", {int: [print]}, EVENTS),
)
def test_a_wrong_declaration_is_refused(trait: str, value: object, expected: str) -> None:
    problem = said(InputError, RuleTraits.of, SimpleNamespace(**{trait: value}), "here", "it")
    assert problem == f"here: it has {trait} = {value!r}; expected {expected}"


def test_what_a_rule_needs_is_held_against_the_scenario(tiny: RunInfo) -> None:
    finite, endless = small_instance({"1": ["a"]}, {"p": {"a": 1}}), small_instance({"1": ["a"]}, {"p": ["a"]})
    by_orders = evolve(tiny.scenario, stations=StationsSection(order_capacity=3))
    stock = "pods whose SKUs never run out, but the instance has finite stock"
    items = "stations that count items, but the scenario sets `stations.order_capacity`"
    both = RuleTraits(needs=("item capacity", "unlimited stock"))
    assert both.lacks(tiny.scenario, endless) == []
    assert both.lacks(tiny.scenario, finite) == [stock]
    assert both.lacks(by_orders, finite) == [items, stock]
    assert RuleTraits().lacks(by_orders, finite) == []
    charged = evolve(tiny.scenario, robots=RobotsSection(battery=BatterySection()))
    without = RuleTraits(needs=("no batteries",))
    assert without.lacks(tiny.scenario, finite) == []
    assert without.lacks(charged, finite) == [
        "robots without batteries, as it sends none to a charger, but the scenario sets `robots.battery`"
    ]


def test_a_trait_that_cannot_be_read_or_compared_is_one_sentence() -> None:
    class Raising:
        needs = property(lambda self: 1 / 0)

    with pytest.raises(InputError, match=r"^here: it has needs = ZeroDivisionError\('division by zero'\); expected a "):
        RuleTraits.of(Raising(), "here", "it")
    with pytest.raises(InputError, match=r"^here: it has reserves = array\(\[\[1, 2\], \[3, 4\]\]\); expected "):
        RuleTraits.of(SimpleNamespace(reserves=np.array([[1, 2], [3, 4]])), "here", "it")
