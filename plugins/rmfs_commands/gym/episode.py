"""One run that stops wherever the caller has to choose."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from threading import get_ident

from attrs import define, evolve, field
from greenlet import GreenletExit, getcurrent, greenlet

from rmfs_commands.gym.choices import PLAIN, Choice, Table
from rmfs_commands.gym.policy import PolicyRule
from rmfs_commands.gym.rewards import Step
from rmfs_commands.results.recorders import make_observers
from rmfs_core import InputError, Result, Scenario, hookimpl
from rmfs_core.events import Event, OrderArrived, OrderCancelled, OrderCompleted
from rmfs_core.results.running import prepare
from rmfs_core.roles import Role
from rmfs_core.rules import with_objects
from rmfs_core.simulation.engine import Simulation
from rmfs_core.warehouse import WarehouseView

_OPENS: dict[type[Event], int] = {OrderArrived: 1, OrderCompleted: -1, OrderCancelled: -1}
"""Change of the number of open orders by each event."""


@define(eq=False)
class Caller(PolicyRule):
    """Rule that hands each choice to the caller that lets the run go on, and waits for the slot.

    It is called deep within a process of the simulation, which is a generator and cannot be left from there. So the
    simulation has a stack of its own, a greenlet.
    """

    shown: Table = field(init=False, default=PLAIN)
    _closed: bool = field(init=False, default=False)

    @classmethod
    def of(cls, table: Table) -> Caller:
        """Return one that is shown choices as a table says."""
        caller = cls(orders_shown=table.orders_shown, pods_shown=table.pods_shown, may_wait=table.may_wait)
        caller.shown = table
        return caller

    @property
    def table(self) -> Table:
        """How choices are shown."""
        return self.shown

    def choose(self, choice: Choice) -> int:
        """Leave the simulation's stack; return what it is entered again with."""
        if self._closed:  # what a process raises ends the run only after the other events of that time
            raise _Left
        try:
            slot: int = getcurrent().parent.switch(choice)
        except GreenletExit:
            self._closed = True
            raise _Left from None
        return slot


class _Left(KeyboardInterrupt):
    """An episode is left before its end: an interrupt, so that no rule is blamed for it."""


def _run(simulation: Simulation, _: object) -> None:
    with suppress(_Left):
        simulation.run()


@define(eq=False)
class _Listening:
    """Observer that keeps what happens until it is asked for, and counts the open orders."""

    events: list[Event] = field(factory=list)
    since_tick: int = 0
    orders_open: int = 0

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Keep an event."""
        self.events.append(event)
        self.orders_open += _OPENS.get(type(event), 0)

    def heard(self, warehouse: WarehouseView) -> Step:
        """Return what has happened since the last time."""
        step = Step(tuple(self.events), warehouse, self.since_tick, self.orders_open)
        self.events, self.since_tick = [], warehouse.now_tick
        return step


class Episode:
    """A run in which some kinds of decisions are the caller's.

    Parameters
    ----------
    scenario
        The scenario that is run.
    decides
        Kinds of the caller's decisions.
    table
        How choices are shown.
    allow_inline_rules
        Whether code may be loaded from files.

    Attributes
    ----------
    simulation
        The run.
    """

    def __init__(
        self, scenario: Scenario, decides: Sequence[Role], table: Table = PLAIN, allow_inline_rules: bool = True
    ) -> None:
        caller = Caller.of(table)  # one for all: none of them goes on when it is closed
        asking = {role.key: caller for role in decides}
        scenario = evolve(scenario, rules=with_objects(scenario.rules, asking))
        self._listening = _Listening()
        self._measured = prepare(
            scenario, asking, [*make_observers(quiet=True), (self._listening, None)], allow_inline_rules
        )
        self.simulation = simulation = self._measured.simulation
        # It does not know the episode: so it ends, if nobody closes it, when the episode is forgotten.
        self._stack = greenlet(partial(_run, simulation))
        self._started, self._thread = time.perf_counter(), get_ident()

    @property
    def complete(self) -> bool:
        """Whether every order is complete."""
        return self.simulation.status == "complete"

    def go_on(self, slot: int | None = None) -> Choice | None:
        """Let the run go on with the slot that was chosen, to the next choice; None when the run is over.

        Raises
        ------
        InputError
            In another thread than that in which the episode was made.
        RunError
            When another rule misbehaves, or the run stands still.
        """
        if self._thread != get_ident():
            raise InputError("step", "the episode was begun in another thread; expected `reset` in this one first")
        self._stack.parent = getcurrent()  # who is asked next is who lets it go on now
        choice: Choice | None = self._stack.switch(slot)
        return choice

    def heard(self) -> Step:
        """Return what has happened since it was last asked for."""
        return self._listening.heard(self.simulation.view)

    def result(self) -> Result:
        """Return what `rmfs_core.run` would; once, when the run is over."""
        measured = self._measured
        measured.status, measured.wall_s = self.simulation.status, time.perf_counter() - self._started
        result = measured.conclude()
        if measured.error is not None:
            raise measured.error
        return result

    def close(self) -> None:
        """End the run wherever it is, and its stack with it; that of another thread ends when it is forgotten."""
        if self._thread == get_ident():
            self._stack.throw()
