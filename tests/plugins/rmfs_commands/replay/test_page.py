"""The page of `rmfs replay`: what it is told, what is in it, also in a notebook; and pictures of a run."""

import base64
import hashlib
import json
import math
import re
import sys
import zlib
from collections import Counter
from collections.abc import Iterator
from functools import partial
from html import unescape
from pathlib import Path

import attrs
import pytest
from PIL import Image, ImageColor, ImageSequence

import rmfs_commands.replay
import rmfs_core
from calling import exit_code, refused
from cases import cases
from rmfs_commands.cli.main import main
from rmfs_commands.details.loading import load_result
from rmfs_commands.replay import notebook
from rmfs_commands.replay.frames import ABOVE, BESIDE, Camera, clock_time, most_open, palette, pictures
from rmfs_commands.replay.page import VIEW, live_page, packed, page
from rmfs_commands.replay.positions import ways
from rmfs_commands.replay.reading import Replay, read_replay
from rmfs_commands.replay.telling import metrics_of, rules_of, summaries, told
from rmfs_commands.replay.video import kind_of, write_pictures, write_video
from rmfs_commands.replay.warehouse import WarehouseAt
from rmfs_commands.results.files import to_json
from rmfs_commands.trace import read_trace
from rmfs_core import InputError
from rmfs_core.events import RobotRested


def test_the_page_is_packed_whole_and_needs_nothing_else(replay: Replay) -> None:
    unpacked = json.loads(zlib.decompress(base64.b64decode(packed(told(replay)))))
    assert unpacked == json.loads(to_json(told(replay)))
    text = page([replay, replay])
    assert text.count('<script type="text/plain" class="run">') == 2
    assert not re.search(
        r"""(?:src|href)=(?!"data:,")|https?://|@import ["u]|url\(|\bfetch\(|^import |^export """, text, re.MULTILINE
    )
    assert "<title>day and day</title>" in text
    assert not re.search(r"\$(title|policy|style|runs|script)\b", text)


def test_the_page_keeps_names_and_scripts_apart(replay: Replay) -> None:
    common = {"default-src": ["'none'"], "img-src": ["data:"], "base-uri": ["'none'"], "form-action": ["'none'"]}
    inline = re.compile(r'<(?P<kind>style|script)(?: type="module")?>(.*?)</(?P=kind)>', re.DOTALL)
    for text, more in ((page([replay]), {}), (live_page("day"), {"connect-src": ["'self'"]})):
        hashes = {}
        for name, content in inline.findall(text):
            digest = hashlib.sha256(content.encode("utf-8")).digest()
            hashes[f"{name}-src"] = [f"'sha256-{base64.b64encode(digest).decode('ascii')}'"]
        (policy,) = re.findall(r'<meta http-equiv="Content-Security-Policy" content="(.*?)">', text)
        rules = {name: sources for name, *sources in map(str.split, policy.split(";"))}
        assert rules == {**common, **more, **hashes}
        assert hashes.keys() == {"style-src", "script-src"}
        assert not re.search(r"<[^>]*\s(?:style|on\w+)=", inline.sub("", text))
    assert "<title>&lt;b&gt;</title>" in page([attrs.evolve(replay, name="<b>")])


def frame_of(shown: rmfs_commands.replay.Page) -> dict[str, str]:
    return {name: unescape(value) for name, value in re.findall(r'([\w-]+)="([^"]*)"', shown._repr_html_())}


def test_the_page_is_shown_in_a_frame(day: Path, short: Path, replay: Replay) -> None:
    shown = rmfs_commands.replay.replay(day, height_px=400)
    frame = frame_of(shown)
    assert shown._repr_html_().startswith("<iframe ")
    assert (frame["srcdoc"], frame["title"]) == (page([replay]), "Replay of day")
    assert "height:400px" in frame["style"]
    assert "allow-same-origin" not in frame["sandbox"]
    assert repr(shown) == "Page(name='day', height_px=400)"
    assert frame_of(rmfs_commands.replay.replay(day, short))["title"] == "Replay of day and short"


called = partial(exit_code, "replay")


def test_pages_are_written_where_asked(day, capsys, short, tmp_path) -> None:
    assert called(str(day)) == 0
    page = day / "replay.html"
    assert capsys.readouterr().out == f"Open {page} in a browser.\n"
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    page.unlink()
    assert called(str(day), str(short), "--out", str(tmp_path / "both.html"), "--quiet") == 0
    assert capsys.readouterr().out == ""
    assert "<title>day and short</title>" in (tmp_path / "both.html").read_text(encoding="utf-8")


