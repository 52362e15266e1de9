"""A fixture for pytest-benchmark: how long a rule takes per call, in the middle of a run, among other rules."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

import pytest
from attrs import define

from rmfs_commands.bench.worlds import world_with
from rmfs_core import run
from rmfs_core.hookspecs import hookimpl
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_core.rules import RuleSet
from rmfs_core.rules.hooks import new_manager
from rmfs_core.scenario import RuleChoice


class _ReachedError(Exception):
    """The run has served its purpose."""


@define(eq=False)
class _Stop:
    """Observer that ends a run where a rule is asked, and keeps the question."""

    role: Role
    at_s: float
    question: Question | None = None

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        if question.decides is self.role and question.warehouse.now_s >= self.at_s:
            self.question = question
            raise _ReachedError


@pytest.fixture
def rule_benchmark(benchmark: Any) -> Callable[..., Any]:
    """Return the function that measures a rule per call: ``rule_benchmark(rule, decides="PPS")``.

    It needs the package pytest-benchmark. Its arguments:

    - ``rule``: an instance of a rule's class, the name of an installed rule, or its `RuleChoice`;
    - ``decides``: what it decides, as ``rmfs rules`` says it (``"POA"``, ``"POA+PPS"``);
    - ``world``: ``"small"``, ``"250"``, ``"2000"``, or a scenario (a file, or the name of a shipped one);
    - ``overrides``: ``key=value`` each, changing the world;
    - ``at_s``: the simulated time from which on the first question is asked again and again.

    All other decisions are made as in ``rmfs bench``. What the rule answers is returned. Measurements of one decision
    in one world are a group, so that pytest-benchmark shows the rules side by side.
    """

    def measure(
        rule: object, *, decides: str, world: str = "small", overrides: Sequence[str] = (), at_s: float = 300.0
    ) -> Any:
        role = Role.labelled(decides)
        named = RuleChoice(rule) if isinstance(rule, str) else rule
        choice = named if isinstance(named, RuleChoice) else RuleChoice(type(rule).__name__)
        scenario = world_with(world, role, choice, overrides)
        if isinstance(named, RuleChoice):
            loaded = RuleSet.load(scenario.rules, scenario.folder)
            rule = next(one.instance for one in (*loaded.deciding, *loaded.filters) if one.role is role)
        stop = _Stop(role, at_s)
        with suppress(_ReachedError):
            run(scenario, rules={role.key: [rule] if role.many else rule}, observers=[stop])
        if stop.question is None:
            raise ValueError(f"no rule is asked for {decides} from {at_s:g} s on in the world {world}; expected less")
        manager = new_manager()
        manager.register(rule)
        asked, question = getattr(manager.hook, stop.question.hook), stop.question
        arguments = {"warehouse": question.warehouse, "rng": question.rng, **question.arguments}
        benchmark.group = f"{decides} in {world}"
        benchmark.extra_info["backlog"] = len(question.warehouse.backlog)
        return benchmark(asked, **arguments)

    return measure
