"""The metrics that every table of a run begins with, from its events and nothing else.

Counts, distances and times are summed as integers and divided once at the end, so that the same events give the same
bytes. A mean over nothing is None.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from rmfs_commands.details.catalogue import METRICS
from rmfs_commands.details.spans import TICKS_PER_HOUR, Number, goes_on, ratio
from rmfs_core.clock import TICKS_PER_S, to_seconds, to_ticks
from rmfs_core.events import (
    DecisionMade,
    Event,
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCancelled,
    OrderCompleted,
    RobotMoved,
    VisitStarted,
)
from rmfs_core.hookspecs import hookimpl
from rmfs_core.world import Instance

if TYPE_CHECKING:
    from rmfs_core.info import RunInfo


class Metrics:
    """Observer that computes these metrics, to be asked for when the run is over."""

    measures: ClassVar = tuple(metric for group in METRICS.values() for metric in group)

    def __init__(self) -> None:
        self.hears: Mapping[type[Event], Sequence[Callable[[Any], None]]] = {
            RobotMoved: (self._moved,),
            ItemPicked: (self._picked,),
            VisitStarted: (self._visited,),
            OrderArrived: (self._arrived,),
            OrderAssigned: (self._assigned,),
            OrderCompleted: (self._completed,),
            OrderCancelled: (self._cancelled,),
            DecisionMade: (self._decided,),
        }
        self.begin(Instance((), (), ()), 0)

    def begin(self, instance: Instance, stations: int, warmup_s: float | None = None, *, goes_on: bool = False) -> None:
        """Start afresh for an instance, a number of stations and a warm-up (all that events do not tell).

        ``goes_on``: orders count as well that had arrived when the run began.
        """
        self.goes_on = goes_on
        self.stations = stations
        self.warmup = to_ticks(warmup_s or 0)
        # By order: when it arrived, its parts (station and period each), when its last line was assigned
        self.arrival_ticks = [order.arrival_tick for order in instance.orders]
        self.parts: dict[int, set[tuple[int, int]]] = {}
        self.assigned_ticks: dict[int, int] = {}
        self.left = len(self.arrival_ticks)
        self.now = self.last_completion = 0
        self.status: str | None = None
        self.picker_free = [0] * stations
        self.split_open: set[int] = set()
        # What is counted from the end of the warm-up on
        self.completed = self.timed = self.picks = self.visits = self.periods = self.stopped_early = 0
        self.backlog_ticks = self.station_ticks = self.handling_ticks = self.split_open_max = 0
        self.metres = [0, 0]  # empty, loaded

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Start afresh."""
        warmup_s = run.scenario.run.warmup_s
        on = goes_on(run, to_ticks(warmup_s or 0))
        self.begin(run.instance, len(run.warehouse.stations), warmup_s, goes_on=on)

    @hookimpl
    def run_ended(self, tick: int, status: str) -> None:
        """Take note of the end."""
        self.now, self.status = tick, status

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Count."""
        for count in self.hears.get(type(event), ()):
            count(event)

    def _moved(self, event: RobotMoved) -> None:
        if event.tick >= self.warmup:
            self.metres[event.pod is not None] += event.distance_m

    def _picked(self, event: ItemPicked) -> None:
        free = self.picker_free[event.station] = event.picker_free_tick
        if free > self.warmup:
            self.handling_ticks += free - max(event.start_tick, self.warmup)
        if event.tick >= self.warmup:
            self.picks += 1
            self._note_split_orders()

    def _visited(self, event: VisitStarted) -> None:
        if event.tick >= self.warmup:
            self.visits += event.station < self.stations  # behind those where orders are picked, bundles are stored

    def _arrived(self, event: OrderArrived) -> None:
        self.arrival_ticks[event.order] = event.tick

    def _assigned(self, event: OrderAssigned) -> None:
        parts = self.parts.setdefault(event.order, set())
        parts.add((event.station, event.period))
        if event.complete:
            self.assigned_ticks[event.order] = event.tick
        if len(parts) > 1 or not event.complete:
            self.split_open.add(event.order)
        else:  # several assignments of one decision, all to one station, are one part
            self.split_open.discard(event.order)

    def _note_split_orders(self) -> None:
        """Update the maximum. Decisions take no time, so it is enough to look when one is over: before a pick."""
        self.split_open_max = max(self.split_open_max, len(self.split_open))

    def _completed(self, event: OrderCompleted) -> None:
        self.left -= 1
        self.last_completion = event.tick
        if event.tick >= self.warmup:
            self._note_split_orders()
            arrived, assigned = self.arrival_ticks[event.order], self.assigned_ticks.get(event.order, event.tick)
            self.completed += 1
            if self.goes_on or arrived >= self.warmup:
                self.timed += 1
                self.backlog_ticks += assigned - arrived
                self.station_ticks += event.tick - assigned
        self.split_open.discard(event.order)

    def _cancelled(self, event: OrderCancelled) -> None:  # noqa: ARG002
        self.left -= 1

    def _decided(self, event: DecisionMade) -> None:
        if event.tick >= self.warmup:
            self.periods += event.decides.assigns
            self.stopped_early += event.stopped_early

    @property
    def complete(self) -> bool:
        """Whether no order is left."""
        return self.left == 0

    @property
    def simulated_ticks(self) -> int:
        """Time of the last completed order; of the run's end when orders are left."""
        return self.last_completion if self.complete else self.now

    @property
    def busy_ticks(self) -> int:
        """Time pickers handled items, summed over the stations, up to then."""
        beyond = sum(max(0, free - self.simulated_ticks) for free in self.picker_free)
        return self.handling_ticks - beyond

    @hookimpl
    def measured(self) -> dict[str, Number]:
        """Every one of them by name; `rmfs_commands.details.catalogue` has their meanings and units."""
        self._note_split_orders()
        simulated, done, timed = self.simulated_ticks, self.completed, self.timed * TICKS_PER_S
        counted = max(simulated - self.warmup, 0)
        (empty_m, loaded_m), distance = self.metres, sum(self.metres)
        turnover = self.backlog_ticks + self.station_ticks
        return {
            "orders_completed": done,
            "orders_total": len(self.arrival_ticks),
            "picks": self.picks,
            "pod_station_visits": self.visits,
            "psv_per_order": ratio(self.visits, done),
            "pile_on": ratio(self.picks, self.visits),
            "distance_m": distance,
            "distance_per_order_m": ratio(distance, done),
            "loaded_distance_m": loaded_m,
            "empty_distance_m": empty_m,
            "turnover_s": ratio(turnover, timed),
            "turnover_backlog_s": ratio(self.backlog_ticks, timed),
            "turnover_station_s": ratio(self.station_ticks, timed),
            "makespan_s": to_seconds(simulated) if self.complete else None,
            "simulated_s": to_seconds(simulated),
            "orders_per_hour": ratio(done * TICKS_PER_HOUR, counted),
            "picks_per_hour": ratio(self.picks * TICKS_PER_HOUR, counted),
            "picker_utilisation": ratio(self.busy_ticks, self.stations * counted),
            "split_orders_open_max": self.split_open_max,
            "periods": self.periods,
            "solves_stopped_early": self.stopped_early,
        }
