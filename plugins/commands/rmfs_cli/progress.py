"""The display of a run: live on a terminal, plain lines elsewhere."""

from __future__ import annotations

import time
from textwrap import wrap
from typing import TYPE_CHECKING

from attrs import define, field
from rich.console import Console, RenderableType
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from rmfs_cli.display import Display, PanelDisplay, duration, figures, progress_bar
from rmfs_cli.screen import PIPE_WIDTH
from rmfs_core.clock import to_seconds
from rmfs_core.events import DecisionMade, Event, ItemPicked, OrderCompleted, VisitStarted
from rmfs_core.hookspecs import hookimpl
from rmfs_core.wording import counted

if TYPE_CHECKING:
    from rmfs_core.info import RunInfo
    from rmfs_core.warehouse import Station

REFRESH_S = 0.125
EVENTS_PER_LOOK = 16
"""The clock is looked at only once in so many events: that is what keeps the display from costing anything."""
NARROW = 100


@define
class RunCounts:
    """What both displays show of a run so far."""

    total: int = 0
    orders: int = 0
    picks: int = 0
    visits: int = 0
    stopped_early: int = 0
    picks_at: list[int] = field(factory=list)

    @classmethod
    def of(cls, run: RunInfo) -> RunCounts:
        """Return the counts at the start of a run."""
        return cls(total=len(run.instance.orders), picks_at=[0] * len(run.layout.stations))

    def add(self, event: Event) -> None:
        """Count an event."""
        match event:
            case ItemPicked():
                self.picks += 1
                self.picks_at[event.station] += 1
            case VisitStarted():
                self.visits += 1
            case OrderCompleted():
                self.orders += 1
            case DecisionMade():
                self.stopped_early += event.stopped_early

    @property
    def psv_per_order(self) -> str:
        """Pod-station visits per completed order."""
        return f"{self.visits / self.orders:.2f}" if self.orders else "-"

    @property
    def pile_on(self) -> str:
        """Picks per pod-station visit."""
        return f"{self.picks / self.visits:.2f}" if self.visits else "-"


def about(run: RunInfo) -> str:
    """Say what a run is in one line: its size and its seed."""
    instance, warehouse = run.instance, run.warehouse
    return (
        f"{counted(len(instance.orders), 'order')}, {counted(len(instance.skus), 'SKU')}, "
        f"{counted(len(instance.pods), 'pod')}, {counted(len(warehouse.stations), 'station')}, "
        f"{counted(len(warehouse.robots), 'robot')}, seed {run.scenario.seed}"
    )


class RunLines(Display):
    """Observer that writes a line at the start, one for every tenth of the orders, and one at the end.

    The lines say nothing of wall-clock time, so equal runs write equal lines; they fit `PIPE_WIDTH` columns.

    Parameters
    ----------
    name
        What the run is called.
    console
        Where the lines go.
    """

    def __init__(self, name: str, console: Console) -> None:
        super().__init__(name, console)
        self.counts = RunCounts()

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Write the first line."""
        self.counts = RunCounts.of(run)
        for line in wrap(f"{self.name}: {about(run)}", PIPE_WIDTH, subsequent_indent="  "):
            self.line(line)

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Write a line when another tenth of the orders is complete."""
        counts = self.counts
        before = counts.orders
        counts.add(event)
        if counts.orders == before:
            return
        tenths = 10 * counts.orders // counts.total
        if tenths > 10 * before // counts.total and tenths < 10:
            self.line(
                f"{10 * tenths:3d} %  {duration(to_seconds(event.tick))} simulated, {counts.picks:,} picks, "
                f"{counts.psv_per_order} visits per order, pile-on {counts.pile_on}"
            )

    @hookimpl
    def run_ended(self, tick: int, status: str) -> None:
        """Write the last line."""
        counts = self.counts
        stopped = f", {counts.stopped_early:,} solves stopped early" if counts.stopped_early else ""
        self.line(
            f"{status}: {counts.orders:,} of {counts.total:,} orders, {duration(to_seconds(tick))} simulated{stopped}"
        )


