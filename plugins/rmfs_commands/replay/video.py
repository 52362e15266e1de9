"""Pictures of a run as files: PNGs, an animated GIF, or an MP4 where ffmpeg is there."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

from PIL import Image

from rmfs_commands.results.files import AtomicFile, output_folder, staged
from rmfs_core.errors import InputError

RATES = {".gif": 10, ".mp4": 30}
"""Pictures a second, of each kind of video."""
MOST = {".gif": 2_000, ".mp4": 100_000}
"""Pictures that a video may have: those of a GIF are held in memory until it is written."""
WIDTHS = {".gif": 960, ".mp4": 1280}
PICTURE_WIDTH = 1600


def kind_of(file: Path) -> str:
    """Return the ending of a video's name.

    Raises
    ------
    InputError
        When it is none that can be written here.
    """
    kind = file.suffix.lower()
    if kind not in RATES:
        raise InputError(f"--video {file}", f"found the ending {kind!r}; expected {' or '.join(RATES)}")
    if kind == ".mp4" and shutil.which("ffmpeg") is None:
        raise InputError(f"--video {file}", "needs the program ffmpeg, which is not there; expected it, or .gif")
    return kind


def write_pictures(folder: Path, images: Iterator[Image.Image], number: int) -> None:
    """Write PNGs into a folder: all of them, or none. Their names count from 1."""
    digits = max(len(str(number)), 3)
    with staged(output_folder(folder)) as place:
        for i, image in enumerate(images, 1):
            image.save(place / f"frame-{i:0{digits}}.png", optimize=True)


def write_video(file: Path, images: Iterator[Image.Image]) -> None:
    """Write a video, whole or not at all.

    Raises
    ------
    InputError
        When it cannot be written, or ffmpeg fails.
    """
    kind = kind_of(file)
    if kind == ".gif":
        first = next(images)
        with AtomicFile(file) as stream:
            first.save(
                stream, "GIF", save_all=True, append_images=images, duration=1000 // RATES[kind], loop=0, disposal=1
            )
        return
    output_folder(file.parent)
    with staged(file.parent) as place:
        _mp4(place / file.name, images, RATES[kind], str(file))


def _mp4(target: Path, images: Iterator[Image.Image], rate: int, called: str) -> None:
    first = next(images)
    width, height = first.size
    shape = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(rate), "-i", "-"]
    coded = ["-c:v", "libx264", "-pix_fmt", "yuv420p", "-movflags", "+faststart", str(target)]
    command = ["ffmpeg", "-loglevel", "error", "-y", *shape, *coded]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin is not None
        assert process.stderr is not None
        try:
            for image in chain([first], images):
                process.stdin.write(image.tobytes())
            process.stdin.close()
        except BrokenPipeError:
            pass  # ffmpeg says below why it has ended
        said = process.stderr.read().decode("utf-8", "replace")
    if process.returncode:
        why = " ".join(said.split()) or "it gives no reason"
        raise InputError(f"--video {called}", f"ffmpeg failed: {why}")
