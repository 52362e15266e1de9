"""Pictures of a run."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path

import pytest
from PIL import Image, ImageColor

from rmfs_commands.replay.frames import ABOVE, BESIDE, Camera, clock_time, most_open, palette, pictures
from rmfs_commands.replay.positions import ways
from rmfs_commands.replay.reading import Replay, read_replay
from rmfs_commands.replay.warehouse import WarehouseAt
from rmfs_commands.trace import read_trace
from rmfs_core.events import RobotRested

WIDTH = 1200


def colour_at(image: Image.Image, replay: Replay, column: float, row: float) -> tuple[int, ...]:
    """Return the colour in the middle of a cell."""
    scale = WIDTH / (replay.start.layout.width + 2 * BESIDE)
    found = image.getpixel((int((column + 0.5 + BESIDE) * scale), int((row + 0.5 + ABOVE) * scale)))
    assert isinstance(found, tuple)
    return found


def test_robots_and_pods_are_where_they_are(replay: Replay) -> None:
    """A pod has the colour of what orders want from it; a robot with a task is seen at its place, idle ones greyer."""
    tick = replay.tick // 3
    image = Camera(replay, WIDTH).take(tick)
    colours, world = palette(), WarehouseAt(replay)
    world.go(tick)
    rgb = {name: ImageColor.getrgb(value) for name, value in colours.items()}
    standing = {divmod(cell, replay.start.layout.width): pod for pod, cell in world.pod_cell.items()}
    for robot, way in enumerate(ways(replay)):
        place = way.at(tick)
        angle = place.heading * math.pi / 2  # where it looks, its light mark is
        seen = colour_at(image, replay, place.column - 0.16 * math.cos(angle), place.row + 0.16 * math.sin(angle))
        assert seen == rgb["robot" if robot in world.busy else "idle"]
        standing.pop((round(place.row), round(place.column)), None)
    assert len(standing) > 5
    for (row, column), pod in standing.items():
        seen = colour_at(image, replay, column, row)
        assert seen in [rgb[f"level-{level}"] for level in range(5)]
        assert (seen == rgb["level-0"]) == (world.open_items(pod) == 0)


def colours_in(image: Image.Image) -> set[tuple[int, ...]]:
    """Return every colour of a picture."""
    return {colour for _, colour in image.getcolors(image.width * image.height) or []}  # type: ignore[misc]


def test_bundles_closed_stations_and_moved_pods(restocked: Path) -> None:
    """Each has a colour that is seen when there is one, and no other time."""
    replay = read_replay(restocked)
    camera, world, seen = Camera(replay, WIDTH), WarehouseAt(replay), Counter[tuple[str, bool]]()
    rgb = {name: ImageColor.getrgb(value) for name, value in palette().items()}
    for tick in range(0, replay.tick, replay.tick // 25):
        world.go(tick)
        found = colours_in(camera.take(tick))
        there = {
            "bundle": any(bound for bundles in world.bundles for bound in bundles.values()),
            "moved": bool(world.moving & world.robot_pod.keys()),
        }
        for name, is_there in there.items():
            assert (rgb[name] in found) == is_there
            seen[name, is_there] += 1
    assert len(seen) == 4


def test_chargers_and_how_full_batteries_are(charged: Path) -> None:
    """A charger has a sign; around a robot that stands there a ring closes as its battery is filled."""
    replay = read_replay(charged)
    camera, charge = Camera(replay, WIDTH), ImageColor.getrgb(palette()["charge"])
    (charger,) = replay.start.layout.chargers
    row, column = divmod(charger, replay.start.layout.width)
    assert colour_at(camera.take(0), replay, column, row) == charge
    (rested, robot) = next(
        (e.tick, e.robot) for e in read_trace(charged / "trace.jsonl.gz").events if isinstance(e, RobotRested)
    )
    line = replay.columns.charges.lines(replay.tick)[robot]
    full = next(tick for tick in line.ticks if tick > rested) - 1
    rings = [
        sum(n for n, colour in camera.take(tick).getcolors(1 << 24) or [] if colour == charge)
        for tick in (rested, full)
    ]
    assert rings[0] < rings[1]


def test_the_colours_are_those_of_the_page() -> None:
    """The light ones, each a colour."""
    assert palette()["robot"] == "#d55e00"
    assert {f"level-{level}" for level in range(5)} <= palette().keys()


def test_two_runs_stand_beside_each_other(replay: Replay) -> None:
    """Pictures of all times have one size; videos want it even."""
    images = list(pictures([replay, replay], [0, replay.tick], 400))
    assert [image.size for image in images] == [images[0].size] * 2
    assert images[0].width == 400
    assert images[0].height % 2 == 0
    left, right = images[1].crop((0, 0, 200, images[1].height)), images[1].crop((200, 0, 400, images[1].height))
    assert left.tobytes() == right.tobytes()


def test_the_most_open_items(replay: Replay) -> None:
    """As many as at the start, when no order is done."""
    world = WarehouseAt(replay)
    world.go(0)
    assert most_open(replay) == max(map(world.open_items, range(len(replay.start.pods))))


@pytest.mark.parametrize(("tick", "text"), [(0, "0:00:00"), (59_999, "0:00:59"), (3_725_000, "1:02:05")])
def test_the_clock(tick: int, text: str) -> None:
    """Hours, minutes and seconds that have passed."""
    assert clock_time(tick) == text
