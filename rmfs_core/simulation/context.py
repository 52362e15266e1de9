"""State shared by the parts of a run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import pluggy
import simpy

from rmfs_core.events import Event
from rmfs_core.randomness import rule_stream
from rmfs_core.roles import Role
from rmfs_core.rules import BoundRule, RuleSet
from rmfs_core.scenario.model import Scenario
from rmfs_core.simulation.asking import Asker, Observers
from rmfs_core.warehouse import Warehouse, WarehouseView

T = TypeVar("T")


class Clock(simpy.Environment):
    """Simulated time in ticks, and what happens next."""

    @property
    def upcoming(self) -> list[tuple[int, simpy.Event]]:
        """Events and their ticks, in the order in which they happen."""
        return [(int(tick), event) for tick, _, _, event in sorted(self._queue)]


class RunContext:
    """The clock, the warehouse and the rules of a run, and its observers.

    Parameters
    ----------
    scenario
        Limits and seed.
    rules
        The selected rules, with all observers registered.
    warehouse
        The state.
    begun
        Whether the run begins in the middle: robots are put where they are later.

    Attributes
    ----------
    env, began
        The clock, and the tick at which it begins.
    view
        The warehouse as rules see it.
    observers
        Everyone who is told what happens.
    asker
        Asks rules.
    after
        Returns the event that happens so many ticks later; its value may be what a state tells of it.
    """

    def __init__(self, scenario: Scenario, rules: RuleSet, warehouse: Warehouse, *, begun: bool = False) -> None:
        self.begun = begun
        self.scenario = scenario
        self.rules = rules
        self.warehouse = warehouse
        self.env, self.began = Clock(warehouse.now), warehouse.now
        self.after: Callable[..., simpy.Event] = self.env.timeout
        self.view = WarehouseView(warehouse)
        self.observers = Observers(rules, warehouse)
        self.asker = Asker(warehouse, scenario.run.decision_limit_s, self.observers)
        self.tell = self.observers.tell
        self._streams: dict[int, np.random.Generator] = {}
        self._tables_before_s = warehouse.travel.seconds

    def ask(
        self,
        rule: BoundRule,
        view: WarehouseView | None = None,
        hook: pluggy.HookCaller | None = None,
        **arguments: Any,
    ) -> tuple[Any, float]:
        """Ask a rule, with the whole view unless another is given; return its answer and the seconds it took."""
        arguments["warehouse"] = view or self.view
        arguments["rng"] = self._streams.get(id(rule)) or self.stream(rule)
        return self.asker.ask(rule, arguments, hook)

    def apply(self, rule: BoundRule, apply: Callable[..., T], answer: object, **arguments: Any) -> T:
        """Check and apply a decision. Observers are told when all of it was possible; else of nothing."""
        events: list[Event] = []
        done = self.asker.apply(rule, lambda: apply(self.warehouse, answer, keep=events.append, **arguments))
        for event in events:
            self.tell(event)
        return done

    @property
    def profile(self) -> dict[str, float]:
        """Wall-clock seconds by what they went to: travel tables, path queries, the other rules, observers."""
        rules = {name: s - self.asker.tables_in[name] for name, s in self.asker.seconds.items()}
        queries = sum(rules.pop(hook, 0.0) for hook in Role.PP.hooks)
        return {
            "tables": self.warehouse.travel.seconds - self._tables_before_s,
            "queries": queries,
            "rules": sum(rules.values()),
            "observers": self.observers.seconds,
        }

    def stream(self, rule: BoundRule) -> np.random.Generator:
        """Return a rule's random generator: made by role and name, and by number among filters of the same name."""
        if (known := self._streams.get(id(rule))) is not None:
            return known
        same = [other for other in self.rules.filters if other.name == rule.name]
        place = same.index(rule) + 1 if rule in same else None
        self._streams[id(rule)] = rule_stream(self.scenario.seed, rule.role, rule.name, place)
        return self._streams[id(rule)]
