from __future__ import annotations

from collections.abc import Callable
from typing import Any

from attrs import define, field

from rmfs_core import hookimpl
from rmfs_core.events import Event


@define
class ToldRun:
    """A run, and the events that it has told."""

    simulation: Any = None
    events: list[Event] = field(factory=list)

    @hookimpl
    def on_event(self, event: Event) -> None:
        self.events.append(event)

    @property
    def warehouse(self) -> Any:
        return self.simulation.warehouse

    def of(self, kind: type) -> list[Any]:
        return [event for event in self.events if isinstance(event, kind)]

    def done(self) -> ToldRun:
        self.simulation.run()
        return self


Prepare = Callable[..., ToldRun]
