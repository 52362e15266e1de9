"""Rule ``switch``, for POA, PPS, PR and TA: other rules in turn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Any

import numpy as np
import pluggy
from attrs import Factory, define, field, frozen, validators

from rmfs_core import OrderAssignment, PodTrip, TaskAssignment, hookimpl
from rmfs_core.hookspecs import DecisionHooks, ObserverHooks, TimeHooks

if TYPE_CHECKING:
    from rmfs_core.traffic import Roads
    from rmfs_core.warehouse import Pod, Robot, WarehouseView


@frozen
class Case:
    """A rule, and when it decides.

    Parameters
    ----------
    rule
        Name of an installed rule.
    parameters
        Its parameters.
    before_s
        Until which time it decides (s); always, if left out.
    backlog_below
        The number of orders in the backlog below which it decides; whatever that is, if left out.
    """

    rule: str
    parameters: Mapping[str, Any] = Factory(dict)
    before_s: float | None = field(default=None, validator=validators.optional(validators.gt(0)))
    backlog_below: int | None = field(default=None, validator=validators.optional(validators.ge(1)))

    def holds(self, warehouse: WarehouseView) -> bool:
        """Whether the rule is to decide now."""
        in_time = self.before_s is None or warehouse.now_s < self.before_s
        return in_time and (self.backlog_below is None or len(warehouse.backlog) < self.backlog_below)

    @property
    def entry(self) -> EntryPoint:
        """Where the rule comes from."""
        found = list(entry_points(group="rmfs", name=self.rule))
        if len(found) != 1:
            raise ValueError(f'expected one installed rule "{self.rule}", found {len(found)}')
        return found[0]

    def asked(self) -> tuple[Any, pluggy.PluginManager]:
        """Return a new instance of the rule, and the hooks that ask it and no other."""
        rule = self.entry.load()(**self.parameters)
        manager = pluggy.PluginManager("rmfs")
        for specification in (DecisionHooks, TimeHooks, ObserverHooks):
            manager.add_hookspecs(specification)
        manager.register(rule)
        if any(getattr(manager.hook, hook).get_hookimpls() for hook in vars(ObserverHooks) if hook[0] != "_"):
            raise ValueError(f'rule "{self.rule}" observes the run, which it cannot do as one of several')
        return rule, manager


def _last_always(_instance: object, _attribute: Any, value: tuple[Case, ...]) -> None:
    if not value or value[-1].before_s is not None or value[-1].backlog_below is not None:
        raise ValueError("expected cases of which the last one has neither before_s nor backlog_below")


@define
class Switch:
    """Ask one of several rules, by the time or by the load.

    The first of the cases that holds decides: one holds before its time ``before_s``, and while fewer orders than its
    ``backlog_below`` are in the backlog. The last one always holds. In a scenario::

        [rules.poa]
        rule = "switch"
        cases = [
            { rule = "pod-match", before_s = 3600 },
            { rule = "first-come", backlog_below = 20 },
            { rule = "common-lines", parameters = { max_wait_s = 600 } },
        ]

    All of them draw from the same random numbers. Rules that observe the run, and those for POA and PPS together, are
    not among those that can be asked.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8 (method management)
    """

    cases: tuple[Case, ...] = field(
        validator=_last_always, metadata={"doc": "The rules and when each decides; the first that holds counts"}
    )
    _asked: list[tuple[Any, pluggy.PluginManager]] = field(init=False, repr=False, eq=False)
    _robots: tuple[Robot, ...] = field(init=False, default=(), repr=False, eq=False)  # whose run it is

    def __attrs_post_init__(self) -> None:
        self._asked = [case.asked() for case in self.cases]

    @property
    def splits_over_time(self) -> bool:
        """Whether any of the rules does."""
        return any(getattr(rule, "splits_over_time", False) for rule, _ in self._asked)

    @property
    def needs(self) -> tuple[str, ...]:
        """What any of the rules needs."""
        return tuple(sorted({need for rule, _ in self._asked for need in getattr(rule, "needs", ())}))

    @property
    def libraries(self) -> tuple[str, ...]:
        """Where the rules come from, and what they compute with."""
        used = {name for rule, _ in self._asked for name in getattr(rule, "libraries", ())}
        return tuple(sorted(used | {case.entry.dist.name for case in self.cases if case.entry.dist is not None}))

    def prepare(self, roads: Roads) -> None:
        """Let each rule prepare."""
        for rule, _ in self._asked:
            if hasattr(rule, "prepare"):
                rule.prepare(roads)

    def _deciding(self, warehouse: WarehouseView) -> int:
        return next(i for i, case in enumerate(self.cases) if case.holds(warehouse))

    def _ask(self, hook: str, warehouse: WarehouseView, **arguments: Any) -> Any:
        if self._robots is not warehouse.robots:  # another run: what rules remember is of the last one
            if self._robots:
                self._asked = [case.asked() for case in self.cases]
            self._robots = warehouse.robots
        number = self._deciding(warehouse)
        caller = getattr(self._asked[number][1].hook, hook)
        if not caller.get_hookimpls():
            raise ValueError(f'rule "{self.cases[number].rule}" does not decide this (it has no hook `{hook}`)')
        return caller(warehouse=warehouse, **arguments)

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[OrderAssignment]:
        """Ask for orders."""
        answer: Sequence[OrderAssignment] = self._ask("assign_orders", warehouse, rng=rng)
        return answer

    @hookimpl
    def select_pods(self, warehouse: WarehouseView, max_fetches: int, rng: np.random.Generator) -> Sequence[PodTrip]:
        """Ask for pods."""
        answer: Sequence[PodTrip] = self._ask("select_pods", warehouse, max_fetches=max_fetches, rng=rng)
        return answer

    @hookimpl
    def choose_storage_location(self, warehouse: WarehouseView, pod: Pod, rng: np.random.Generator) -> int:
        """Ask for a place."""
        answer: int = self._ask("choose_storage_location", warehouse, pod=pod, rng=rng)
        return answer

    @hookimpl
    def assign_tasks(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[TaskAssignment]:
        """Ask for robots."""
        answer: Sequence[TaskAssignment] = self._ask("assign_tasks", warehouse, rng=rng)
        return answer

    @hookimpl
    def wake_at(self, warehouse: WarehouseView, rng: np.random.Generator) -> float | None:
        """Wake up when another rule is to decide, or when the one that decides now wants to."""
        times = [case.before_s for case in self.cases if case.before_s is not None and case.before_s > warehouse.now_s]
        _, manager = self._asked[self._deciding(warehouse)]
        if manager.hook.wake_at.get_hookimpls():
            answer: float | None = manager.hook.wake_at(warehouse=warehouse, rng=rng)
            times += [answer] if answer is not None else []
        return min(times, default=None)
