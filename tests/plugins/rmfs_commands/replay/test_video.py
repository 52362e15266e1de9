"""Pictures as files."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from PIL import Image

from rmfs_commands.replay.video import kind_of, write_pictures, write_video
from rmfs_core import InputError


def images(number: int = 3) -> Iterator[Image.Image]:
    """Yield pictures that differ."""
    for i in range(number):
        yield Image.new("RGB", (32, 20), (80 * i, 0, 0))


def failing() -> Iterator[Image.Image]:
    """Yield a picture, and fail."""
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
    """So many PNGs as there are pictures, in a folder that is made."""
    write_pictures(tmp_path / "new" / "frames", images(), 3)
    files = sorted(file.name for file in (tmp_path / "new" / "frames").iterdir())
    assert files == ["frame-001.png", "frame-002.png", "frame-003.png"]
    with Image.open(tmp_path / "new" / "frames" / "frame-003.png") as image:
        assert image.getpixel((5, 5)) == (160, 0, 0)


def test_all_pictures_or_none(tmp_path: Path) -> None:
    """When one cannot be made, none is left."""
    with pytest.raises(InputError):
        write_pictures(tmp_path, failing(), 2)
    with pytest.raises(InputError):
        write_video(tmp_path / "x.gif", failing())
    assert list(tmp_path.iterdir()) == []


def test_a_gif(tmp_path: Path) -> None:
    """It holds each picture for a tenth of a second, and goes round."""
    write_video(tmp_path / "x.gif", images())
    with Image.open(tmp_path / "x.gif") as found:
        assert (found.format, found.n_frames, found.info["duration"], found.info["loop"]) == ("GIF", 3, 100, 0)


def test_an_mp4_by_ffmpeg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is handed the size and every picture's bytes; what it makes takes its place when it has ended."""
    ffmpeg(tmp_path, monkeypatch, "target.write_text(' '.join(sys.argv) + f' {len(told)}')")
    write_video(tmp_path / "made" / "x.mp4", images())
    said = (tmp_path / "made" / "x.mp4").read_text(encoding="utf-8")
    assert "-s 32x20 -r 30 " in said
    assert said.endswith(f" {3 * 32 * 20 * 3}")
    assert [file.name for file in (tmp_path / "made").iterdir()] == ["x.mp4"]


def test_an_ffmpeg_that_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What it says is told, and nothing is left."""
    ffmpeg(tmp_path, monkeypatch, "target.write_text('half'); sys.exit('no codec\\nfor this')")
    with pytest.raises(InputError, match=r"x.mp4: ffmpeg failed: no codec for this$"):
        write_video(tmp_path / "made" / "x.mp4", images())
    assert list((tmp_path / "made").iterdir()) == []


def test_what_no_video_can_be(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Another ending, or an MP4 without ffmpeg."""
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match=r"found the ending '\.avi'; expected \.gif or \.mp4"):
        kind_of(Path("x.avi"))
    with pytest.raises(InputError, match=r"needs the program ffmpeg, which is not there"):
        kind_of(Path("x.mp4"))
    assert kind_of(Path("X.GIF")) == ".gif"