def test_a_page_that_is_too_large_is_not_shown(day: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(notebook, "MOST_BYTES", 1000)
    shown = attrs.evolve(rmfs_commands.replay.replay(day), name="<b>")._repr_html_()
    assert shown.startswith("<p>The replay of &lt;b&gt; has 0.1 MB; ")
    assert "<code>rmfs replay</code> writes it as a file" in shown


def test_pictures_and_a_video_from_a_time_to_another(day, tmp_path, capsys) -> None:
    assert called(str(day), "--frames", "2", "--from", "60", "--to", "120", "--out", str(tmp_path)) == 0
    assert capsys.readouterr().out == f"2 pictures in {tmp_path}.\n"
    assert sorted(file.name for file in tmp_path.iterdir()) == ["frame-001.png", "frame-002.png"]
    file = tmp_path / "x.gif"
    assert called(str(day), "--video", str(file), "--from", "60", "--to", "70", "--speed", "5") == 0
    assert capsys.readouterr().out == f"A video in {file}.\n"
    with Image.open(file) as found:
        durations = [frame.info["duration"] for frame in ImageSequence.Iterator(found)]
        assert (found.format, found.info["loop"], sum(durations)) == ("GIF", 0, 2100)


@cases(
    "arguments sentence",
    (("nowhere",), "nowhere: cannot be read"),
    (("DAY", "nowhere"), "nowhere: cannot be read"),
    (("DAY", "--video", "x.webm"), "found the ending '.webm'; expected .gif or .mp4"),
    (("DAY", "--video", "x.gif", "--frames", "3"), "--video: found with --frames; expected one of them"),
    (("DAY", "--video", "x.gif", "--out", "y"), "--out: found with --video x.gif"),
    (("DAY", "--speed", "3"), "--speed: found without --video"),
    (("DAY", "--to", "3"), "--to: found without --frames or --video"),
    (("DAY", "--video", "x.gif", "--speed", "1e-9"), "pictures; expected at most 2,000, by a higher speed or a"),
    (("DAY", "--frames", "3", "--from", "99999"), "--from 99999: the run ends at "),
    (("DAY", "--frames", "3", "--from", "9", "--to", "8"), "--to 8: expected a time from 9 s on"),
    (("DAY", "--out", "DAY"), "cannot be written: a folder has that name"),
)
def test_what_cannot_be_done(day, capsys, arguments, sentence) -> None:
    given = ["replay", *(str(day) if argument == "DAY" else argument for argument in arguments)]
    said = refused(capsys, main, given)
    assert sentence in said
    assert len(said.splitlines()) == 1


NEAREST = "Store a pod in the nearest free storage location; send an order to the nearest packing station."


def test_what_the_page_is_told(replay: Replay, day: Path) -> None:
    found = told(replay)
    assert (found["name"], found["status"]) == ("day", "complete")
    assert found["tick"] == replay.tick > 0
    assert len(found["layout"]["kind"]) == found["layout"]["width"] * found["layout"]["height"]
    assert len(found["orders"]["name"]) == 20
    assert ["Visits per order", f"{replay.metrics['psv_per_order']:.2f}"] in found["metrics"]
    assert found["says"] == load_result(day).summary["bottleneck"]["says"] != []
    assert found["about"]["nearest"] == NEAREST
    assert sum(found["legs"]["n"]) == len(found["legs"]["gap"])
    assert "due" not in found["orders"]
    json.dumps(found, allow_nan=False)


def declared(name: str) -> dict[str, str]:
    text = re.sub(r"//[^\n]*|/\*.*?\*/", "", (VIEW / "types.d.ts").read_text(encoding="utf-8"), flags=re.DOTALL)
    body = re.search(rf"^export type {name} = \{{\n(.*?)^\}};", text, re.DOTALL | re.MULTILINE)
    assert body
    return dict(re.findall(r"^  (\w+): (.*?);$", body[1], re.DOTALL | re.MULTILINE))


def test_the_types_of_the_page_are_what_it_is_told(day: Path) -> None:
    found = told(read_replay(day))
    events = {name: {"tick", *re.findall(r'"(\w+)"', columns)} for name, columns in declared("ToldEvents").items()}
    assert {name: set(columns) for name, columns in found["events"].items()} == events
    run = declared("ToldRun")
    assert found.keys() == run.keys()
    for key, kind in run.items():
        if kind.startswith("{"):
            names = re.findall(r"(\w+)(\??):", kind)
            assert (
                {name for name, optional in names if not optional} <= found[key].keys() <= {name for name, _ in names}
            )
    decisions = {*re.findall(r'"(\w+)"', run["decisions"]), "texts"}
    assert found["decisions"].keys() == decisions


def test_packing_stations_are_told(tmp_path: Path) -> None:
    few = ["instance.orders=6", "rules.pp=free-flow"]
    rmfs_core.run("examples/packing", overrides=few, out=tmp_path, record=["trace"])
    found = told(read_replay(tmp_path))
    assert found["packing"] == {"stations": 2, "boxes": 10, "packers": 1, "sorters": 0, "until_picked": False}
    assert len(found["events"]["order_packed"]["order"]) == 6
    assert [label for label, _ in found["metrics"]][:2] == ["Turn-over time", "Time to packed"]


def test_metrics_are_as_the_summary_has_them() -> None:
    values = {"turnover_s": 1234.56, "picker_utilisation": 0.512, "orders_per_hour": None}
    assert metrics_of(values) == [["Turn-over time", "1,234.6 s"], ["Picker utilisation", "51.2 %"]]


def test_rules_with_parameters_have_their_names() -> None:
    rules = {"poa_pps": {"rule": "lns", "iterations": 3}, "pr": "nearest", "poa": None, "filters": []}
    assert rules_of({"rules": rules}) == {"POA+PPS": "lns", "PR": "nearest"}
    more = {"roa": "first-bundle", "rps": {"rule": "random"}, "idle": "stay", "move": "cache", "activate": "all"}
    assert rules_of({"rules": more}) == {
        "ROA": "first-bundle",
        "RPS": "random",
        "activation": "all",
        "idle": "stay",
        "repositioning": "cache",
    }
    assert summaries({"./my.py:Mine", "nearest"}) == {"nearest": NEAREST}


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
    assert told(replay)["stations"]["bundle_capacity"] == [0, 0, 10]
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


def test_what_pictures_show(replay: Replay) -> None:
    images = list(pictures([replay, replay], [0, replay.tick], 400))
    assert ([image.size for image in images], images[0].width) == ([images[0].size] * 2, 400)
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


def test_all_pictures_or_none(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        write_pictures(tmp_path, failing(), 2)
    with pytest.raises(InputError):
        write_video(tmp_path / "x.gif", failing())
    assert list(tmp_path.iterdir()) == []


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
