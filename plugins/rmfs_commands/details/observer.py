"""The observer of every run: hours.csv, stations.csv, robots.csv and delays.csv, and metrics made of the same.

Where there is replenishment, bundles.csv and stock.csv as well; packing.csv where there are packing stations, and
departures.csv where trucks leave.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

from rmfs_commands.details import costs, departures
from rmfs_commands.details.bottleneck import Bottleneck
from rmfs_commands.details.catalogue import MEASURES
from rmfs_commands.details.delays import Delays
from rmfs_commands.details.energy import Energy
from rmfs_commands.details.hours import Hours
from rmfs_commands.details.measures import Measures
from rmfs_commands.details.outages import Outages
from rmfs_commands.details.packing import COLUMNS as PACKING_COLUMNS
from rmfs_commands.details.packing import Packing
from rmfs_commands.details.replenishment import BUNDLE_COLUMNS, STOCK_COLUMNS, Replenishment
from rmfs_commands.details.robots import Robots
from rmfs_commands.details.spans import Number, ratio
from rmfs_commands.details.stations import Stations
from rmfs_commands.results.files import to_csv, write_text
from rmfs_core.clock import TICKS_PER_S, to_ticks
from rmfs_core.events import BundleStored, Event, QueueJoined, VisitEnded, VisitStarted
from rmfs_core.hookspecs import hookimpl

if TYPE_CHECKING:
    from rmfs_core.info import RunInfo

HOURS, STATIONS, ROBOTS, DELAYS = "hours.csv", "stations.csv", "robots.csv", "delays.csv"
BUNDLES, STOCK = "bundles.csv", "stock.csv"
"""Of runs with replenishment."""
PACKING = "packing.csv"
"""Of runs with packing stations."""
DEPARTURES = "departures.csv"
"""Of runs with `instance.departures`."""


def _below(
    stations: int, handler: Callable[[Any], None], event: BundleStored | QueueJoined | VisitStarted | VisitEnded
) -> None:
    """Hand on what happens at picking stations, whose ids are below those of replenishment stations."""
    if event.station < stations:
        handler(event)


class Details:
    """Observer that follows hours, stations, robots, orders and bundles."""

    files: ClassVar = (HOURS, STATIONS, ROBOTS, DELAYS, BUNDLES, STOCK, PACKING, DEPARTURES)
    measures: ClassVar = MEASURES

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Start afresh."""
        self._run, self._out = run, run.out
        self._begin = self._end = to_ticks(run.scenario.run.warmup_s or 0)
        self._over = 0
        self._hours, self._stations, self._robots = Hours(run), Stations(run), Robots(run, self._begin)
        self._delays, self._measures = Delays(run, self._begin, self._robots), Measures(run, self._begin)
        self._energy = Energy(run, self._begin)
        self._handlers: dict[type[Event], list[Callable[[Any], None]]] = {}
        self._replenishment = Replenishment(run, self._begin)
        self._packing = Packing(run, self._begin)
        self._outages = Outages(run, self._begin)
        more = self._replenishment, self._energy, self._packing, self._outages
        picking, last = (self._hours, self._stations, self._measures), len(run.warehouse.stations)
        for part in (self._hours, self._stations, self._robots, self._delays, self._measures, *more):
            for kind, handler in part.handlers.items():
                at_both = kind in (BundleStored, QueueJoined, VisitStarted, VisitEnded)
                told = at_both and part in picking and run.layout.replenishing
                self._handlers.setdefault(kind, []).append(partial(_below, last, handler) if told else handler)

    @property
    def hears(self) -> Mapping[type[Event], Sequence[Callable[[Any], None]]]:
        """The followers of each kind of event."""
        return self._handlers

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Hand the event to the observers of its kind."""
        for handle in self._handlers.get(type(event), ()):
            handle(event)

    @hookimpl
    def run_ended(self, tick: int) -> None:
        """Say what limits the run, and write the files, where results are kept."""
        self._over, self._end = tick, max(tick, self._begin)
        followed = self._stations, self._robots, self._delays, self._packing
        self._run.summary["bottleneck"] = Bottleneck(self._run, self._begin, self._end, *followed).summary()
        if (said := self._outages.says(self._end)) is not None:
            self._run.summary["outages"] = said
        if self._out is None:
            return
        write_text(self._out / DELAYS, to_csv(("order", "turnover_s", *self._delays.columns), self._delays.rows()))
        self._packing.hourly(hours := self._hours.rows(tick, self._energy.metres(), self._outages.hourly()), tick)
        for name, rows in (
            (HOURS, hours),
            (STATIONS, self._stations.rows(self._begin, self._end)),
            (ROBOTS, self._robots.rows(self._end)),
        ):
            write_text(self._out / name, to_csv(list(rows[0]), rows))
        if self._replenishment.on:
            write_text(self._out / BUNDLES, to_csv(BUNDLE_COLUMNS, self._replenishment.bundles()))
            write_text(self._out / STOCK, to_csv(STOCK_COLUMNS, self._replenishment.stock(tick)))
        if self._packing.on:
            write_text(self._out / PACKING, to_csv(PACKING_COLUMNS, self._packing.rows()))
        if self._run.scenario.instance.departures is not None:
            write_text(self._out / DEPARTURES, to_csv(departures.COLUMNS, departures.rows(*self._leaving)))

    @property
    def _done(self) -> Mapping[int, int]:
        """When orders were done: packed, where packing is simulated, else picked."""
        return self._packing.packed_ticks if self._packing.on else self._measures.completed_ticks

    @hookimpl
    def measured(self) -> dict[str, Number]:
        """Every metric of `rmfs_commands.details.catalogue` by name."""
        visits_ticks = self._measures.visits * TICKS_PER_S
        return {
            **self._measures.values(self._end, self._until),
            **self._measures.left(self._over),
            **self._stations.values(self._begin, self._end),
            "waiting_per_visit_s": ratio(self._robots.waiting_ticks, visits_ticks),
            "waiting_for_room_per_visit_s": ratio(self._robots.for_room_ticks, visits_ticks),
            **self._replenishment.values(self._end, self._delays.values()),
            **self._packing.values(self._end),
            **self._packing.left(self._over),
            **self._energy.values(self._measures.completed),
            **self._robots.values(self._end, self._measures.completed),
            **self._outages.values(self._end),
            **self._departed(),
            **self._costs(),
        }

    def _departed(self) -> dict[str, Number]:
        if self._run.scenario.instance.departures is None:
            return {}
        return departures.values(*self._leaving)

    @property
    def _leaving(self) -> tuple[departures.DueOrders, int, int | None]:
        """Orders that trucks take or leave behind, and the end and the horizon of the run."""
        return list(self._measures.due(self._done)), self._end, self._until

    @property
    def _until(self) -> int | None:
        """Tick of the horizon."""
        until_s = self._run.scenario.run.until_s
        return None if until_s is None else to_ticks(until_s)

    def _costs(self) -> dict[str, Number]:
        scenario, whole = self._run.scenario, self._end - self._begin
        if scenario.costs is None:
            return {}
        robots = len(self._run.warehouse.robots) * whole
        paid = {"pickers": self._stations.paid_ticks(self._begin, self._end)}
        if self._packing.on:
            paid["packers"] = self._packing.paid_ticks(self._end)
        if self._run.layout.replenishing:
            paid["replenishers"] = self._run.layout.replenishing * whole
        paid["robots"] = robots
        battery = scenario.robots.battery
        if battery is None:
            wh = float(self._energy.values(0)["energy_wh"] or 0)
        else:
            charging = self._robots.spent(self._end)[0]["charging"]
            wh = self._energy.drawn_wh(battery, lambda worked: max(robots - charging - worked, 0))
        dated = any(order.due_tick is not None for order in self._run.instance.orders)
        late = costs.lateness(self._measures.due(self._done), self._end) if dated else None
        done = sum(tick >= self._begin for tick in self._done.values())
        return costs.values(scenario.costs, paid, wh, late, done)
