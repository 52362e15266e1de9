"""Pictures of a recorded run: the warehouse at a time, in the colours of the page."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from attrs import frozen
from PIL import Image, ImageColor, ImageDraw, ImageFont

from rmfs_commands.replay.page import VIEW
from rmfs_commands.replay.positions import Way, ways
from rmfs_commands.replay.reading import Replay
from rmfs_commands.replay.warehouse import WarehouseAt
from rmfs_core.wording import counted
from rmfs_core.world import CellKind
from rmfs_core.world.grid import RESTING

FINER = 2
"""Pictures are drawn so many times larger, and reduced: edges are smooth."""
BESIDE, ABOVE = 3.5, 2
"""Cells next to the layout for stations and their orders, and above it for the caption."""
CHIPS, MOST_CHIPS = 5, 15
BOLT = ((0.58, 0.1), (0.24, 0.56), (0.46, 0.56), (0.4, 0.9), (0.76, 0.42), (0.53, 0.42))
"""Corners of the sign of a charger, as shares of a cell."""
SAMPLES = 20
Box = tuple[float, float, float, float]


def palette() -> dict[str, str]:
    """Return the light colours of the page by name."""
    style = (VIEW / "style.css").read_text(encoding="utf-8").partition("}")[0]
    return dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", style))


def clock_time(tick: int) -> str:
    """Return a time as ``h:mm:ss``."""
    seconds = tick // 1000
    return f"{seconds // 3600}:{seconds // 60 % 60:02}:{seconds % 60:02}"


@frozen
class _Pen:
    """Draws in cells."""

    draw: ImageDraw.ImageDraw
    scale: float

    def box(self, column: float, row: float, inset: float, size: float = 1.0) -> Box:
        x, y = (column + BESIDE) * self.scale, (row + ABOVE) * self.scale
        return (
            x + inset * self.scale,
            y + inset * self.scale,
            x + (size - inset) * self.scale,
            y + (size - inset) * self.scale,
        )


class Camera:
    """Takes pictures of a run, one after another in time.

    Parameters
    ----------
    replay
        The run.
    width
        Of a picture, in pixels.
    most
        Open items of a pod in the darkest colour; None: as many as a pod of this run has at some time.
    """

    def __init__(self, replay: Replay, width: int, most: int | None = None) -> None:
        self._replay, self._ways = replay, ways(replay)
        self._layout = replay.start.layout
        self._world = WarehouseAt(replay)
        self._colours = palette()
        self._most = most_open(replay) if most is None else most
        self._charges = replay.columns.charges.lines(replay.tick)
        columns = self._layout.width + 2 * BESIDE
        self._scale = width * FINER / columns
        rows = self._layout.height + ABOVE + 1
        self.size = width, 2 * math.ceil(width * rows / columns / 2)  # videos want even numbers
        self._still = self._drawn_still()

    def take(self, tick: int) -> Image.Image:
        """Return the picture of a time that is not before that of the last picture."""
        self._world.go(tick)
        image = self._still.copy()
        pen = _Pen(ImageDraw.Draw(image), self._scale)
        self._caption(pen)
        for pod, cell in self._world.pod_cell.items():
            row, column = divmod(cell, self._layout.width)
            pen.draw.rectangle(pen.box(column, row, 0.12), fill=self._pod_colour(pod))
        for station in range(len(self._layout.stations)):
            self._station(pen, station)
        for cell in self._world.chargers_down:
            self._strike(pen, pen.box(cell % self._layout.width, cell // self._layout.width, 0.04))
        for robot, way in enumerate(self._ways):
            self._robot(pen, robot, way)
        return image.resize(self.size, Image.Resampling.BOX)

    def _drawn_still(self) -> Image.Image:
        colours, layout = self._colours, self._layout
        image = Image.new("RGB", (self.size[0] * FINER, self.size[1] * FINER), colours["page"])
        pen = _Pen(ImageDraw.Draw(image), self._scale)
        for cell, kind in enumerate(layout.kind.tolist()):
            row, column = divmod(cell, layout.width)
            if kind == CellKind.WALL:
                continue
            lane = kind in (CellKind.QUEUE, CellKind.STATION)
            pen.draw.rectangle(pen.box(column, row, 0), fill=colours["lane" if lane else "floor"])
            if kind in RESTING:
                pen.draw.rectangle(pen.box(column, row, 0.06), fill=colours["place"])
            if kind == CellKind.CHARGER:
                left, top, right, bottom = pen.box(column, row, 0)
                bolt = [(left + x * (right - left), top + y * (bottom - top)) for x, y in BOLT]
                pen.draw.polygon(bolt, fill=colours["charge"])
            if kind == CellKind.MAINTENANCE:
                for x, y in ((0.36, 0.12), (0.12, 0.36)):
                    left, top, right, bottom = pen.box(column, row, 0)
                    bar = left + x * (right - left), top + y * (bottom - top)
                    pen.draw.rectangle((*bar, left + right - bar[0], top + bottom - bar[1]), fill=colours["charge"])
        for cell in self._replay.start.blocked:
            row, column = divmod(cell, layout.width)
            pen.draw.rectangle(pen.box(column, row, 0.2), outline=colours["empty"], width=FINER)
        return image

    def _caption(self, pen: _Pen) -> None:
        world = self._world
        said = f"{counted(world.done, 'order')}, {counted(world.picks, 'pick')}, backlog {world.backlog}"
        text = f"{self._replay.name}   {clock_time(world.tick)}   {said}"
        pen.draw.text((self._scale, self._scale), text, self._colours["ink"], _font(self.size[0] / 58), anchor="lm")

    def _pod_colour(self, pod: int) -> str:
        open_items = self._world.open_items(pod)
        edges = (0, *(math.ceil(self._most / part) for part in (8, 4, 2)))
        return self._colours[f"level-{sum(open_items > edge for edge in edges)}"]

    def _station(self, pen: _Pen, station: int) -> None:
        colours, width = self._colours, self._layout.width
        row, column = divmod(self._layout.stations[station].station, width)
        pen.draw.rectangle(pen.box(column, row, 0.04), outline=colours["soft"], width=FINER)
        outward = -1 if column < width / 2 else 1
        working = self._world.is_picking(station)
        picker = pen.box(column + 1.05 * outward, row, 0.04)
        stores, picks = (self._replay.start.stations[station].get(name) for name in ("bundle_capacity", "capacity"))
        shape = pen.draw.ellipse if picks or not stores else pen.draw.rectangle
        shape(picker, fill=colours["work" if working else "rest"])
        centre = ((picker[0] + picker[2]) / 2, (picker[1] + picker[3]) / 2)
        name = self._replay.start.stations[station]["name"]
        pen.draw.text(
            centre, name, colours["card" if working else "ink"], _font(self._scale * 0.62 / FINER), anchor="mm"
        )
        if station in self._world.closed:
            self._strike(pen, picker)
        faint, full = (ImageColor.getrgb(colours[one]) for one in ("page", "accent"))
        chips = [(min(0.35 + 0.2 * n, 1), full, True) for n in self._world.open[station].values()]
        bundle = ImageColor.getrgb(colours["bundle"])
        chips += [(1, bundle, bound) for bound in self._world.bundles[station].values()]
        for i, (share, most, filled) in enumerate(chips[:MOST_CHIPS]):
            across, down = (i % CHIPS) * 0.48, i // CHIPS * 0.48
            left = column + (1.1 + across if outward > 0 else -0.48 - across)
            colour = tuple(round(a + (b - a) * share) for a, b in zip(faint, most, strict=True))
            fill = colour if filled else None
            pen.draw.rectangle(pen.box(left, row + 1.1 + down, 0, 0.38), fill=fill, outline=colour, width=FINER)

    def _strike(self, pen: _Pen, box: Box) -> None:
        """Draw a line across what is closed or out of service."""
        left, top, right, bottom = box
        width = max(round(self._scale * 0.1), FINER)
        pen.draw.line((left, bottom, right, top), fill=self._colours["wait"], width=width)

    def _robot(self, pen: _Pen, robot: int, way: Way) -> None:
        colours, place = self._colours, way.at(self._world.tick)
        pod = self._world.robot_pod.get(robot)
        if pod is not None:
            pen.draw.rectangle(
                pen.box(place.column, place.row, 0.07),
                fill=self._pod_colour(pod),
                outline=colours["moved" if robot in self._world.moving else "ink"],
                width=FINER * 2 if robot in self._world.moving else FINER,
            )
        size = 0.34 if pod is None else 0.27
        body = pen.box(place.column, place.row, 0.5 - size)
        down, busy = robot in self._world.robots_down, robot in self._world.busy
        pen.draw.ellipse(body, fill=colours["rest" if down else "robot" if busy else "idle"])
        x, y = (body[0] + body[2]) / 2, (body[1] + body[3]) / 2
        angle, length = place.heading * math.pi / 2, size * self._scale * 1.2
        end = (x + math.cos(angle) * length, y - math.sin(angle) * length)
        pen.draw.line((x, y, *end), fill=colours["card"], width=max(round(self._scale * 0.11), FINER))
        if down:
            self._strike(pen, body)
        cell = round(place.row) * self._layout.width + round(place.column)
        if self._charges and cell in self._layout.chargers and not place.moving:
            ring, share = pen.box(place.column, place.row, 0.04), self._charges[robot].at(self._world.tick)
            width = max(round(self._scale * 0.12), FINER)
            pen.draw.arc(ring, 0, 360, fill=colours["rest"], width=width)
            pen.draw.arc(ring, -90, -90 + 360 * share, fill=colours["charge"], width=width)


def _font(size: float) -> Any:
    return ImageFont.load_default(max(size, 8) * FINER)


def most_open(replay: Replay) -> int:
    """Return how many open items a pod has at most, at some times of a run."""
    world, most = WarehouseAt(replay), 1
    for i in range(SAMPLES + 1):
        world.go(replay.tick * i // SAMPLES)
        most = max(most, *map(world.open_items, range(len(replay.start.pods))), 1)
    return most


def pictures(replays: Sequence[Replay], ticks: Iterable[int], width: int) -> Iterator[Image.Image]:
    """Yield the pictures of some times, in ascending order; of two runs side by side.

    Parameters
    ----------
    replays
        One run, or two.
    ticks
        The times.
    width
        Of a picture, in pixels.
    """
    most = max(map(most_open, replays))
    cameras = [Camera(replay, width // len(replays) // 2 * 2, most) for replay in replays]
    size = sum(camera.size[0] for camera in cameras), max(camera.size[1] for camera in cameras)
    for tick in ticks:
        whole = Image.new("RGB", size, palette()["page"])
        left = 0
        for camera in cameras:
            whole.paste(camera.take(tick), (left, 0))
            left += camera.size[0]
        yield whole