class RunPanel(PanelDisplay):
    """Observer that shows a run on a terminal while it goes on.

    Parameters
    ----------
    name
        What the run is called.
    console
        The terminal.
    """

    def __init__(self, name: str, console: Console) -> None:
        super().__init__(name, console)
        self.counts = RunCounts()
        self._run: RunInfo | None = None
        self._started = self._next_refresh = 0.0
        self._until_look = 0
        self._tick = 0

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Open the display."""
        self.counts = RunCounts.of(run)
        self._run = run
        self._started = time.perf_counter()
        self.open()
        self._refresh()

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Count, and from time to time show."""
        self.counts.add(event)
        self._tick = event.tick
        self._until_look -= 1
        if self._until_look <= 0:
            self._until_look = EVENTS_PER_LOOK
            if time.perf_counter() >= self._next_refresh:
                self._refresh()

    @hookimpl
    def run_ended(self) -> None:
        """Take the display away; the table of metrics takes its place."""
        self.close()

    def _refresh(self) -> None:
        self.refresh()
        self._next_refresh = time.perf_counter() + REFRESH_S

    def picture(self) -> RenderableType:
        """Return what the display shows now."""
        assert self._run is not None
        bar = progress_bar("Orders", self.counts.orders, self.counts.total)
        return self.panel(f"seed {self._run.scenario.seed} ", bar, self._figures(), self._stations(self._run))

    def _figures(self) -> RenderableType:
        """Pairs of a name and a figure: three pairs a row where there is room, else two."""
        assert self._run is not None
        counts, robots = self.counts, self._run.warehouse.robots
        idle = sum(robot.idle for robot in robots)
        wall = time.perf_counter() - self._started
        simulated = to_seconds(self._tick)
        left = wall * (counts.total - counts.orders) / counts.orders if counts.orders else None
        pairs: list[tuple[str, str | Text]] = [
            ("Simulated time", duration(simulated)),
            ("Picks", f"{counts.picks:,}"),
            ("Robots", f"{len(robots) - idle} busy, {idle} idle"),
            ("Simulated s per s", f"{simulated / wall:,.0f}" if wall else "-"),
            ("Visits per order", counts.psv_per_order),
            ("Pile-on", counts.pile_on),
            ("Time used", duration(wall)),
            ("Ends in about", "-" if left is None else duration(left)),
        ]
        if counts.stopped_early:
            pairs.append(("Stopped early", f"{counts.stopped_early:,} solves"))
        return figures(pairs, per_row=2 if self.console.width < NARROW else 3)

    def _stations(self, run: RunInfo) -> RenderableType:
        table = Table(box=None, expand=True, padding=(0, 1, 0, 0), header_style="dim")
        table.add_column("Station", no_wrap=True)
        table.add_column("Load", no_wrap=True)
        for name in ("Pod", "In line", "Inbound", "Requests", "Picks"):
            table.add_column(name, justify="right", no_wrap=True)
        stations = run.warehouse.stations
        room = max(self.console.height - 14, 1)
        for station in stations[:room]:
            table.add_row(*self._station(run, station))
        if len(stations) > room:
            table.add_row(f"and {len(stations) - room} more", style="dim")
        return table

    def _station(self, run: RunInfo, station: Station) -> tuple[RenderableType, ...]:
        line = station.pods_in_line
        bar = 16 if self.console.width < NARROW else 30
        load = Table.grid(padding=(0, 1))
        load.add_column()
        load.add_column(justify="right", min_width=5)
        load.add_row(
            ProgressBar(total=station.capacity, completed=station.load, width=bar), f"{station.load}/{station.capacity}"
        )
        return (
            station.name,
            load,
            run.warehouse.pods[line[0]].name if line else "-",
            str(len(line)),
            str(len(station.inbound_pods)),
            str(len(station.open_requests)),
            f"{self.counts.picks_at[station.id]:,}",
        )


RunDisplay = RunPanel | RunLines


def run_display(console: Console, name: str) -> RunDisplay:
    """Return the display that suits where the output goes."""
    return RunPanel(name, console) if console.is_terminal else RunLines(name, console)
