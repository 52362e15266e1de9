"""Rule ``switch``, for POA, PPS, PR and TA: other rules in turn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import NOTHING, Factory, define, field, frozen, validators

from rmfs_core import InputError, OrderAssignment, PodTrip, TaskAssignment, hookimpl
from rmfs_core.rules.hooks import (
    OBSERVER_HOOKS,
    check_hooks,
    decided,
    marked_methods,
    new_manager,
    require_attrs_class,
    roles_of,
)
from rmfs_core.rules.parameters import build
from rmfs_core.rules.parts import made_in, parts_now
from rmfs_core.rules.sources import RuleSources
from rmfs_core.rules.traits import RuleTraits
from rmfs_core.scenario.rulenames import is_inline
from rmfs_rules.helpers.parameters import AT_LEAST_1, POSITIVE, parameter

if TYPE_CHECKING:
    import pluggy

    from rmfs_core.roles import Role
    from rmfs_core.warehouse import Pod, Robot, WarehouseView
    from rmfs_core.world.travel import Travel


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
    before_s: float | None = field(default=None, validator=validators.optional(POSITIVE))
    backlog_below: int | None = field(default=None, validator=validators.optional(AT_LEAST_1))

    def holds(self, warehouse: WarehouseView) -> bool:
        """Whether the rule is to decide now."""
        in_time = self.before_s is None or warehouse.now_s < self.before_s
        return in_time and (self.backlog_below is None or warehouse.backlog_size < self.backlog_below)

    def asked(self, place: str) -> _Asked:
        """Return a new instance of the rule, checked as a scenario's own; messages call the case ``place``."""
        if is_inline(self.rule):
            raise InputError(f"{place}.rule", f"expected an installed rule, found {self.rule!r}")
        source = RuleSources(".", allow_inline=False).find(self.rule, f"{place}.rule")
        name = source.describe()
        kind = require_attrs_class(f"{place}.rule", source.target, name)
        check_hooks(f"{place}.rule", kind, kind.__name__)
        if OBSERVER_HOOKS & marked_methods(kind).keys():
            raise InputError(f"{place}.rule", f"{name} observes the run, which it cannot do as one of several")
        rule = build(kind, self.parameters, f"{place}.parameters", name)
        traits = RuleTraits.of(rule, f"{place}.rule", name)
        decides = tuple(role for role in roles_of(kind) if role in traits.decides)
        manager = new_manager()
        manager.register(rule)
        return _Asked(name, source.distribution, traits, decides, manager.hook)


@frozen(eq=False)
class _Asked:
    """A rule that a case asks.

    Parameters
    ----------
    name
        Its name in messages.
    distribution
        Where it comes from.
    traits
        Declarations of its class.
    decides
        Roles that it can play.
    hook
        Calls its hooks, and no other rule's.
    """

    name: str
    distribution: str
    traits: RuleTraits
    decides: tuple[Role, ...]
    hook: pluggy.HookRelay


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

    All of them decide the same, and draw from the same random numbers. Rules that observe the run, and those for POA
    and PPS together, cannot be asked.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8 (method management)
    """

    cases: tuple[Case, ...] = parameter(
        NOTHING, _last_always, "The rules and when each decides; the first that holds counts"
    )
    _asked: list[_Asked] = field(init=False, repr=False, eq=False)
    _folder: str = field(init=False, repr=False, eq=False)  # where files that the rules' parameters name are
    _robots: tuple[Robot, ...] = field(init=False, default=(), repr=False, eq=False)  # whose run it is

    def __attrs_post_init__(self) -> None:
        self._folder = parts_now().folder
        try:
            self._asked = self._new()
        except InputError as error:
            raise ValueError(str(error)) from error  # the kernel adds the key of the scenario
        if not self.decides:
            found = "; ".join(f"{asked.name} decides {decided(asked.decides)}" for asked in self._asked)
            able = decided(roles_of(Switch))
            raise ValueError(f"cases: expected rules that decide the same, of {able}; {found}")

    def _new(self) -> list[_Asked]:
        return [case.asked(f"cases[{number}]") for number, case in enumerate(self.cases)]

    @property
    def decides(self) -> tuple[Role, ...]:
        """Decisions that all of the rules take."""
        return tuple(role for role in roles_of(Switch) if all(role in asked.decides for asked in self._asked))

    @property
    def splits_over_time(self) -> bool:
        """Whether any of the rules does."""
        return any(asked.traits.splits_over_time for asked in self._asked)

    @property
    def needs(self) -> tuple[str, ...]:
        """Needs of any of the rules."""
        return tuple(sorted({need for asked in self._asked for need in asked.traits.needs}))

    @property
    def libraries(self) -> tuple[str, ...]:
        """Where the rules come from, and what they compute with."""
        return tuple(sorted({name for asked in self._asked for name in (asked.distribution, *asked.traits.libraries)}))

    def prepare(self, travel: Travel) -> None:
        """Let each rule prepare."""
        for asked in self._asked:
            if asked.traits.prepare is not None:
                asked.traits.prepare(travel)

    def _deciding(self, warehouse: WarehouseView) -> _Asked:
        return next(asked for case, asked in zip(self.cases, self._asked, strict=True) if case.holds(warehouse))

    def _ask(self, hook: str, warehouse: WarehouseView, **arguments: Any) -> Any:
        if self._robots is not warehouse.robots:  # another run: what rules remember is of the last one
            if self._robots:
                with made_in(self._folder):
                    self._asked = self._new()
            self._robots = warehouse.robots
        return getattr(self._deciding(warehouse).hook, hook)(warehouse=warehouse, **arguments)

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
        """Ask for a storage location."""
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
        answer: float | None = self._deciding(warehouse).hook.wake_at(warehouse=warehouse, rng=rng)
        times += [answer] if answer is not None else []
        return min(times, default=None)
