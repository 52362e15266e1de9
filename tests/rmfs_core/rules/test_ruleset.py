"""Discovery, selection and registration of rules."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import numpy as np
import pytest
from attrs import define

from rmfs_commands.testing import small_world
from rmfs_core import InputError, hookimpl
from rmfs_core.entrypoints import RULES, offers
from rmfs_core.rules import RuleSet, with_objects
from rmfs_core.scenario.model import RuleChoice, RulesSection
from rmfs_core.warehouse import WarehouseView

POA = "    @hookimpl\n    def assign_orders(self, warehouse):\n        return [{answer}]\n"
POA_RULES = (
    *("pod-match", "common-lines", "first-come", "random"),
    *("workload", "near-best-pod", "earliest-due", "least-slack", "station-queue"),
)
RULE_NAMES = {
    *POA_RULES,
    *("demand", "nearest-pod", "completes", "work-amount", "lexicographic"),
    *("nearest", "fixed", "random", "station-based", "turnover-classes", "cache", "utility"),
    *("nearest-robot", "balanced", "assignment"),
    *("free-flow", "switch"),
}

Install = Callable[..., None]


def rules(**choices: Any) -> RulesSection:
    """Return a rules section with the sequential rules, some replaced."""
    return RulesSection(**({"poa": RuleChoice("pod-match"), "pps": RuleChoice("demand")} | choices))


def load(**choices: Any) -> RuleSet:
    """Load a rule set with the sequential rules, some replaced."""
    return RuleSet.load(rules(**choices), ".")


def test_installed_rules_are_listed_without_importing_them(install: Install) -> None:
    """A rule whose module does not exist is listed like any other."""
    install("acme", {"broken": "acme_missing:Broken"})
    assert offers(RULES).keys() >= {"broken", *RULE_NAMES}
    assert offers(RULES)["pod-match"][0].value == "rmfs_rules.pod_match:PodMatch"
    assert "acme_missing" not in sys.modules


def test_a_rule_set_binds_each_role_to_its_rule() -> None:
    """Every role has its rule, with name, distribution and version, and optional roles are empty."""
    loaded = load(filters=())
    assert loaded.poa is not None
    assert loaded.pps is not None
    bound = (loaded.poa, loaded.pps, loaded.pr, loaded.ta, loaded.pp)
    assert [rule.role for rule in bound] == ["poa", "pps", "pr", "ta", "pp"]
    assert [rule.name for rule in bound] == ["pod-match", "demand", "nearest", "balanced", "sipp"]
    assert loaded.pps.describe() == f'rule "demand" (rmfs {version("rmfs")})'
    assert loaded.pps.hook.name == "select_pods"
    assert (loaded.poa_pps, loaded.filters, loaded.observers, loaded.inline_files) == (None, (), (), ())


def test_distributions_name_everything_that_took_part(install: Install) -> None:
    """Versions of the libraries, python and the third party's distribution are there; nothing else is."""
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules="@define\nclass Mine:\n" + POA.format(answer=1))
    found = load(poa=RuleChoice("mine")).distributions
    assert set(found) == {"acme", "attrs", "numba", "numpy", "pluggy", "python", "rmfs", "simpy"}
    assert found["acme"] == "1.0"
    assert found["numpy"] == version("numpy")


def test_a_rule_s_own_libraries_took_part_too() -> None:
    """The version of the solver is kept with the results of the rules that use it."""
    loaded = load(poa=None, pps=None, poa_pps=RuleChoice("integrated"))
    assert {"highspy", "mip"} <= set(loaded.distributions)
    assert "mip" not in load().distributions


def test_every_shipped_rule_can_be_selected() -> None:
    """Each rule answers its hook through the rule set."""
    for poa in POA_RULES:
        assert load(poa=RuleChoice(poa)).poa is not None
    for pps in ("demand", "nearest-pod", "completes", "work-amount", "lexicographic", "random"):
        assert load(pps=RuleChoice(pps)).pps is not None
    for pr, ta in (
        *(("nearest", "balanced"), ("fixed", "nearest-robot"), ("random", "random"), ("station-based", "balanced")),
        *(("turnover-classes", "balanced"), ("cache", "balanced"), ("utility", "assignment")),
    ):
        loaded = load(pr=RuleChoice(pr), ta=RuleChoice(ta))
        assert (loaded.pr.name, loaded.ta.name) == (pr, ta)


