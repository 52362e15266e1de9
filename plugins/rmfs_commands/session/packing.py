"""Packing on a real floor: totes and packers' tasks end with facts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import simpy
from attrs import define

from rmfs_commands.processes.packing import Packing
from rmfs_core.simulation.driving.base import Process
from rmfs_core.warehouse import Order, PackingTask, Request

ENDS = {"convey": "part_arrived", "put": "part_packed", "pack": "order_packed"}
"""By what is going on, the fact that ends it."""


@define
class _Run:
    """A run whose times are left to facts while ``silent``."""

    given: Any
    silent: bool = False

    def __getattr__(self, name: str) -> Any:
        return getattr(self.given, name)

    def after(self, ticks: int, value: object = None) -> simpy.Event:
        """Return what happens so many ticks later, or nothing that ever happens."""
        event: simpy.Event = self.given.env.event() if self.silent else self.given.after(ticks, value)
        return event


class FloorPacking(Packing):
    """Conveyors and packing stations whose tasks end with facts.

    Parameters
    ----------
    run
        As for a run.
    command
        Takes each command.

    Attributes
    ----------
    waits
        By kind (`ENDS`) and number of the tote (``pack``: id of the order): what happens with the fact, and since when.
    """

    def __init__(self, run: Any, command: Callable[..., None]) -> None:
        self._real, self._silent, self._command = run.context, _Run(run.context), command
        super().__init__(run, self._silent)  # type: ignore[arg-type]
        self.waits: dict[tuple[str, int], tuple[simpy.Event, int]] = {}

    def released(self, request: Request, handled_tick: int) -> None:  # noqa: ARG002
        """Put an item into its order's tote; it is handled now, whenever that was expected."""
        super().released(request, self._real.warehouse.now)

    def visit_ended(self, station: int, handled_tick: int) -> Process:  # noqa: ARG002
        """Let totes leave that take what is picked in one visit, once its last item is handled."""
        if self._real.warehouse.stations[station].in_hand is not None:
            yield self._wait_for("handled", station)
        yield from super().visit_ended(station, self._real.warehouse.now)

    def happens(self, kind: str, who: int) -> bool:
        """Let go on what waits for a fact, if anything does."""
        if (kind, who) not in self.waits:
            return False
        self.waits.pop((kind, who))[0].succeed()
        return True

    def _wait_for(self, kind: str, who: int) -> simpy.Event:
        event: simpy.Event = self._real.env.event()
        self.waits[kind, who] = event, self._real.warehouse.now
        return event

    def send(self, order: Order, items: int, picking: int, handled_tick: int) -> Process:
        story = super().send(order, items, picking, handled_tick)
        self._step(story)
        yield self._real.after(0)
        self._step(story)
        tote, packing = self.number, self._real.warehouse.packing_of(order).station
        self._command("send_part", order=order.id, tote=tote, station=picking, packing=packing, items=items)
        yield self._wait_for("convey", tote)
        self._step(story)

    def _work(self, at: int, task: PackingTask) -> Process:
        story = super()._work(at, task)
        self._step(story)
        if task.kind == "put":
            self._command("put_next", packing=at, order=task.order.id, tote=task.tote)
        else:
            self._command("pack_next", packing=at, order=task.order.id)
        yield self._wait_for(task.kind, task.tote if task.kind == "put" else task.order.id)
        self._step(story)

    def begin_tasks(self, at: int) -> None:
        was, self._silent.silent = self._silent.silent, False  # packing stations open by the clock
        super().begin_tasks(at)
        self._silent.silent = was

    def _step(self, story: Iterator[Any]) -> None:
        """Let a story go on to where it waits next, or ends."""
        self._silent.silent = True
        next(story, None)
        self._silent.silent = False
