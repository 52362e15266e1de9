"""The validation of recorded runs, among the tools for tests, and of the runs that try a rule."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from attrs import define, evolve, field

from rmfs_commands.trace.reader import Trace
from rmfs_commands.trace.writer import header
from rmfs_commands.validation import Fault, faults_of, validate_trace
from rmfs_core.events import DecisionMade, Event
from rmfs_core.hookspecs import hookimpl

if TYPE_CHECKING:
    from rmfs_core.info import RunInfo

__all__ = ["Fault", "Recorder", "validate_trace"]

_SUPPLY = ("pod_capacity", "replenishment")
"""Keys of a scenario about an instance that the instance itself does not have."""


@define(eq=False)
class Recorder:
    """Observer that keeps what a trace would hold; of decisions not what the wall clock says."""

    events: list[Event] = field(factory=list)
    run: RunInfo | None = None
    start: Mapping[str, Any] = field(factory=dict)

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Keep where everything is at the start."""
        self.run, self.start = run, header(run)

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Keep it."""
        self.events.append(evolve(event, wall_s=0.0) if isinstance(event, DecisionMade) else event)

    def faults(self, tick: int, status: str, rules: Mapping[str, str], *, collisions: bool) -> Sequence[Fault]:
        """Return what cannot have happened.

        Parameters
        ----------
        tick, status
            When the run ended, and how.
        rules
            By their keys in a scenario the names of rules that decided instead of the scenario's.
        collisions
            Whether no two robots may hold a cell at once.
        """
        assert self.run is not None
        scenario = self.start["scenario"]
        asked = {key: scenario["instance"][key] for key in _SUPPLY if key in scenario["instance"]}  # the rest it has
        trace = Trace(
            scenario={**scenario, "instance": asked, "rules": {**scenario["rules"], **rules}},
            layout=self.run.layout,
            motion=self.run.motion,
            instance=self.run.instance,
            pods=tuple(self.start["pods"]),
            robots=tuple(self.start["robots"]),
            stations=tuple(self.start["stations"]),
            blocked=tuple(self.start["blocked"]),
            events=tuple(self.events),
            tick=tick,
            status=status,
        )
        return faults_of(trace, collisions=collisions)
