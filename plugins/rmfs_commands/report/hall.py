"""The hall of a run as a picture: where robots drove, and where they waited for others."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import groupby
from typing import Any

from attrs import frozen
from markupsafe import Markup

from rmfs_commands.layouts.drawing import MOST_DRAWN
from rmfs_commands.layouts.hall import hall_svg
from rmfs_commands.trace import Trace
from rmfs_core.clock import to_seconds
from rmfs_core.events import (
    Event,
    PodLifted,
    PodMoveDecided,
    PodStored,
    QueueJoined,
    RobotMoved,
    RobotRested,
    RobotSent,
    TaskAssigned,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.world import Layout
from rmfs_core.world.grid import STEPS

SHARES = (1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 1)
"""Upper ends of the classes of a heat map: what most cells have is far below the most. As in the replay."""


class Floor:
    """Follows the events of a trace: how often robots drove into each cell, and how long they waited there for others.

    Waiting is that of ``waiting_s`` in robots.csv: on a way for a visit, neither driving nor turning nor lifting.

    Parameters
    ----------
    begin
        The tick from which on is counted.
    """

    def __init__(self, begin: int) -> None:
        self._begin = begin
        self._handlers: Mapping[type[Event], Callable[[Any], None]] = {
            TaskAssigned: lambda event: self._turn(event.robot, event.tick, under_way=True),
            RobotMoved: self._moved,
            PodLifted: self._lifted,
            QueueJoined: lambda event: self._turn(event.robot, event.tick),
            VisitStarted: self._started,
            VisitEnded: lambda event: self._turn(self._at[event.pod], event.tick, under_way=True),
            PodStored: self._stored,
            PodMoveDecided: self._moves,
            RobotSent: lambda event: self._turn(event.robot, event.tick),
            RobotRested: lambda event: self._turn(event.robot, event.tick),
        }

    def start(self, trace: Trace) -> None:
        """Begin with what a run started from."""
        cells, robots = len(trace.layout.kind), len(trace.robots)
        self._steps = [across + down * trace.layout.width for across, down in STEPS]
        self._under_way, self._moving, self._free = [False] * robots, [False] * robots, [0] * robots
        self._at = {i: pod["robot"] for i, pod in enumerate(trace.pods) if pod["robot"] is not None}
        self.traffic = [0] * cells
        self.waiting = [0] * cells
        """Times and ticks, by cell."""

    def follow(self, event: Event) -> None:
        """Take an event."""
        if (handler := self._handlers.get(type(event))) is not None:
            handler(event)

    def _turn(self, robot: int, tick: int, *, under_way: bool = False) -> None:
        self._under_way[robot], self._moving[robot], self._free[robot] = under_way, False, tick

    def _busy(self, robot: int, cell: int, start: int, tick: int) -> None:
        since = max(self._free[robot], self._begin)
        if start > since and self._under_way[robot]:
            self.waiting[cell] += start - since
        self._free[robot] = tick

    def _moved(self, event: RobotMoved) -> None:
        self._busy(event.robot, event.origin, event.start_tick + event.wait_ticks, event.tick)
        if event.tick >= self._begin:
            step = self._steps[event.heading]
            for i in range(1, event.distance_m + 1):
                self.traffic[event.origin + i * step] += 1

    def _lifted(self, event: PodLifted) -> None:
        self._busy(event.robot, event.cell, event.start_tick, event.tick)
        if not self._moving[event.robot]:
            self._turn(event.robot, event.tick, under_way=True)

    def _started(self, event: VisitStarted) -> None:
        self._at[event.pod] = event.robot
        self._turn(event.robot, event.tick)

    def _stored(self, event: PodStored) -> None:
        self._busy(event.robot, event.cell, event.start_tick, event.tick)
        self._turn(event.robot, event.tick)

    def _moves(self, event: PodMoveDecided) -> None:
        self._turn(event.robot, event.tick)
        self._moving[event.robot] = True


@frozen
class Heat:
    """A heat map.

    Parameters
    ----------
    name, title, unit
        Its name in the replay, its title, and its unit.
    svg
        The picture; None of a layout that is too large.
    classes
        Number and range of each class of colours in use.
    """

    name: str
    title: str
    unit: str
    svg: Markup | None
    classes: Sequence[tuple[int, str]]


def heat_maps(trace: Trace, floor: Floor) -> list[Heat]:
    """Return the heat maps of a run: where robots drove, and where they waited."""
    waiting = [to_seconds(ticks) for ticks in floor.waiting]
    return [
        _heat("traffic", "Times that a robot drove into a cell", "", trace, floor.traffic),
        _heat("waiting", "Seconds that robots on a way waited in a cell", "s", trace, waiting),
    ]


def _heat(name: str, title: str, unit: str, trace: Trace, values: Sequence[float]) -> Heat:
    ends = sorted({math.ceil(share * max(values)) for share in SHARES} - {0})
    begins = [1, *(end + 1 for end in ends)]
    ranges = (f"{begin:,} to {end:,}" if begin < end else f"{end:,}" for begin, end in zip(begins, ends, strict=False))
    classes = list(enumerate(ranges, len(SHARES) + 1 - len(ends)))
    layout, svg = trace.layout, None
    if len(values) <= MOST_DRAWN:
        names = {own.station: told["name"] for own, told in zip(layout.stations, trace.stations, strict=True)}
        over = _over(layout, [_class(ends, value) for value in values])
        svg = Markup(hall_svg(layout, names=names, over=over))
    return Heat(name, title, unit, svg, classes)


def _class(ends: Sequence[int], value: float) -> int:
    """Return the class of a figure: 0 for nothing, 6 for the most."""
    if value <= 0:
        return 0
    return next(i for i, end in enumerate(ends) if value <= end) + len(SHARES) + 1 - len(ends)


def _over(layout: Layout, classes: Sequence[int]) -> str:
    """Draw cells by class, runs of a class in a row as one piece of its path, and chargers so that they show."""
    width, paths = layout.width, dict.fromkeys(range(1, len(SHARES) + 1), "")
    for row in range(layout.height):
        column = 0
        for heat, run in groupby(classes[row * width : (row + 1) * width]):
            length = len(list(run))
            if heat:
                paths[heat] += f"M{column} {row}h{length}v1h-{length}z"
            column += length
    heats = "".join(f'<path style="fill:var(--h{heat})" d="{path}"/>' for heat, path in paths.items() if path)
    chargers = "".join(f"M{cell % width}.25 {cell // width}.25h.5v.5h-.5z" for cell in layout.chargers)
    return f'{heats}<path class="charge" d="{chargers}"/>' if chargers else heats
