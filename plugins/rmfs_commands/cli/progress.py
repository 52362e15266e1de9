"""The display of a run: live on a terminal, plain lines elsewhere."""

from __future__ import annotations

import math
import time
from collections.abc import Collection
from textwrap import wrap
from typing import TYPE_CHECKING

from attrs import define, field
from rich.console import Console, RenderableType
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from rmfs_commands.cli.display import Display, PanelDisplay, duration, figures, progress_bar
from rmfs_commands.cli.screen import PIPE_WIDTH
from rmfs_commands.processes.events import OrderPacked, PartArrived, PartSent
from rmfs_core.clock import to_seconds
from rmfs_core.events import (
    BundleStored,
    DecisionMade,
    Event,
    ItemPicked,
    OrderCancelled,
    OrderCompleted,
    PodMoveDecided,
    PodStored,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.hookspecs import hookimpl
from rmfs_core.wording import counted

if TYPE_CHECKING:
    from rmfs_core.info import RunInfo
    from rmfs_core.warehouse import Robot, Station

REFRESH_S = 0.125
SLOT_S = 60
"""Simulated seconds per character of the throughput's line at first."""
MOST_SLOTS = 120
"""With more of them two become one."""
RISING, RISING_ASCII = " ▁▂▃▄▅▆▇█", " .:-=+*#@"
EVENTS_PER_LOOK = 16
"""The clock is looked at only once in so many events: that is what keeps the display from costing anything."""
NARROW = 100
MOST_NAMED = 3
COUNT_FROM_BEFORE = VisitStarted, VisitEnded, PodMoveDecided, PodStored, PartSent, PartArrived
"""Events told of what was before a run began that say what stands at stations, which robots move pods, and which totes
are on conveyors, now."""


@define
class Throughput:
    """Picks by the time since the run began, in slots that get longer as the run does.

    Parameters
    ----------
    slot_s
        Seconds of a slot.
    picks
        Picks in each slot so far, first to last.
    """

    slot_s: int = SLOT_S
    picks: list[int] = field(factory=lambda: [0])

    def add(self, tick: int) -> None:
        """Count a pick."""
        while (slot := int(to_seconds(tick) // self.slot_s)) >= MOST_SLOTS:
            pairs = zip(self.picks[::2], [*self.picks[1::2], 0], strict=False)
            self.picks = [one + other for one, other in pairs]
            self.slot_s *= 2
        self.picks += [0] * (slot + 1 - len(self.picks))
        self.picks[slot] += 1

    def an_hour(self, tick: int) -> float:
        """Return the picks per hour of the last whole slot, or of the time so far."""
        slot = int(to_seconds(tick) // self.slot_s)
        if slot == 0:
            return self.picks[0] * 3600 / max(to_seconds(tick), 1.0)
        return (self.picks[slot - 1] if slot <= len(self.picks) else 0) * 3600 / self.slot_s

    def line(self, tick: int, width: int, signs: str) -> str:
        """Return the picks of all whole slots as a line of at most so many signs, from the lowest to the highest."""
        slots = int(to_seconds(tick) // self.slot_s)
        picks = [*self.picks, *[0] * slots][:slots]
        if not any(picks):
            return ""
        each = -(-slots // width)
        sums = [sum(picks[i : i + each]) / len(picks[i : i + each]) for i in range(0, slots, each)]
        return "".join(signs[math.ceil((len(signs) - 1) * one / max(sums))] for one in sums)


@define
class RunCounts:
    """State of a run so far, for both displays.

    ``total`` are the orders without cancelled ones, ``picking`` the pods that are at stations, by the
    station, ``moving`` the robots that carry pods elsewhere without a visit, or come for them; ``totes`` are on
    conveyors, ``packed`` is None without packing stations. A run that begins in a state has ``began`` at its tick:
    what was over before, as ``since`` tells, does not count.
    """

    total: int = 0
    orders: int = 0
    cancelled: int = 0
    picks: int = 0
    visits: int = 0
    stopped_early: int = 0
    stored: int = 0
    totes: int = 0
    packed: int | None = None
    picks_at: list[int] = field(factory=list)
    picking: dict[int, int] = field(factory=dict)
    moving: set[int] = field(factory=set)
    throughput: Throughput = field(factory=Throughput)
    began: int = 0
    since: int = 0

    @classmethod
    def of(cls, run: RunInfo) -> RunCounts:
        """Return the counts at the start of a run."""
        packed = 0 if run.warehouse.packing_stations else None
        counts = cls(total=len(run.instance.orders), picks_at=[0] * len(run.layout.stations), packed=packed)
        if (began := run.began) is not None:
            counts.began, counts.since = began, run.since
        return counts

    @property
    def done(self) -> int:
        """Orders that nothing is left to do of: packed, or picked without packing stations."""
        return self.orders if self.packed is None else self.packed

    def add(self, event: Event) -> None:
        """Count an event."""
        if (before := event.tick < self.since) and not isinstance(event, COUNT_FROM_BEFORE):
            self.total -= isinstance(event, OrderCancelled | (OrderCompleted if self.packed is None else OrderPacked))
            return
        match event:
            case ItemPicked():
                self.picks += 1
                self.picks_at[event.station] += 1
                self.throughput.add(event.tick - self.began)
            case VisitStarted():
                self.visits += not before
                self.picking[event.station] = event.pod
            case VisitEnded():
                self.picking.pop(event.station, None)
            case OrderCompleted():
                self.orders += 1
            case PartSent() | PartArrived():
                self.totes += 1 if isinstance(event, PartSent) else -1
            case OrderPacked():
                self.packed = (self.packed or 0) + 1
            case OrderCancelled():
                self.cancelled += 1
                self.total -= 1
            case BundleStored():
                self.stored += 1
            case PodMoveDecided():
                self.moving.add(event.robot)
            case PodStored():
                self.moving.discard(event.robot)
            case DecisionMade():
                self.stopped_early += event.stopped_early

    def elapsed(self, tick: int) -> float:
        """Return the simulated seconds since the run began."""
        return to_seconds(max(tick - self.began, 0))

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
    storing = len(only_storing(run))
    more = f"{counted(storing, 'replenishment station')}, " if storing else ""
    return (
        f"{counted(len(instance.orders), 'order')}, {counted(len(instance.skus), 'SKU')}, "
        f"{counted(len(instance.pods), 'pod')}, {counted(len(warehouse.stations), 'station')}, "
        f"{more}{counted(len(warehouse.robots), 'robot')}, seed {run.scenario.seed}"
        f"{'' if (began := run.began) is None else f', from {duration(to_seconds(began))} on'}"
    )


class RunLines(Display):
    """Observer that writes a line at the start, one for every tenth of the orders, and one at the end.

    The lines say nothing of wall-clock time, so equal runs write equal lines; they fit `PIPE_WIDTH` columns.

    Parameters
    ----------
    name
        Name of the run.
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
                f"{10 * tenths:3d} %  {duration(counts.elapsed(event.tick))} simulated, {counts.picks:,} picks, "
                f"{counts.psv_per_order} visits per order, pile-on {counts.pile_on}"
            )

    @hookimpl
    def run_ended(self, tick: int, status: str) -> None:
        """Write the last line."""
        counts = self.counts
        stopped = f", {counts.stopped_early:,} solves stopped early" if counts.stopped_early else ""
        besides = [(counts.packed, "packed"), (counts.cancelled or None, "cancelled")]
        told = ", ".join(f"{number:,} {what}" for number, what in besides if number is not None)
        orders = f"{counts.orders:,} of {counts.total:,} orders{told and f' ({told})'}"
        self.line(f"{status}: {orders}, {duration(counts.elapsed(tick))} simulated{stopped}")


class RunPanel(PanelDisplay):
    """Observer that shows a run on a terminal while it goes on.

    Parameters
    ----------
    name
        Name of the run.
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
        """Remove the display; the table of metrics replaces it."""
        self.close()

    def _refresh(self) -> None:
        self.refresh()
        self._next_refresh = time.perf_counter() + REFRESH_S

    def picture(self) -> RenderableType:
        """Return what the display shows now."""
        assert self._run is not None
        bar = progress_bar("Orders", self.counts.orders, self.counts.total)
        parts = (bar, self._figures(), self._lines(self._run), self._stations(self._run))
        return self.panel(f"seed {self._run.scenario.seed} ", *parts)

    def _figures(self) -> RenderableType:
        """Pairs of a name and a figure: three pairs a row where they fit, else two."""
        assert self._run is not None
        counts = self.counts
        wall = time.perf_counter() - self._started
        simulated = counts.elapsed(self._tick)
        left = wall * (counts.total - counts.done) / counts.done if counts.done else None
        pairs: list[tuple[str, str | Text]] = [
            ("Simulated time", duration(simulated)),
            ("Picks", f"{counts.picks:,}"),
            ("Backlog", counted(len(self._run.warehouse.backlog), "order")),
            ("Simulated s per s", f"{simulated / wall:,.0f}" if wall else "-"),
            ("Visits per order", counts.psv_per_order),
            ("Pile-on", counts.pile_on),
            ("Time used", duration(wall)),
            ("Ends in about", "-" if left is None else duration(left)),
        ]
        if self._run.warehouse.replenishment_stations:
            pairs.append(("Bundles", f"{len(self._run.warehouse.bundles):,} wait, {counts.stored:,} stored"))
        if (free := self._run.warehouse.free_boxes) is not None:
            boxes = sum(station.section.boxes for station in self._run.warehouse.packing_stations)
            pairs += [("Boxes in use", f"{boxes - free:,} of {boxes:,}"), ("Packed", counted(counts.done, "order"))]
        if counts.stopped_early:
            pairs.append(("Stopped early", f"{counts.stopped_early:,} solves"))
        return figures(pairs, per_row=2 if self.console.width < NARROW else 3)

    def _lines(self, run: RunInfo) -> RenderableType:
        """Robots by what they do, and the throughput so far."""
        grid = Table.grid(padding=(0, 2))
        grid.add_column(style="dim", no_wrap=True)
        grid.add_column(no_wrap=True)
        grid.add_row("Robots", said_of_robots(run, self.counts.moving))
        if chargers_fail(run):
            grid.add_row("Chargers", said_of_chargers(run))
        if run.warehouse.packing_stations:
            grid.add_row("Packing", said_of_packing(run, self.counts.totes))
        signs = RISING_ASCII if self.console.options.ascii_only else RISING
        room = max(self.console.width - 48, 10)
        counts, since = self.counts, max(self._tick - self.counts.began, 0)
        line = counts.throughput.line(since, room, signs)
        now = f"{counts.throughput.an_hour(since):,.0f} picks per hour"
        grid.add_row("Throughput", Text.assemble((line, "cyan"), f" {now}" if line else now))
        return grid

    def _stations(self, run: RunInfo) -> RenderableType:
        table = Table(box=None, expand=True, padding=(0, 1, 0, 0), header_style="dim")
        table.add_column("Station", no_wrap=True)
        table.add_column("Load", no_wrap=True)
        bundles = ("Bundles",) if run.warehouse.replenishment_stations else ()
        for name in ("Pod", "Inbound", "Requests", *bundles, "Picks"):
            table.add_column(name, justify="right", no_wrap=True)
        table.add_column("Waits for", no_wrap=True, ratio=1)
        stations = (*run.warehouse.stations, *only_storing(run))
        above = 19 if run.warehouse.packing_stations else 17
        room = max(self.console.height - above - chargers_fail(run), 1)
        for station in stations[:room]:
            table.add_row(*self._station(run, station))
        if len(stations) > room:
            table.add_row(f"and {len(stations) - room} more", style="dim")
        return table

    def _station(self, run: RunInfo, station: Station) -> tuple[RenderableType, ...]:
        bar = 8 if self.console.width < NARROW else 24
        picks = station.id < len(run.warehouse.stations)
        load = Table.grid(padding=(0, 1))
        load.add_column()
        load.add_column(justify="right", min_width=5)
        used, most = (station.load, station.capacity) if picks else (len(station.bundles), station.bundle_capacity)
        load.add_row(ProgressBar(total=most, completed=used, width=bar), f"{used}/{most}")
        picking = self.counts.picking.get(station.id)
        bundles = [str(len(station.bundles))] if run.warehouse.replenishment_stations else []
        return (
            station.name,
            load,
            "-" if picking is None else run.warehouse.pods[picking].name,
            str(len(station.inbound_pods)),
            str(station.open_items) if picks else "-",
            *bundles,
            f"{self.counts.picks_at[station.id]:,}" if picks else "-",
            waits_for(run, station) if picking is None or not station.in_service else "-",
        )


def only_storing(run: RunInfo) -> tuple[Station, ...]:
    """Return the stations that store bundles and do nothing else."""
    picking = len(run.warehouse.stations)
    return tuple(station for station in run.warehouse.replenishment_stations if station.id >= picking)


def robots_by_state(run: RunInfo, moving: Collection[int] = ()) -> dict[str, int]:
    """Return how many robots do what.

    They fetch a pod, carry one, or stand in a station's line with it; they carry one elsewhere without a visit
    (``moving`` has their ids), are on their way to rest, charge, are too low for a task, off duty, out of
    service, or idle.
    """
    warehouse = run.warehouse
    in_line = {robot.id for station in (*warehouse.stations, *only_storing(run)) for robot in station.line}
    names = (
        "fetch",
        "carry",
        "in line",
        "move pods",
        "go to rest",
        "charge",
        "low",
        "off duty",
        "out of service",
        "idle",
    )
    states = dict.fromkeys(names, 0)
    for robot in warehouse.robots:
        states[_state(robot, robot.id in in_line, robot.id in moving, run.layout.chargers)] += 1
    return states


def _state(robot: Robot, in_line: bool, moves: bool, chargers: Collection[int]) -> str:
    if robot.task is not None:
        return "move pods" if moves else "in line" if in_line else "fetch" if robot.pod is None else "carry"
    if robot.goal is not None:
        return "charge" if robot.charge is not None and robot.cell == robot.goal in chargers else "go to rest"
    if not robot.in_service:
        return "out of service"
    return "off duty" if not robot.on_duty else "low" if robot.low else "idle"


def said_of_robots(run: RunInfo, moving: Collection[int]) -> str:
    """Say how many robots do what, and of what only some runs have, what there is."""
    states, always = robots_by_state(run, moving), ("fetch", "carry", "in line", "idle")
    return ", ".join(f"{number} {state}" for state, number in states.items() if number or state in always)


def chargers_fail(run: RunInfo) -> bool:
    """Whether chargers may be out of service."""
    battery = run.scenario.robots.battery
    return battery is not None and battery.charger_outages is not None


def said_of_chargers(run: RunInfo) -> str:
    """Say how many chargers are in service, and which are not."""
    down = sorted({*run.layout.chargers} - {*run.warehouse.chargers})
    cells = ", ".join(f"row {cell // run.layout.width + 1} column {cell % run.layout.width + 1}" for cell in down)
    told = f"{len(run.layout.chargers) - len(down):,} in service, {len(down):,} out of service"
    return f"{told}: {cells}" if 0 < len(down) <= MOST_NAMED else told


def said_of_packing(run: RunInfo, totes: int) -> str:
    """Say what is on conveyors, what waits at packing stations, and who is at work there."""
    stations = run.warehouse.packing_stations
    waiting, working = (sum(map(len, found)) for found in zip(*((s.tasks, s.working) for s in stations), strict=True))
    section = stations[0].section
    crew = "packers and sorters" if section.sorters else "packers"
    there = len(stations) * (section.packers + section.sorters)
    return f"{counted(totes, 'tote')} on conveyors, {waiting:,} waiting, {working:,} of {there:,} {crew} at work"


def waits_for(run: RunInfo, station: Station) -> str:
    """Say what a station waits for: to be repaired, or of all it needs that which is nearest; or that it is closed."""
    robots = run.warehouse.robots
    if not station.in_service:
        return "its repair"
    if not (station.open_requests or station.bundles):
        picks = station.id < len(run.warehouse.stations)
        return "bundles" if not picks else "orders" if station.open else "closed"
    if station.pods_in_line:
        return f"pod {run.warehouse.pods[station.pods_in_line[0]].name}, in line"
    carried, tasks = {robot.pod for robot in robots}, {robot.task for robot in robots}
    for which, how in ((carried, "carried"), (tasks, "being fetched")):
        found = [pod for pod in station.inbound_pods if pod.id in which]
        if found:
            return f"pod {found[0].name}, {how}"
    return f"a robot for pod {station.inbound_pods[0].name}" if station.inbound_pods else "a pod"


RunDisplay = RunPanel | RunLines


def run_display(console: Console, name: str) -> RunDisplay:
    """Return the display that suits where the output goes."""
    return RunPanel(name, console) if console.is_terminal else RunLines(name, console)
