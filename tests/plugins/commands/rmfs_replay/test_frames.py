"""Pictures of a run."""

from __future__ import annotations

import math

import pytest
from PIL import Image, ImageColor

from rmfs_replay.frames import ABOVE, BESIDE, Camera, clock_time, most_open, palette, pictures
from rmfs_replay.positions import ways
from rmfs_replay.reading import Replay
from rmfs_replay.warehouse import WarehouseAt

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
