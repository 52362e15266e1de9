"""Pictures of a run, and pictures as files."""

import math
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from PIL import Image, ImageColor

from rmfs_commands.replay.frames import ABOVE, BESIDE, Camera, clock_time, most_open, palette, pictures
from rmfs_commands.replay.positions import ways
from rmfs_commands.replay.reading import Replay, read_replay
from rmfs_commands.replay.video import kind_of, write_pictures, write_video
from rmfs_commands.replay.warehouse import WarehouseAt
from rmfs_commands.trace import read_trace
from rmfs_core import InputError
from rmfs_core.events import RobotRested

WIDTH = 1200


def colour_at(image: Image.Image, replay: Replay, column: float, row: float) -> tuple[int, ...]:
    scale = WIDTH / (replay.start.layout.width + 2 * BESIDE)
    found = image.getpixel((int((column + 0.5 + BESIDE) * scale), int((row + 0.5 + ABOVE) * scale)))
    assert isinstance(found, tuple)
    return found


def test_robots_and_pods_are_where_they_are(replay: Replay) -> None:
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
    return {colour for _, colour in image.getcolors(image.width * image.height) or []}  # type: ignore[misc]


def test_bundles_closed_stations_and_moved_pods(restocked: Path) -> None:
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
    assert palette()["robot"] == "#d55e00"
    assert {f"level-{level}" for level in range(5)} <= palette().keys()


def test_what_pictures_show(replay: Replay) -> None:
    images = list(pictures([replay, replay], [0, replay.tick], 400))
    assert [image.size for image in images] == [images[0].size] * 2
    assert images[0].width == 400
    assert images[0].height % 2 == 0
    left, right = images[1].crop((0, 0, 200, images[1].height)), images[1].crop((200, 0, 400, images[1].height))
    assert left.tobytes() == right.tobytes()
    world = WarehouseAt(replay)
    world.go(0)
    assert most_open(replay) == max(map(world.open_items, range(len(replay.start.pods))))


@pytest.mark.parametrize(("tick", "text"), [(0, "0:00:00"), (59_999, "0:00:59"), (3_725_000, "1:02:05")])
def test_the_clock(tick: int, text: str) -> None:
    assert clock_time(tick) == text


def images(number: int = 3) -> Iterator[Image.Image]:
    for i in range(number):
        yield Image.new("RGB", (32, 20), (80 * i, 0, 0))


def failing() -> Iterator[Image.Image]:
    yield from images(1)
    raise InputError("the run", "cannot be drawn")


def ffmpeg(folder: Path, monkeypatch: pytest.MonkeyPatch, code: str) -> None:
    """Put a program of that name on the path, which does ``code`` with ``told``, its input, and ``target``."""
    program = folder / "bin" / "ffmpeg"
    program.parent.mkdir()
    head = "import pathlib, sys\ntold, target = sys.stdin.buffer.read(), pathlib.Path(sys.argv[-1])\n"
    program.write_text(f"#!{sys.executable}\n{head}{code}\n", encoding="utf-8")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(program.parent))


def test_pictures_count_from_1(tmp_path: Path) -> None:
    write_pictures(tmp_path / "new" / "frames", images(), 3)
    files = sorted(file.name for file in (tmp_path / "new" / "frames").iterdir())
    assert files == ["frame-001.png", "frame-002.png", "frame-003.png"]
    with Image.open(tmp_path / "new" / "frames" / "frame-003.png") as image:
        assert image.getpixel((5, 5)) == (160, 0, 0)


def test_all_pictures_or_none(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        write_pictures(tmp_path, failing(), 2)
    with pytest.raises(InputError):
        write_video(tmp_path / "x.gif", failing())
    assert list(tmp_path.iterdir()) == []


def test_a_gif(tmp_path: Path) -> None:
    write_video(tmp_path / "x.gif", images())
    with Image.open(tmp_path / "x.gif") as found:
        assert (found.format, found.n_frames, found.info["duration"], found.info["loop"]) == ("GIF", 3, 100, 0)


def test_an_mp4_by_ffmpeg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ffmpeg(tmp_path, monkeypatch, "target.write_text(' '.join(sys.argv) + f' {len(told)}')")
    write_video(tmp_path / "made" / "x.mp4", images())
    said = (tmp_path / "made" / "x.mp4").read_text(encoding="utf-8")
    assert "-s 32x20 -r 30 " in said
    assert said.endswith(f" {3 * 32 * 20 * 3}")
    assert [file.name for file in (tmp_path / "made").iterdir()] == ["x.mp4"]


def test_an_ffmpeg_that_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ffmpeg(tmp_path, monkeypatch, "target.write_text('half'); sys.exit('no codec\\nfor this')")
    with pytest.raises(InputError, match=r"x.mp4: ffmpeg failed: no codec for this$"):
        write_video(tmp_path / "made" / "x.mp4", images())
    assert list((tmp_path / "made").iterdir()) == []


def test_what_no_video_can_be(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match=r"found the ending '\.avi'; expected \.gif or \.mp4"):
        kind_of(Path("x.avi"))
    with pytest.raises(InputError, match=r"needs the program ffmpeg, which is not there"):
        kind_of(Path("x.mp4"))
    assert kind_of(Path("X.GIF")) == ".gif"