def test_instances_are_new_for_each_rule_set() -> None:
    """No state is carried from run to run."""
    assert load().ta.instance is not load().ta.instance


BOTH = """
@define
class Both:
    weight: int = 1

    @hookimpl
    def assign_orders(self, warehouse):
        return ["orders", self.weight]

    @hookimpl
    def select_pods(self, warehouse, max_fetches):
        return ["pods", max_fetches]
"""


def ask(rule: Any, **arguments: Any) -> Any:
    """Call a bound rule's hook as the kernel does."""
    return rule.hook(warehouse=None, rng=None, **arguments)


def test_the_same_choice_for_two_roles_is_one_instance(install: Install) -> None:
    """Rule and parameters decide: other parameters give an instance of their own."""
    install("acme", {"both": "acme_rules:Both"}, acme_rules=BOTH)
    same = load(poa=RuleChoice("both", {"weight": 2}), pps=RuleChoice("both", {"weight": 2}))
    assert same.poa is not None
    assert same.pps is not None
    assert same.poa.instance is same.pps.instance
    assert (ask(same.poa), ask(same.pps, max_fetches=3)) == (["orders", 2], ["pods", 3])
    differs = load(poa=RuleChoice("both", {"weight": 2}), pps=RuleChoice("both"))
    assert differs.poa is not None
    assert differs.pps is not None
    assert differs.poa.instance is not differs.pps.instance
    assert ask(differs.poa) == ["orders", 2]


def test_a_rule_decides_only_what_it_was_selected_for(install: Install) -> None:
    """A rule that could also select pods leaves that to the rule of the scenario."""
    install(
        "acme",
        {"both": "acme_rules:Both", "other": "acme_rules:Other"},
        acme_rules=BOTH + "\n@define\nclass Other(Both):\n    pass\n",
    )
    loaded = load(poa=RuleChoice("both", {"weight": 7}), pps=RuleChoice("other", {"weight": 8}))
    assert loaded.poa is not None
    assert ask(loaded.poa) == loaded.pm.hook.assign_orders(warehouse=None, rng=None) == ["orders", 7]


FILTER = """
@define
class Keep:
    n: int

    @hookimpl
    def filter_backlog(self, warehouse, orders):
        return orders[: self.n]
"""


def test_filters_are_called_one_at_a_time_in_the_scenarios_order(install: Install) -> None:
    """Each bound filter calls itself only."""
    install("acme", {"keep": "acme_rules:Keep"}, acme_rules=FILTER)
    loaded = load(filters=(RuleChoice("keep", {"n": 3}), RuleChoice("keep", {"n": 1})))
    assert [ask(rule, orders=[1, 2, 3, 4]) for rule in loaded.filters] == [[1, 2, 3], [1]]


def test_a_rule_may_observe_the_run_as_well(install: Install) -> None:
    """Observer hooks of a selected rule are called with those of all other observers."""
    source = "@define\nclass Mine:\n    seen: list = field(init=False, factory=list)\n" + POA.format(answer=1)
    source += "    @hookimpl\n    def on_event(self, event):\n        self.seen.append(event)\n"
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=source)
    loaded = load(poa=RuleChoice("mine"), observers=(RuleChoice("mine"),))
    assert loaded.poa is not None
    loaded.pm.hook.on_event(event="tick")
    assert loaded.poa.instance.seen == ["tick"]
    assert loaded.observers[0].instance is loaded.poa.instance


def test_an_observer_object_can_be_registered() -> None:
    """Its observer hooks are called, its decision hooks are not, and equal objects do not get in each other's way."""

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
    """Misspelt hooks and objects that observe nothing are refused by name."""

    class Misspelt:
        @hookimpl
        def on_evnt(self, event: object) -> None:
            """Never called."""

    with pytest.raises(InputError) as caught:
        load().register_observer(Misspelt())
    assert str(caught.value).startswith(
        "observer Misspelt: class Misspelt implements a hook `on_evnt`, which does not exist "
        "(did you mean `on_event`?); the hooks are assign_orders, "
    )
    with pytest.raises(InputError, match="observer object: it implements no observer hook"):
        load().register_observer(object())

    class Listens:
        hears = ("OrderCompleted",)

        @hookimpl
        def on_event(self, event: object) -> None:
            """Never called."""

    with pytest.raises(
        InputError, match=r"^observer Listens: it has hears = \('OrderCompleted',\); expected a tuple of"
    ):
        load().register_observer(Listens())


@define
class Both:
    """A rule for orders and pods that is also told what happens, and leaves orders out."""

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView) -> list[Any]:
        """Assign none."""
        return []

    @hookimpl
    def select_pods(self, warehouse: WarehouseView) -> list[Any]:
        """Select none."""
        return []

    @hookimpl
    def filter_backlog(self, warehouse: WarehouseView) -> list[int]:
        """Keep none."""
        return []


def test_objects_are_the_rules_themselves() -> None:
    """One object in two roles is one rule; equal ones in two places are two."""
    both, one, other = Both(), Both(), Both()
    objects = {"poa": both, "pps": both, "filters": [one, other]}
    loaded = RuleSet.load(with_objects(rules(), objects), ".", objects=objects)
    assert loaded.poa is not None
    assert loaded.pps is not None
    assert loaded.poa.instance is loaded.pps.instance is both
    assert [rule.instance for rule in loaded.filters] == [one, other]
    assert loaded.filters[0].instance is one
    assert loaded.filters[1].instance is other
    assert loaded.distributions["Both"] == f"object of {__name__}"


def test_choices_that_objects_replace_are_not_looked_at() -> None:
    """A joint rule takes the place of two, and one of two that of a joint rule; the rest stays."""
    paired = rules(pr=RuleChoice("fixed"))
    joint = with_objects(paired, {"poa_pps": Both()})
    assert (joint.poa, joint.pps, joint.poa_pps, joint.pr) == (None, None, RuleChoice("Both"), RuleChoice("fixed"))
    again = with_objects(joint, {"poa": Both(), "pps": Both()})
    assert (again.poa, again.pps, again.poa_pps) == (RuleChoice("Both"), RuleChoice("Both"), None)
    assert with_objects(paired, {}) is paired


@pytest.mark.parametrize(
    ("objects", "message"),
    [
        ([Both()], '^argument rules: expected rules by what they decide, such as {"poa": MyRule\\(\\)}, found '),
        (
            Both(),
            '^argument rules: expected rules by what they decide, such as {"poa": MyRule\\(\\)}, found Both\\(\\)',
        ),
        ({"paa": Both()}, "^argument rules: unknown key 'paa' \\(did you mean `poa`"),
        ({"observers": [Both()]}, "^argument rules: unknown key 'observers'"),  # `run` has an argument for these
        ({"poa": Both}, "^argument rules.poa: expected an object of a rule's class, such as MyRule.., found <class"),
        ({"poa": "demand"}, "^argument rules.poa: expected an object .*, found 'demand'$"),
        ({"poa": object()}, '^argument rules.poa: rule "object" .* is no attrs class'),
        ({"pr": Both()}, '^argument rules.pr: rule "Both" .* does not decide PR .*; class Both decides POA, PPS and'),
        ({"filters": Both()}, "^argument rules.filters: expected a list of rules, found Both"),
        ({"filters": [Both(), None]}, r"^argument rules.filters\[1\]: expected an object .*, found None$"),
        ({"poa": Both(), "poa_pps": Both()}, "^argument rules: expected either `poa_pps` or `poa` and `pps`, found"),
    ],
)
def test_what_is_no_rule_is_refused_as_in_a_scenario(objects: Any, message: str) -> None:
    """The place is the argument, not the scenario's key of that name, which has a line in a file."""
    with pytest.raises(InputError, match=message):
        RuleSet.load(with_objects(rules(), objects), ".", objects=objects)
